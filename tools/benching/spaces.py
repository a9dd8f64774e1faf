"""The 3-D space beside triangles with the polar band: accuracy, smoothness and set-up time."""

from __future__ import annotations

import numpy as np

from benching.rigs import walking_crowd
from benching.stopwatch import function_times
from usdfoot.analysis.gaits import has_flight
from usdfoot.engine.animate import PreparedLibrary, prepare_library, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.spaces.features import example_features
from usdfoot.spaces.landings import end_landings, left_landings
from usdfoot.spaces.roots import find_roots
from usdfoot.spaces.side_space import SideSpace
from usdfoot.spaces.tetrahedra import solve_tetrahedra

__all__ = ["space_figures"]

PATHS, POINTS = 60, 200
"""Ways through the space, and queries on each."""


def space_figures(library: ClipLibrary, *, agents: int = 100, frames: int = 240) -> dict[str, dict[str, float]]:
    """Figures of the spaces, by title and part.

    Footsteps: mean error before IK [mm] and root velocity error [m/s] of a crowd's steps, at what set-up time [us a
    step]. Smoothness: the largest change of a weight between neighbouring queries on straight ways through the space,
    200 on each, of landing and speed (3-D) or root velocity (polar band).
    """
    figures = {}
    crowd = walking_crowd(library, agents=agents, frames=frames)
    for title, options in (
        ("triangle and polar band, root weight 0.3", EngineOptions(space="delaunay", root_weight=0.3)),
        ("triangle and polar band, root weight 1", EngineOptions(space="delaunay", root_weight=1.0)),
        ("triangle alone", EngineOptions(space="delaunay")),
        ("tetrahedron (3d)", EngineOptions(space="3d")),
    ):
        prepared = prepare_library(library, options)

        def run(prepared: PreparedLibrary = prepared, options: EngineOptions = options) -> object:
            return prepare_steps(prepared, crowd.agents, crowd, options=options)

        made = prepare_steps(prepared, crowd.agents, crowd, options=options)
        spent = function_times(run, ("weigh_steps",), repeats=10)["weigh_steps"]
        steps = np.flatnonzero(~made.setup.segments.stands)
        figures[title] = {
            "footstep error [mm]": 1e3 * float(made.landings.blend_error[steps].mean()),
            "root velocity error [m/s]": float(made.landings.velocity_error[steps].mean()),
            "largest change of a weight": _roughness(prepared, solid=options.space == "3d"),
            "locate, weights, correction [us]": 1e6 * spent / len(steps),
        }
    return figures


def _roughness(library: PreparedLibrary, *, solid: bool) -> float:
    """Largest change of a weight between neighbours on straight ways between examples, the largest space's."""
    spaces = library.spaces
    space = max(spaces.spaces.values(), key=lambda own: len(own.examples))
    ends = np.random.default_rng(0).integers(0, len(space.examples), (2, PATHS))
    shares = np.linspace(0.0, 1.0, POINTS)[:, None]
    largest = 0.0
    for start, end in ends.T:
        landings, velocities = (
            values[space.examples[start]] * (1.0 - shares) + values[space.examples[end]] * shares
            for values in (spaces.landings, spaces.velocities)
        )
        weights = (
            _solid_weights(space, landings, velocities)
            if solid
            else _band_weights(library, space.examples[start], velocities)
        )
        largest = max(largest, float(np.abs(np.diff(weights, axis=0)).max()))
    return largest


def _solid_weights(space: SideSpace, landings: FloatArray, velocities: FloatArray) -> FloatArray:
    solved = solve_tetrahedra(space.tetrahedra, landings, np.linalg.norm(velocities, axis=1))
    weights = np.zeros((len(landings), len(space.examples)))
    np.add.at(weights, (np.arange(len(landings))[:, None], solved.examples), solved.weights)
    return weights


def _band_weights(library: PreparedLibrary, start: int, velocities: FloatArray) -> FloatArray:
    """Weights of the library's examples (N, E) for velocities wanted of steps that are otherwise like one of them."""
    examples, rows = library.examples, np.full(len(velocities), start)
    sides = examples.swing_sides[rows]
    found = find_roots(
        library.spaces,
        left_landings(velocities, sides),
        end_landings(examples)[rows],
        features=example_features(examples)[rows],
        swing_sides=sides,
        flights=has_flight(examples.durations, examples.support_liftoffs, examples.landings)[rows],
        styles=[examples.styles[start]] * len(rows),
    )
    weights = np.zeros((len(velocities), len(examples)))
    np.add.at(weights, (np.arange(len(velocities))[:, None], found.examples), found.weights)
    return weights
