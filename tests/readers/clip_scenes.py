"""Scenes with one clip, read as the clip of one character, and where its joints then have to be."""

import numpy as np

from tests.scenes import OFFSETS, Units, add_character, add_clip, new_stage, walk_pose
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.characters import read_character
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.clips import read_clip
from usdfoot.readers.stage import collect_prims, read_stage_info

TIMES = np.arange(0.0, 1.0, 1.0 / 30.0)


def read(stage, path="/World/walk", character="/World/Hero"):
    """The clip on the character, and the character."""
    units = read_stage_info(stage).units
    actor = read_character(stage.GetPrimAtPath(character), units, np.zeros(1))
    finder = ClipFinder(stage, collect_prims(stage))
    source = finder.source_of(stage.GetPrimAtPath(path), stage.GetPrimAtPath(f"{character}/{actor.skeleton_path}"))
    return read_clip(source, actor.skeleton, actor.biped, units=units), actor


def positions(clip, actor):
    return forward_kinematics(actor.skeleton.parents, clip.translations, clip.rotations)[0]


def expected_positions(times=TIMES, offsets=OFFSETS):
    parents = np.array([-1, 0, 1, 0, 3, 4, 5, 0, 7, 8, 9])
    return forward_kinematics(parents, *walk_pose(times, offsets))[0]


def scene(units=None, *, times=TIMES, **clip_options):
    units = units or Units()
    stage = new_stage(None, units)
    add_character(stage, "/World/Hero", units)
    add_clip(stage, "/World/walk", units, times, *walk_pose(times), **clip_options)
    return stage
