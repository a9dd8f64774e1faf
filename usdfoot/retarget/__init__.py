"""Retarget: clips of one rig on the joints of another."""
