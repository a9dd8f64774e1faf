"""Contact events as UsdfootClipAPI attributes in a layer over the clips, for an artist to correct."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pxr import Sdf

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.model.contacts import Contacts
from usdfoot.writers.clip_prims import MadeClip, define_clip
from usdfoot.writers.layers import apply_schemas, author
from usdfoot.writers.layers_over import author_times, layer_over
from usdfoot.writers.staging import staged_files

__all__ = ["author_events", "write_clip_events"]


def write_clip_events(
    output: str | os.PathLike[str],
    contacts: Mapping[str, Contacts],
    *,
    info: StageInfo,
    default_prim: str,
    styles: Mapping[str, str],
    made: Sequence[MadeClip] = (),
) -> Path:
    """Write a layer that sublayers the clips' stage and authors the events of each clip over it.

    Events that lie outside a clip are left out: a foot that stands when the clip begins has no strike there.

    Args:
        output: File to write; the clips' own layers are not touched.
        contacts: Contacts by prim path of the clip.
        info: Of the clips' stage.
        default_prim: Its default prim.
        styles: Styles to author, by prim path of the clip.
        made: Synthetic clips to add; their contacts are among the `contacts`.

    Returns:
        The file written.

    Raises:
        OutputError: If the file is one of the clips' layers or cannot be written.
    """
    target, layer = layer_over(output, info, default_prim=default_prim)
    for path, clip_contacts in contacts.items():
        prim = Sdf.CreatePrimInLayer(layer, path)
        apply_schemas(prim, [tokens.Schema.CLIP])
        if path in styles:
            author(prim, tokens.Clip.STYLE, Sdf.ValueTypeNames.Token, value=styles[path], uniform=True)
        author_events(prim, clip_contacts, info.units)
    for clip in made:
        define_clip(layer, clip, info.units)
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def author_events(prim: Sdf.PrimSpec, contacts: Contacts, units: StageUnits) -> None:
    """Strike, flat and liftoff times of both feet as UsdfootClipAPI attributes, those within the clip.

    Of a foot that stands from the first sample to the last there are none: empty, they would say that it never does.
    """
    for side in (0, 1):
        foot = contacts[side]
        if foot.only_stands:
            continue
        begun = np.isfinite(foot.strike_times)
        author_times(prim, tokens.Clip.STRIKE_TIMES[side], _finite(foot.strike_times), units=units)
        author_times(prim, tokens.Clip.FLAT_TIMES[side], _finite(foot.flat_times[begun]), units=units)
        author_times(prim, tokens.Clip.LIFTOFF_TIMES[side], _finite(foot.liftoff_times), units=units)


def _finite(times: FloatArray) -> FloatArray:
    return times[np.isfinite(times)]
