"""Blend shapes that clips carry: blended by the weights of their steps at the steps' phases, the seams closed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.analysis.examples import times_of_phases
from usdfoot.engine.clock_kernel import read_samples
from usdfoot.engine.kernels import SegmentArrays
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples

__all__ = ["ExampleShapes", "blend_shapes", "sample_shapes"]

_SEAM = 0.2
"""Time from a strike in which half of a jump there fades, at most half the segment [s]."""


@dataclass(frozen=True, kw_only=True)
class ExampleShapes:
    """Weights of B blend shapes in every example."""

    names: tuple[str, ...]
    weights: FloatArray
    """At evenly spaced phases, shape (E, S, B)."""


def sample_shapes(library: ClipLibrary, examples: Examples) -> ExampleShapes | None:
    """The shapes of all clips at the phases of their steps; 0 where a clip has not the shape, None if none has any.

    Args:
        library: Clips.
        examples: Cut from them; the last is a stand, which has the means of its clip.
    """
    names = tuple(dict.fromkeys(name for clip in library.clips if clip.shapes for name in clip.shapes.names))
    if not names:
        return None
    count, samples = examples.rotations.shape[:2]
    steps = slice(0, count - 1)
    events = (examples.durations[steps], examples.swing_liftoffs[steps], examples.support_liftoffs[steps])
    times = examples.start_times[steps, None] + times_of_phases(*events, samples=samples)
    weights = np.zeros((count, samples, len(names)))
    for index, clip in enumerate(library.clips):
        if clip.shapes is None:
            continue
        columns = [names.index(name) for name in clip.shapes.names]
        rows = np.flatnonzero(examples.clip_indices[steps] == index)
        first, last = clip.times[[0, -1]]
        at = np.where(times[rows] > last, times[rows] - (last - first), times[rows])  # steps over the end of a cycle
        for column, track in zip(columns, clip.shapes.weights.T, strict=True):
            weights[rows, :, column] = np.interp(at, clip.times, track)
            if examples.clip_indices[-1] == index:
                weights[-1, :, column] = track.mean()
    return ExampleShapes(names=names, weights=weights)


def blend_shapes(
    shapes: ExampleShapes, setup: Setup, blend: StepBlend, *, arrays: SegmentArrays, rows: IntArray, times: FloatArray
) -> FloatArray:
    """Weights of segments `rows` (F,) at `times` [s] (F,), shape (F, B)."""
    segments = setup.segments
    phases = _phases(setup, arrays, rows, times, shapes.weights.shape[1] - 1)
    before = np.minimum(phases.astype(int), shapes.weights.shape[1] - 2)
    part = (phases - before)[:, None, None]
    examples, weights = blend.examples[rows], blend.weights[rows]
    at, after = (shapes.weights[examples, index[:, None]] for index in (before, before + 1))  # (F, 4, B)
    blended = np.einsum("fk,fkb->fb", weights, (1.0 - part) * at + part * after)
    ends = [np.einsum("mk,mkb->mb", blend.weights, shapes.weights[blend.examples, index]) for index in (0, -1)]
    jumps = np.zeros((len(segments) + 1, len(shapes.names)))
    jumps[1:-1] = np.where(segments.joined[1:-1, None], ends[0][1:] - ends[1][:-1], 0.0)
    length = np.minimum(_SEAM, 0.5 * (segments.ends - segments.begins))[rows]
    since, until = times - segments.begins[rows], segments.ends[rows] - times
    faded: FloatArray = (
        blended - 0.5 * _left(since, length) * jumps[rows] + 0.5 * _left(until, length) * jumps[rows + 1]
    )
    return faded


def _phases(setup: Setup, arrays: SegmentArrays, rows: IntArray, times: FloatArray, last: int) -> FloatArray:
    """Where the segments are in the examples' samples, 0 to `last`, shape (F,)."""
    clock = times - setup.contacts.starts[setup.segments.agents[rows]]
    samples = wp.empty(len(rows), dtype=wp.float32)
    on_device = [wp.array(rows.astype(np.int32), dtype=wp.int32), wp.array(clock, dtype=wp.float64)]
    inputs = [arrays.clocks, *on_device, float(last)]
    wp.launch(read_samples, dim=len(rows), inputs=inputs, outputs=[samples])
    phases: FloatArray = samples.numpy().astype(float)
    return phases


def _left(time: FloatArray, length: FloatArray) -> FloatArray:
    """Part of a jump that is left at a time from it, shape (F, 1)."""
    rest = 1.0 - np.clip(time / np.maximum(length, 1e-6), 0.0, 1.0)
    left: FloatArray = (rest * rest * (3.0 - 2.0 * rest))[:, None]
    return left
