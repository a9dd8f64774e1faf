"""Coverage: where the steps of a library can land, how well, and where nothing lands: what to capture next.

The error to expect at an example is that of replay: leave its clip out, blend the others so that they land there
([B] 4.3), and compare the joints. Between the examples it is interpolated over the triangles. It grows where neighbours
are far or unlike, so the library gains most from a step where it is large.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.coverage import EmptyCircle, SpaceCoverage
from usdfoot.model.examples import Examples
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.spaces.footsteps import FootstepSpace, FootstepWeights, build_footstep_space, solve_footsteps
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.side_space import SideSpace

__all__ = ["cover_spaces", "expected_errors", "find_empty_circles"]

SIDEWAYS, AHEAD, BACK = 0.6, 1.0, 0.7
"""How far from the support ball people step without a flight, in leg lengths."""
BESIDE = 0.05
"""Feet come down so far beside the support foot's line, in leg lengths, where nothing shows that they cross it."""
FOOT = np.array([0.15, 0.35])
"""Half the size of what the support foot itself occupies, across and along, in leg lengths."""
GRID = 0.02
"""Distance of the places looked at for empty circles, in leg lengths."""
SMALLEST = 0.1
"""Radius of circles without a landing that are not worth a word, in leg lengths."""


def cover_spaces(
    skeleton: Skeleton, biped: Biped, examples: Examples, *, spaces: FootstepSpaces, most_circles: int = 5
) -> tuple[SpaceCoverage, ...]:
    """Coverage of every style, gait and foot.

    Args:
        skeleton: Of the library.
        biped: Its legs.
        examples: Of the library.
        spaces: Built of them.
        most_circles: Of each space.
    """
    known: dict[int, tuple[FloatArray, tuple[EmptyCircle, ...]]] = {}
    covered = []
    for (style, flight, side), space in sorted(spaces.spaces.items()):
        key = id(space.footsteps)
        if key not in known:  # mirror images share a space
            errors = expected_errors(
                skeleton, biped.pelvis, examples, space=space, landings=spaces.landings[space.examples]
            )
            leg = biped.maximal_leg_length
            known[key] = errors, find_empty_circles(space.footsteps, errors, leg=leg, flight=flight, most=most_circles)
        errors, circles = known[key]
        sides = np.full(len(space.footsteps.vertices), side)
        own = [replace(circle, place=left_landings(circle.place[None], np.array([side]))[0]) for circle in circles]
        covered.append(
            SpaceCoverage(
                skeleton=skeleton.name,
                style=style,
                flight=flight,
                side=side,
                steps=len(space.examples),
                landings=left_landings(space.footsteps.vertices, sides),
                triangles=space.footsteps.triangles,
                hull=space.footsteps.edges,
                errors=errors,
                empty_circles=tuple(own),
            )
        )
    return tuple(covered)


def expected_errors(
    skeleton: Skeleton, pelvis: int, examples: Examples, *, space: SideSpace, landings: FloatArray
) -> FloatArray:
    """Mean distance of the joints to expect at each vertex of a space [m], shape (V,); NaN where nothing else is left.

    Of a space with one clip only the example itself is left out.

    Args:
        skeleton: Of the library.
        pelvis: Its joint.
        examples: Of the library.
        space: One of its spaces.
        landings: Of the space's examples in left-swing coordinates [m], shape (E', 2).
    """
    errors = np.full(len(space.examples), np.nan)
    for left_out in _groups(examples, space):
        rest = np.flatnonzero(~left_out)
        if not rest.size:
            continue
        solved = solve_footsteps(build_footstep_space(landings[rest]), landings[left_out])
        own, others = space.examples[left_out], space.examples[rest[solved.examples]]
        recorded = _joints(skeleton, pelvis, examples, own[:, None], np.ones((len(own), 1)))
        blended = _joints(skeleton, pelvis, examples, others, solved.weights)
        errors[left_out] = np.linalg.norm(blended - recorded, axis=-1).mean(axis=(1, 2))
    members = space.footsteps.members
    known = (members >= 0) & np.isfinite(errors[members])
    sums = np.where(known, errors[members], 0.0).sum(axis=1)
    return np.where(known.any(axis=1), sums / np.maximum(known.sum(axis=1), 1), np.nan)


