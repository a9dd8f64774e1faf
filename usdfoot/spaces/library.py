"""All footstep spaces of a library: one for each style, kind of gait and swing side, mirror images sharing one.

Fast steps with a short flight, as between walk and run, are in the spaces of both gaits.

Landings are kept as if the left foot swung: those of the right foot with x negated. Where the library holds the mirror
image of every step, both sides use one space, built once, each with its own examples; so a mirrored plan gets exactly
the mirrored examples with the same weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.analysis.timing import HUMAN_LEG
from usdfoot.errors import ClipError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray, StyleArray
from usdfoot.model.biped import LEFT, RIGHT, SIDES
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.spaces.corner_kernel import SpaceArrays
from usdfoot.spaces.device_spaces import device_spaces, device_velocities
from usdfoot.spaces.end_poses import EndPoses, build_end_poses
from usdfoot.spaces.features import DOUBT, FeatureScales, StepFeatures, example_features, step_coordinates
from usdfoot.spaces.footsteps import solve_footsteps
from usdfoot.spaces.landings import end_landings, left_landings, root_velocities
from usdfoot.spaces.mirror_partners import mirror_partners
from usdfoot.spaces.neighbours import solve_neighbours
from usdfoot.spaces.root_choice_kernel import VelocityArrays
from usdfoot.spaces.side_space import SideSpace, blend_doubts, build_side_space

__all__ = [
    "FootstepSpaces",
    "StepWeights",
    "build_spaces",
    "solve_steps",
    "spaces_of",
]

BACKWARD = -0.1
"""Landings further back than this [m] are walked whatever the flight: going backward the ball leaves the ground first
and the heel still stands, so the ball's contacts show a flight that is none."""

SAME_LANDING = 1e-3
"""Mirror images that land this near each other's mirrored landing share a space [m]; legs of unequal length do not."""


@dataclass(frozen=True, kw_only=True)
class FootstepSpaces:
    """The spaces of a library."""

    spaces: Mapping[tuple[str, bool, int], SideSpace]
    """By style, flight and swing side; there is none for a combination without examples."""
    landings: FloatArray
    """Landings of all the library's examples in left-swing coordinates, (x, z) [m], shape (E, 2)."""
    velocities: FloatArray
    """Their root velocities, likewise, (x, z) [m/s], shape (E, 2)."""
    coordinates: FloatArray
    """Their scaled landings and features, likewise, shape (E, D)."""
    poses: EndPoses | None
    """Of all the library's examples, if they have more than one style."""
    scales: FeatureScales
    """What was used to build the neighbour spaces."""
    leg_length: float
    """Of the character, straight [m]: what is fast depends on it."""

    def group(
        self, landings: FloatArray, *, swing_sides: IntArray, flights: BoolArray, styles: Sequence[str] | StyleArray
    ) -> Iterator[tuple[SideSpace, IntArray]]:
        """The spaces that N steps ask, each with its steps; landings (N, 2) in left-swing coordinates [m].

        Raises:
            ClipError: If a style has no step of a swing side.
        """
        names, sides = np.asarray(styles, dtype=object), np.asarray(swing_sides)
        runs = np.asarray(flights) & (landings[:, 1] > BACKWARD)
        left: BoolArray = np.ones(len(names), dtype=bool)
        while left.any():
            step = np.argmax(left)
            own = left & (names == names[step]) & (runs == runs[step]) & (sides == sides[step])
            yield self.find(names[step], bool(runs[step]), int(sides[step])), np.flatnonzero(own)
            left &= ~own

    def numbers(
        self, landings: FloatArray, *, swing_sides: IntArray, flights: BoolArray, styles: Sequence[str] | StyleArray
    ) -> IntArray:
        """Which of the `spaces`, in their order, each of N steps asks, shape (N,); otherwise as `group`."""
        order = {id(space): number for number, space in enumerate(self.spaces.values())}
        numbers = np.zeros(len(landings), dtype=np.intp)
        for space, steps in self.group(landings, swing_sides=swing_sides, flights=flights, styles=styles):
            numbers[steps] = order[id(space)]
        return numbers

    @cached_property
    def device(self) -> SpaceArrays:
        """The spaces as device arrays."""
        return self._on_device(self.coordinates)

    @cached_property
    def device_from_poses(self) -> SpaceArrays:
        """The same with the poses that examples start from among the coordinates, if there are `poses`."""
        starts = [] if self.poses is None else [self.poses.starts]
        return self._on_device(np.column_stack([self.coordinates, *starts]))

    @cached_property
    def device_velocities(self) -> list[VelocityArrays]:
        """The root velocities of each of the `spaces`, in their order, as device arrays."""
        return device_velocities(list(self.spaces.values()), velocities=self.velocities, coordinates=self.coordinates)

    def _on_device(self, coordinates: FloatArray) -> SpaceArrays:
        return device_spaces(
            list(self.spaces.values()), landings=self.landings, velocities=self.velocities, coordinates=coordinates
        )

    def find(self, style: str, flight: bool, side: int) -> SideSpace:
        """The space of a style, gait and swing side; that of the other gait if there is no example of this.

        Raises:
            ClipError: If the style has no step of that swing side in either gait.
        """
        for gait in (flight, not flight):
            if (style, gait, side) in self.spaces:
                return self.spaces[style, gait, side]
        known = sorted({name for name, _, other in self.spaces if other == side})
        raise ClipError(
            f"style {style!r}",
            f"no clip shows a step of the {SIDES[side]} foot",
            "add clips of this style, let them be mirrored, or use one of the styles listed",
            known,
        )


