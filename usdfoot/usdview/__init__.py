"""The usdview plugin: a menu, and commands that are plain functions of a stage, what is selected in it, and a time."""