def _groups(examples: Examples, space: SideSpace) -> Iterator[BoolArray]:
    """Which examples of a space to leave out together: those of a clip, or of a vertex if there is one clip only."""
    clips = examples.clip_indices[space.examples]
    if len(set(clips.tolist())) > 1:
        for clip in np.unique(clips):
            yield clips == clip
        return
    for members in space.footsteps.members:
        yield np.isin(np.arange(len(clips)), members[members >= 0])


def _joints(skeleton: Skeleton, pelvis: int, examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """Joints below the pelvis of blends of examples (N, K), in the heading at the step's end [m], (N, S, J', 3)."""
    below = [pelvis]
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent in below:
            below.append(joint)
    parents = np.array([-1, *(below.index(int(skeleton.parents[joint])) for joint in below[1:])])
    turns = quaternion.yaw_quaternion(-examples.turns[chosen])[:, :, None]  # (N, K, 1, 4)
    rotations = examples.rotations[chosen][:, :, :, below].astype(float)  # (N, K, S, J', 4)
    rotations[..., 0, :] = quaternion.compose(turns, rotations[..., 0, :])
    places = quaternion.rotate(turns, examples.pelvis_positions[chosen].astype(float))
    heaviest = np.take_along_axis(rotations, np.argmax(weights, axis=1)[:, None, None, None, None], axis=1)
    summed = np.einsum("nk,nksji->nsji", weights, quaternion.align_signs(rotations, heaviest))
    translations = np.tile(skeleton.rest_translations[below], (*summed.shape[:2], 1, 1))
    translations[:, :, 0] = np.einsum("nk,nksi->nsi", weights, places)
    return forward_kinematics(parents, translations, quaternion.normalised(summed))[0]


def find_empty_circles(
    space: FootstepSpace, errors: FloatArray, *, leg: float, flight: bool, most: int = 5
) -> tuple[EmptyCircle, ...]:
    """The largest circles without a landing, apart from each other, largest first.

    Their centres lie in the hull or, in gaits without flight, within what people step.

    Args:
        space: Landings in left-swing coordinates.
        errors: Expected at its vertices [m], shape (V,).
        leg: Length of the leg [m].
        flight: Whether the steps have a flight.
        most: Circles at most.
    """
    places = _places(space, leg, flight)
    solved = solve_footsteps(space, places)
    inside = solved.hull_distances <= 0.0
    steppable = np.hypot(places[:, 0] / SIDEWAYS, places[:, 1] / np.where(places[:, 1] > 0.0, AHEAD, BACK)) <= leg
    allowed = inside | (steppable & (places[:, 0] >= BESIDE * leg) & (not flight))
    allowed &= np.linalg.norm(places / (leg * FOOT), axis=1) > 1.0
    radii = np.where(allowed, cKDTree(space.vertices).query(places)[0], 0.0)
    expected = np.where(inside, _interpolated(solved, errors), np.nan)
    circles: list[EmptyCircle] = []
    while len(circles) < most and radii.max(initial=0.0) >= SMALLEST * leg:
        row = int(np.argmax(radii))
        circles.append(
            EmptyCircle(
                place=places[row],
                radius=float(radii[row]),
                inside=bool(inside[row]),
                expected_error=float(expected[row]),
            )
        )
        radii = np.where(np.linalg.norm(places - places[row], axis=1) < radii[row], 0.0, radii)
    return tuple(circles)


def _places(space: FootstepSpace, leg: float, flight: bool) -> FloatArray:
    """Grid points (N, 2) over the hull and, without flight, what people step [m]."""
    corners = space.vertices
    if not flight:
        corners = np.vstack([corners, leg * np.array([[0.0, -BACK], [SIDEWAYS, AHEAD]])])
    low, high = corners.min(axis=0), corners.max(axis=0)
    axes = [np.arange(low[i], high[i] + GRID * leg, GRID * leg) for i in (0, 1)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


def _interpolated(solved: FootstepWeights, errors: FloatArray) -> FloatArray:
    """Errors at the queries by the weights of their vertices, shape (N,)."""
    return np.sum(solved.weights * np.nan_to_num(errors)[solved.vertices], axis=1)
