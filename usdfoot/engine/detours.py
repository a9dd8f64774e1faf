"""Detours of swinging feet: over the terrain between two prints, and around the standing leg (design.md section 7).

Where the ground asks for a steep way up or down, as treads do, a foot also lags behind or hurries ahead on the level,
so that there is time for the height.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.contact_feet import ContactFeet, device_feet
from usdfoot.engine.early_balls import early_heights, still_early
from usdfoot.engine.foot_rows import FootArrays
from usdfoot.engine.hurried_swings import eased_shares, height_speeds, hurried_balls
from usdfoot.engine.legs import LegRig, leg_kinematics
from usdfoot.engine.plant import swinging_foot
from usdfoot.engine.pose_source import Layout, PoseSource
from usdfoot.maths import planar
from usdfoot.maths.splines import spline_shares
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import EDGE_HEIGHT
from usdfoot.model.ground import Ground

__all__ = ["BLIND_HEIGHT", "KNOTS", "plan_detours"]

PASSES = 0.3
"""The swinging foot passes the standing leg where it is less than this ahead of or behind it [m]."""
FARTHEST_ASIDE = 0.15
"""Most that it goes out of its way for that [m]."""
RISES = 0.18
"""Part of the swing's time, at either end, in which the clearance comes and goes: less than the fifth that design.md
section 10 allows."""

KNOTS = 13
"""Knots of a detour, even in the swing's time, both ends included."""

BETWEEN = 4
"""Ground samples from one knot to the next."""

FINE = BETWEEN * (KNOTS - 1) + 1
PROBES = np.union1d(np.arange(0, FINE, BETWEEN), [1, 2, FINE - 3, FINE - 2])
"""Fine samples at which the swing is posed: the knots, and two more near either end where the sole is lowest."""

KNOT_SHARES = spline_shares(np.arange(0, FINE, BETWEEN), np.arange(FINE))
PROBE_SHARES = spline_shares(PROBES, np.arange(FINE))
"""Cubic splines through the knots and through the probes, at all fine samples, shape (FINE, K)."""


def _curve_shares() -> FloatArray:
    """The curves through the knots as they are drawn (`plant.swinging_foot`), at all fine samples, (FINE, KNOTS)."""
    places = np.arange(FINE) / BETWEEN
    rows = np.minimum(places.astype(np.intp), KNOTS - 2)
    x = (places - rows)[:, None]
    unit = np.eye(KNOTS)
    before, start, end, after = (unit[np.clip(rows + offset, 0, KNOTS - 1)] for offset in (-1, 0, 1, 2))
    leaves, arrives = 0.5 * (end - before), 0.5 * (after - start)
    curves = start + x * leaves + x**2 * (3.0 * (end - start) - 2.0 * leaves - arrives)
    return np.asarray(curves + x**3 * (2.0 * (start - end) + leaves + arrives))


def _bumps() -> FloatArray:
    """Knots of curves that rise from the swing's begin to one at a fine sample, and fall until its end, (FINE, KNOTS).

    Over the whole swing on either side, so that no foot shoots up or comes down hard.
    """
    instants, knots = np.linspace(0.0, 1.0, FINE)[1:-1, None], np.linspace(0.0, 1.0, KNOTS)
    near = np.minimum(knots / instants, (1.0 - knots) / (1.0 - instants))
    bumps: FloatArray = np.zeros((FINE, KNOTS))
    bumps[1:-1] = near**2 * (3.0 - 2.0 * near)
    reached = np.einsum("fk,fk->f", _curve_shares(), bumps)
    bumps[1:-1] /= reached[1:-1, None]
    return bumps


BUMPS, CURVES = _bumps(), _curve_shares()

BESIDE = 0.02 * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
"""Where uneven ground is looked at too in mid swing, from a point of the sole, (x, z) [m]: feet do not graze edges."""
AT_PRINT, NEAR_PRINT = 0.08, 0.2
"""Nearer than this to where it leaves or lands a foot keeps less off edges, and less off the other leg: it stands there
[m]."""

BLIND_HEIGHT = 0.6
"""Ground higher than this over both prints is not stepped over: a wall or another level [m]."""


