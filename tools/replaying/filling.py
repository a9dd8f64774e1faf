"""Libraries with their holes filled, as `usdfoot analyze --fill` would, without a stage."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from replaying.leave_out import with_examples
from usdfoot.analysis.examples import build_examples
from usdfoot.engine.animate import PreparedLibrary
from usdfoot.model.examples import Examples
from usdfoot.physics.fill import fill_library
from usdfoot.planning.reach import reach_of_biped
from usdfoot.spaces.holes import HoleOptions

__all__ = ["with_fill"]


def with_fill(library: PreparedLibrary, *, gap: float) -> PreparedLibrary:
    """The prepared library with synthetic steps for the holes that its own clips leave.

    Args:
        library: Some clips; what was left out of it is not used.
        gap: Altitude of a triangle of landings that is a hole [m].
    """
    outline = reach_of_biped(library.source.biped).outline
    made = fill_library(library, outline, name="/Replay/synthetic_", holes=HoleOptions(gap=gap))
    if not made.clips:
        return library
    synthetic, _ = build_examples(
        replace(library.source, clips=made.clips), samples=library.examples.rotations.shape[1]
    )
    joined = _joined(library.examples, synthetic)
    return with_examples(library, joined, synthetic=joined.clip_indices >= len(library.examples.clip_names))


def _joined(examples: Examples, added: Examples) -> Examples:
    """The examples with others before the stand, which is the last."""
    values: dict[str, Any] = {}
    for field in fields(Examples):
        own, new = getattr(examples, field.name), getattr(added, field.name)
        if isinstance(own, np.ndarray):
            new = new + len(examples.clip_names) if field.name == "clip_indices" else new
            values[field.name] = np.concatenate([own[:-1], new, own[-1:]])
    names, styles = (
        (*examples.clip_names, *added.clip_names),
        (*examples.styles[:-1], *added.styles, examples.styles[-1]),
    )
    return replace(examples, clip_names=names, styles=styles, **values)