@dataclass(frozen=True, kw_only=True)
class StepWeights:
    """Examples and blend weights of N steps, heaviest first."""

    examples: IntArray
    """Index into the library's examples, shape (N, 3)."""
    weights: FloatArray
    """Blend weights, shape (N, 3)."""
    hull_distances: FloatArray
    """Distance of the landing from the examples' hull [m], 0 inside, shape (N,)."""
    projections: FloatArray
    """Landing the weights give, (x, z) in the heading at the step's end [m], shape (N, 2)."""


def spaces_of(
    library: ClipLibrary, examples: Examples, *, polar: bool = True, frame: str = "support"
) -> FootstepSpaces:
    """Spaces of the examples of a library, as its skeleton and legs are; as `build_spaces`."""
    return build_spaces(
        examples,
        pelvis=library.biped.pelvis,
        polar=polar,
        frame=frame,
        leg_length=library.biped.maximal_leg_length,
        synthetic=np.array([clip.synthetic for clip in library.clips])[examples.clip_indices],
    )


def build_spaces(
    examples: Examples,
    *,
    pelvis: int = 0,
    root_merge_distance: float = 0.1,
    polar: bool = True,
    frame: str = "support",
    scales: FeatureScales | None = None,
    leg_length: float = HUMAN_LEG,
    synthetic: BoolArray | None = None,
) -> FootstepSpaces:
    """Footstep spaces of all styles, gaits and swing sides of a library.

    Args:
        examples: The library's steps.
        pelvis: Its joint.
        root_merge_distance: Root velocities at most this far apart [m/s] share one example.
        polar: Root velocities are weighted by polar gradient bands; else by Cartesian ones.
        frame: Where landings are measured from: support = the support ball; root = the root ([B] 4.1).
        scales: Differences between steps that count the same when neighbours are chosen.
        leg_length: Of the character, straight [m].
        synthetic: Examples that were blended from the others; they never seem nearer to a wanted step than these are,
            shape (E,).
    """
    scales = scales or FeatureScales()
    landings = left_landings(end_landings(examples, frame=frame), examples.swing_sides)
    features = example_features(examples).as_left(examples.swing_sides)
    coordinates = step_coordinates(landings, features, scales)
    velocities = left_landings(root_velocities(examples), examples.swing_sides)

    def build(members: IntArray) -> SideSpace:
        if synthetic is not None:
            coordinates[members, DOUBT] = blend_doubts(landings[members], coordinates[members], synthetic[members])
        return build_side_space(
            members,
            landings=landings,
            coordinates=coordinates,
            velocities=velocities,
            polar=polar,
            root_merge_distance=root_merge_distance,
        )

    partners = mirror_partners(examples)
    spaces: dict[tuple[str, bool, int], SideSpace] = {}
    for style, gait, members in _groups(examples, landings, leg_length):
        left, right = (members[examples.swing_sides[members] == side] for side in (LEFT, RIGHT))
        if left.size:
            spaces[style, gait, LEFT] = build(left)
        paired = left.size > 0 and np.array_equal(np.sort(partners[left]), right)
        if paired and np.abs(landings[left] - landings[partners[left]]).max() <= SAME_LANDING:
            coordinates[partners[left], DOUBT] = coordinates[left, DOUBT]
            spaces[style, gait, RIGHT] = replace(spaces[style, gait, LEFT], examples=partners[left])
        elif right.size:
            spaces[style, gait, RIGHT] = build(right)
    return FootstepSpaces(
        spaces=spaces,
        landings=landings,
        velocities=velocities,
        coordinates=coordinates,
        poses=build_end_poses(examples, pelvis) if len(set(examples.styles)) > 1 else None,
        scales=scales,
        leg_length=leg_length,
    )