@wp.kernel(enable_backward=False)
def swing_soles(
    rig: LegRig,
    feet: FootArrays,
    contacts: wp.array(dtype=wp.int32),
    sides: wp.array(dtype=wp.int32),
    times: wp.array(dtype=wp.float32),
    pelvis_positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
    balls: wp.array(dtype=wp.vec3f),
    heels: wp.array(dtype=wp.vec3f),
) -> None:
    """The soles' points under ball and heel along the swings."""
    frame = wp.tid()
    side = sides[frame]
    leg = leg_kinematics(rig, side, pelvis_positions[frame], pelvis_rotations[frame], rotations, frame)
    pose = swinging_foot(rig, feet, contacts[frame], side, times[frame], leg)
    balls[frame] = pose.ankle + wp.quat_rotate(pose.rotation, rig.ball_offsets[side])
    balls[frame] -= wp.vec3f(0.0, rig.ball_heights[side], 0.0)
    heels[frame] = pose.ankle + wp.quat_rotate(pose.rotation, rig.heel_offsets[side])


def plan_detours(
    layout: Layout, source: PoseSource, feet: ContactFeet, *, ground: Ground, rows: IntArray
) -> FloatArray:
    """What to add to the swings after contacts `rows` (N,) so that the sole clears the terrain and the standing leg.

    Returns:
        Offsets at KNOTS instants of each swing [m], shape (N, KNOTS, 3).
    """
    contacts = layout.contacts
    begins, ends = contacts.liftoffs[rows], contacts.strikes[rows + 2]
    times = begins[:, None] + (ends - begins)[:, None] * (PROBES / (FINE - 1))
    soles = _soles(layout, source, feet, np.repeat(rows, len(PROBES)), times.ravel())
    balls, heels = (PROBE_SHARES @ points.reshape(-1, len(PROBES), 3) for points in soles)
    offsets = _beside_leg(layout, rows, balls[:, ::BETWEEN])
    aside = KNOT_SHARES @ offsets
    paths = balls + aside
    missing = _missing_heights(layout, rows, paths, heels + aside, ground)
    speeds = height_speeds(missing, ends - begins)
    shares = eased_shares(missing, ends - begins, speeds)
    eased = np.flatnonzero(shares.max(axis=1, initial=0.0) > 0.0)
    if eased.size:
        hurry = hurried_balls(balls[eased], speeds[eased], shares[eased])
        offsets[eased] = _beside_leg(layout, rows[eased], (balls[eased] + hurry)[:, ::BETWEEN])
        aside = KNOT_SHARES @ offsets[eased] + hurry
        offsets[eased] += hurry[:, ::BETWEEN]
        paths[eased] = balls[eased] + aside
        missing[eased] = _missing_heights(layout, rows[eased], paths[eased], heels[eased] + aside, ground)
    lifts = _lifts(missing)
    paths[..., 1] += np.einsum("nk,fk->nf", lifts, CURVES)  # a matrix product would start threads
    offsets[..., 1] += lifts + _lifts(still_early(paths, contacts.positions[rows + 2], durations=ends - begins))
    return offsets


