"""usdfoot plugin-path: what other USD programs need to find usdfoot's plugins."""

from __future__ import annotations

import argparse
import os

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "plugin-path"
HELP = "print what to put on PXR_PLUGINPATH_NAME"
DESCRIPTION = (
    "Prints the folders of the schemas, the validators and the usdview plugin, joined for PXR_PLUGINPATH_NAME. "
    "usdview's Python must be able to import usdfoot too: install it there, or put it on PYTHONPATH."
)
EPILOG = """\
example:
  usdfoot plugin-path
  export PXR_PLUGINPATH_NAME="$(usdfoot plugin-path):$PXR_PLUGINPATH_NAME"
  usdview build/walk/crowd.usd    # menu Usdfoot

exit codes: 0 printed

in Python:
  from usdfoot.pipeline.plugins import plugin_folders
  print(plugin_folders())
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments: none."""


def run(arguments: argparse.Namespace) -> int:
    """Print the path."""
    from usdfoot.pipeline.plugins import plugin_folders

    print(os.pathsep.join(str(folder) for folder in plugin_folders()))
    return 0