def _groups(examples: Examples, landings: FloatArray, leg_length: float) -> Iterator[tuple[str, bool, IntArray]]:
    """Styles, flights and the examples of each; what may be either gait is in both."""
    styles, ahead = np.array(examples.styles), landings[:, 1] > BACKWARD
    runs = ahead & has_flight(examples.durations, examples.support_liftoffs, examples.landings, leg_length=leg_length)
    walks = ~(ahead & has_flight(examples.durations, examples.support_liftoffs, np.zeros_like(landings)))
    for style in dict.fromkeys(examples.styles):
        for gait, members in ((False, walks), (True, runs)):
            yield style, gait, np.flatnonzero((styles == style) & members)


def solve_steps(
    spaces: FootstepSpaces,
    landings: FloatArray,
    *,
    swing_sides: IntArray,
    flights: BoolArray,
    styles: Sequence[str] | StyleArray,
    features: StepFeatures | None = None,
) -> StepWeights:
    """Examples and blend weights of steps.

    Args:
        spaces: From `build_spaces`.
        landings: Where each swing ball shall land, (x, z) from the support ball in the heading at the step's end [m],
            shape (N, 2).
        swing_sides: 0 = left, 1 = right, shape (N,).
        flights: Whether the support foot lifts off before the swing foot strikes, shape (N,).
        styles: Style of each step, N of them.
        features: Timing, turn and rise of the steps. If given, the examples are the nearest in these around the
            landing; without, those of the Delaunay triangle ([B] 4.3).

    Raises:
        ClipError: If a style has no step of a swing side.
    """
    count = len(landings)
    queries = left_landings(landings, swing_sides)
    coordinates = None
    if features is not None:
        coordinates = step_coordinates(queries, features.as_left(swing_sides), spaces.scales)
    examples, weights = np.zeros((count, 3), dtype=np.intp), np.zeros((count, 3))
    distances, projections = np.zeros(count), np.zeros((count, 2))
    for space, steps in spaces.group(queries, swing_sides=swing_sides, flights=flights, styles=styles):
        if coordinates is None:
            solved = solve_footsteps(space.footsteps, queries[steps])
        else:
            solved = solve_neighbours(space.neighbours, queries[steps], coordinates[steps])
        examples[steps], weights[steps] = space.examples[solved.examples], solved.weights
        distances[steps], projections[steps] = solved.hull_distances, solved.projections
    return _heaviest_first(examples, weights, distances, left_landings(projections, swing_sides))


def _heaviest_first(
    examples: IntArray, weights: FloatArray, distances: FloatArray, projections: FloatArray
) -> StepWeights:
    order = np.argsort(-weights, axis=1, kind="stable")
    return StepWeights(
        examples=np.take_along_axis(examples, order, axis=1),
        weights=np.take_along_axis(weights, order, axis=1),
        hull_distances=distances,
        projections=projections,
    )
