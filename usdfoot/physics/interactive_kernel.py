"""One footstep more as a Warp kernel: from the last footsteps to the solution in one launch ([P] 4.2)."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.physics.comfort_kernel import settle_agent
from usdfoot.physics.contact_kernel import ContactArrays, ContactFooting, LegArrays, lay_agent, wrapped
from usdfoot.physics.energy_kernel import ProblemArrays, instant_share
from usdfoot.physics.knot_kernel import KnotOptions, lay_agent_knots
from usdfoot.physics.solve_kernel import WorkArrays, solve_agent
from usdfoot.physics.stance_kernel import find_instant
from usdfoot.physics.yaw_kernel import body_yaw, yaw_turn

__all__ = ["WindowArrays", "solve_window"]


@wp.struct
class WindowArrays:
    """The last footsteps of one agent, and the knots over them."""

    real: int  # footsteps R; the contacts after them are expected
    sides: wp.array(dtype=wp.int32)  # (R,)
    positions: wp.array(dtype=wp.vec3d)  # (R,) [m]
    orientations: wp.array(dtype=wp.quatd)  # (R,), +Y along the ground's normal, +Z the foot's heading
    strikes: wp.array(dtype=wp.float64)  # (R,) [s]
    liftoffs: wp.array(dtype=wp.float64)  # (R,) [s]
    window: wp.float64  # of the body's mean heading [s]
    tolerance: wp.float64  # relative to E
    headings: wp.array(dtype=wp.float64)  # feet's yaws, continuous, of R contacts and those after [rad]
    knots: wp.array(dtype=wp.int32)  # how many there are, (1,)
    knot_times: wp.array(dtype=wp.float64)  # [s]
    times: wp.array(dtype=wp.float64)  # of the instants [s]


@wp.func
def lay_footstep(contacts: ContactArrays, window: WindowArrays, i: int):
    """Sets contact i as footstep i."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    ahead = wp.quat_rotate(window.orientations[i], wp.vec3d(zero, zero, one))
    contacts.rows[i].side = window.sides[i]
    contacts.rows[i].position = window.positions[i]
    contacts.rows[i].normal = wp.quat_rotate(window.orientations[i], wp.vec3d(zero, one, zero))
    contacts.rows[i].yaw = wp.atan2(ahead[0], ahead[2])
    contacts.rows[i].strike = window.strikes[i]
    contacts.rows[i].liftoff = window.liftoffs[i]


@wp.func
def repeat_stride(contacts: ContactArrays, i: int, begin: int, end: int):
    """Sets contact i as the one before of its foot, moved by the stride from contact `begin` to `end`."""
    source = contacts.rows[i - 2]
    turn = wrapped(contacts.rows[end].yaw - contacts.rows[begin].yaw)
    period = contacts.rows[end].strike - contacts.rows[begin].strike
    across = wp.quat_rotate(yaw_turn(turn), source.position - contacts.rows[begin].position)
    contacts.rows[i].side = source.side
    contacts.rows[i].position = contacts.rows[end].position + across
    contacts.rows[i].normal = source.normal
    contacts.rows[i].yaw = source.yaw + turn
    contacts.rows[i].strike = source.strike + period
    contacts.rows[i].liftoff = source.liftoff + period


@wp.func
def lay_window(contacts: ContactArrays, window: WindowArrays):
    """Sets the footsteps, what is expected after them, the last stride repeated, and the time to solve."""
    real = window.real
    finish = wp.float64(-wp.inf)
    for i in range(real):
        lay_footstep(contacts, window, i)
        finish = wp.max(finish, contacts.rows[i].liftoff)
    for i in range(real, contacts.rows.shape[0]):
        repeat_stride(contacts, i, real - 3, real - 1)
        finish = wp.max(finish, contacts.rows[i].strike)
    contacts.agents[0].first = 0
    contacts.agents[0].end = contacts.rows.shape[0]
    contacts.agents[0].start = contacts.rows[real - 2].strike
    contacts.agents[0].finish = finish


@wp.kernel(enable_backward=False)
def solve_window(
    contacts: ContactArrays,
    legs: LegArrays,
    footing: wp.array(dtype=ContactFooting),
    divisions: KnotOptions,
    window: WindowArrays,
    problem: ProblemArrays,
    work: WorkArrays,
):
    """Solves from the step before the last footstep on; the first unknowns are fixed.

    Nothing is solved where there are more knots than the arrays have room for.

    Args:
        contacts: Room for the footsteps and what is expected after them.
        legs: Of the biped.
        footing: Room for that of the contacts.
        divisions: How steps are divided.
        window: The footsteps; headings, knots and times are set.
        problem: Its durations, stance and fixed unknowns are set.
        work: The first unknowns are given.
    """
    lay_window(contacts, window)
    lay_agent(contacts, legs, footing, 0)
    for i in range(contacts.rows.shape[0]):
        window.headings[i] = footing[i].heading
    count = lay_agent_knots(contacts, footing, divisions, 0, window.knot_times, 0)
    window.knots[0] = count
    if count > window.knot_times.shape[0]:
        return
    ends_standing = contacts.rows.shape[0] == window.real
    for k in range(count):
        problem.fixed[k, 0] = k == 0
        problem.fixed[k, 1] = k == 0 or (k == count - 1 and ends_standing)
        if k > 0:
            work.unknowns[k, 0] = work.unknowns[0, 0]
            work.unknowns[k, 1] = wp.vec3d()
    for s in range(count - 1):
        begin = window.knot_times[s]
        length = window.knot_times[s + 1] - begin
        problem.durations[s] = length
        for n in range(problem.instants):
            m = s * problem.instants + n
            time = begin + length * instant_share(n, problem.instants)
            body = yaw_turn(body_yaw(contacts, footing, 0, time, window.window))
            window.times[m] = time
            find_instant(contacts, legs, footing, problem.stance, m, 0, time, body)
    settle_agent(problem, work.unknowns, 0, count - 1, 0)
    solve_agent(problem, work, 0, count - 1, 0, window.tolerance)