def _soles(
    layout: Layout, source: PoseSource, feet: ContactFeet, rows: IntArray, times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Soles under ball and heel of the swings after contacts `rows` at `times` [s], world, shape (F, 3) each."""
    contacts, segments = layout.contacts, layout.segments
    agents = contacts.agents[rows]
    frame_segments = locate(segments.agents, segments.begins, contacts.starts, agents=agents, times=times)
    poses = source.pose(frame_segments, times, joints=layout.rig.leg_joints)
    balls, heels = wp.empty(len(rows), dtype=wp.vec3f), wp.empty(len(rows), dtype=wp.vec3f)
    wp.launch(
        swing_soles,
        dim=len(rows),
        inputs=[
            layout.rig.arrays,
            device_feet(layout, feet, np.zeros((len(contacts.sides), 2, 3))),
            wp.array(rows.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(contacts.sides[rows].astype(np.int32), dtype=wp.int32, copy=False),
            wp.array((times - contacts.starts[agents]).astype(np.float32), dtype=wp.float32, copy=False),
            poses.pelvis_positions,
            poses.pelvis_rotations,
            poses.rotations,
        ],
        outputs=[balls, heels],
    )
    origins = layout.origins[agents]
    return balls.numpy() + origins, heels.numpy() + origins


def _beside_leg(layout: Layout, rows: IntArray, balls: FloatArray) -> FloatArray:
    """Sideways offsets (N, KNOTS, 3) that keep the swinging ball off the standing one while it passes."""
    contacts = layout.contacts
    heading = contacts.headings[rows + 1][:, None]
    apart = planar.rotate(-heading, (balls - contacts.positions[rows + 1][:, None])[..., [0, 2]])
    outward = np.where(contacts.sides[rows] == 0, 1.0, -1.0)[:, None]
    ahead = np.clip(1.0 - np.abs(apart[..., 1]) / PASSES, 0.0, 1.0)
    wanted = layout.options.foot_spacing * ahead**2 * (3.0 - 2.0 * ahead) * (ahead > 0.0)
    missing = np.where(ahead > 0.0, np.clip(wanted - outward * apart[..., 0], 0.0, FARTHEST_ASIDE), 0.0)
    push = _envelope(missing * _aside_shares(balls[..., [0, 2]], NEAR_PRINT))
    offsets = planar.rotate(heading, np.stack([outward * push, np.zeros_like(push)], axis=-1))
    return np.stack([offsets[..., 0], np.zeros_like(push), offsets[..., 1]], axis=-1)


def _aside_shares(places: FloatArray, near: float) -> FloatArray:
    """0 at either end of paths (N, K, 2), 1 from `near` [m] away from both, shape (N, K)."""
    away = [np.linalg.norm(places - places[:, [end]], axis=-1) for end in (0, -1)]
    return np.clip(np.minimum(*away) / near, 0.0, 1.0)


def _missing_heights(
    layout: Layout, rows: IntArray, balls: FloatArray, heels: FloatArray, ground: Ground
) -> FloatArray:
    """What ball and heel (N, FINE, 3) lack to be over the terrain, with clearance in mid swing [m], shape (N, FINE).

    And the ball not to stand before it strikes.
    """
    fractions = np.linspace(0.0, 1.0, FINE)
    durations = layout.contacts.strikes[rows + 2] - layout.contacts.liftoffs[rows]
    middle = np.clip(np.minimum(fractions, 1.0 - fractions) / RISES, 0.0, 1.0)
    clearance = layout.options.clearance * middle**2 * (3.0 - 2.0 * middle)
    early = early_heights(balls, layout.contacts.positions[rows + 2], durations=durations)
    highest = np.maximum(layout.contacts.positions[rows, 1], layout.contacts.positions[rows + 2, 1])
    floors = np.minimum.reduceat(layout.contacts.positions[:, 1], layout.contacts.first[:-1])
    lowest = floors[layout.contacts.agents[rows]]
    missing: FloatArray = np.zeros((len(rows), len(fractions)))
    for path, least in ((balls, np.maximum(early, clearance)), (heels, clearance)):
        heights = _highest(path[..., None, [0, 2]], highest, lowest, ground)
        uneven = np.flatnonzero(np.ptp(heights, axis=1) > EDGE_HEIGHT)
        places = path[uneven][..., [0, 2]]
        share = (middle == 1.0) * _aside_shares(places, AT_PRINT)
        beside = places[:, :, None] + share[..., None, None] * BESIDE
        heights[uneven] = np.maximum(heights[uneven], _highest(beside, highest[uneven], lowest[uneven], ground))
        missing = np.maximum(missing, heights + least - path[..., 1])
    missing = np.clip(missing, 0.0, BLIND_HEIGHT)
    missing[:, [0, -1]] = 0.0
    return missing


def _highest(places: FloatArray, near: FloatArray, lowest: FloatArray, ground: Ground) -> FloatArray:
    """The highest ground at places (N, FINE, K, 2) of swings between prints no higher than `near` [m], shape (N, FINE).

    Off the terrain it is `lowest` (N,) [m].
    """
    if not ground.has_terrain:
        return np.repeat(lowest[:, None], places.shape[1], axis=1)
    limits = np.broadcast_to(near[:, None, None], places.shape[:-1])
    found = ground.heights(places.reshape(-1, 2), limits.ravel(), step_up=BLIND_HEIGHT)
    hit, heights = found.hit.reshape(limits.shape), found.heights.reshape(limits.shape)
    return np.asarray(np.where(hit, heights, lowest[:, None, None]).max(axis=2))


def _lifts(missing: FloatArray) -> FloatArray:
    """Lifts (N, KNOTS) [m] that make good for what is missing (N, FINE) [m]: the highest of the bumps over it."""
    lifts, rows = np.zeros((len(missing), KNOTS)), np.flatnonzero(missing.any(axis=1))
    lifts[rows] = np.stack([np.max(missing[rows] * bump, axis=1) for bump in BUMPS.T], axis=1)
    return lifts


def _envelope(missing: FloatArray) -> FloatArray:
    """Smooth curves through the knots (N, KNOTS), not below `missing`, zero at both ends."""
    padded = np.pad(missing, ((0, 0), (1, 1)))
    dilated = np.maximum(np.maximum(padded[:, :-2], padded[:, 1:-1]), padded[:, 2:])
    padded = np.pad(dilated, ((0, 0), (1, 1)), mode="edge")
    smooth = 0.25 * padded[:, :-2] + 0.5 * padded[:, 1:-1] + 0.25 * padded[:, 2:]
    smooth = np.maximum(smooth, missing)
    smooth[:, [0, -1]] = 0.0
    return smooth
