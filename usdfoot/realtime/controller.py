"""Controller: footsteps or velocities in as they come, the poses of many agents out by the frame ([B] 6)."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.errors import UsdfootError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.device import start_warp
from usdfoot.model.ground import Ground
from usdfoot.model.limits import BODILY, FARTHEST
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain, no_terrain
from usdfoot.planning.predictions import build_gaits
from usdfoot.planning.proportions import proportions_of
from usdfoot.realtime.arguments import agent_numbers, finite_array, float_array, number_array
from usdfoot.realtime.crowd_pose import CrowdPose, rest_joints
from usdfoot.realtime.footsteps import Footsteps, rounds_of
from usdfoot.realtime.nudges import Nudges
from usdfoot.realtime.roster import Roster, problem_of_agent
from usdfoot.realtime.steering import Steering
from usdfoot.realtime.walks import ControllerOptions, Walks
from usdfoot.realtime.windows import Windows

__all__ = ["Controller"]

LONGEST_WAIT = 0.1
"""Who is steered is given footsteps at least as often as this, however long nobody asks for a pose [s]."""


class Controller:
    """Walks N agents over footsteps given while they walk.

    Everyone starts standing; agents come and go while others walk. Give footsteps at least two ahead of the one that
    the body stands on: then the motion is that of the whole plan. With fewer the body prepares to halt, and goes on
    from there when the next one comes. What has been prepared is kept; a new footstep prepares only the parts of steps
    that it completes, for all agents that have one in a few array operations.

    Args:
        library: Clips of the character.
        positions: Where the agents stand, ground under the middle of the feet, world [m], shape (N, 3).
        yaws: Which way they face [rad], shape (N,).
        start: First instant [s].
        terrain: What they walk on; None = the levels of the footsteps.
        options: What may be turned.

    Raises:
        ClipError: If no clip has a usable step, or one foot never swings.
        UsdfootError: If an argument is of another shape or not finite, or Warp's device is not the processor, whose
            memory is shared.
    """

    def __init__(
        self,
        library: ClipLibrary | PreparedLibrary,
        *,
        positions: FloatArray,
        yaws: FloatArray,
        start: float = 0.0,
        terrain: Terrain | None = None,
        options: ControllerOptions | None = None,
    ) -> None:
        self._time = float(finite_array("start", start, ()))
        start_warp()
        if not wp.get_device().is_cpu:
            raise UsdfootError("Controller", f"cannot work on {wp.get_device()}", 'make it warp.set_device("cpu")')
        self._options = options or ControllerOptions()
        engine = self._options.engine
        self._library = library if isinstance(library, PreparedLibrary) else prepare_library(library, engine)
        self._ground = Ground(terrain or no_terrain())
        source, examples = self._library.source, self._library.examples
        self._body = proportions_of(source.skeleton, source.biped, source.bind_pose)
        self._gaits = build_gaits(
            examples, self._library.spaces, style=self._library.style, leg_length=self._body.leg_length
        )
        self.stance_width = self._gaits.stance_width
        """Between the feet of a stand [m]."""
        swings = (examples.durations - np.maximum(examples.swing_liftoffs, 0.0))[:-1]
        self.usual_swing = float(np.median(swings))
        """Time of a swing whose liftoff nobody gave [s]."""
        windows, nudges, self._steering = self._standing(np.zeros((0, 3)), np.zeros(0))
        self._walks = Walks(self._library, self._ground, windows=windows, nudges=nudges, options=self._options)
        self._windows, self._roster = windows, Roster()
        self._rest = rest_joints(source)
        self.add(positions, yaws)

    def __len__(self) -> int:
        """How many rows a pose has: one for each agent, also for those who were removed."""
        return len(self._roster)

    @property
    def there(self) -> IntArray:
        """Numbers of the agents who are there, increasing."""
        return self._roster.numbers

    def add(self, positions: FloatArray, yaws: FloatArray) -> IntArray:
        """Has more agents stand from now on.

        Nobody else is touched by it. Numbers of agents who were removed are given again first.

        Args:
            positions: Ground under the middle of the feet, world [m], shape (M, 3).
            yaws: Which way they face [rad], shape (M,).

        Returns:
            Their numbers, shape (M,).

        Raises:
            UsdfootError: If the arrays are not of these shapes, or a value is not finite or too far away.
        """
        count = len(number_array("yaws", yaws).reshape(-1))
        positions, yaws = finite_array("positions", positions, (count, 3)), finite_array("yaws", yaws, (count,))
        far = np.flatnonzero((np.abs(positions) > FARTHEST).any(axis=1))
        if far.size:
            what = f"row {far[0]} is {np.abs(positions[far[0]]).max():.3g} m from the origin"
            raise UsdfootError("positions", what, f"give positions within {FARTHEST:g} m")
        agents = self._roster.enter(count)
        if not count:
            return agents
        windows, nudges, steering = self._standing(positions, yaws)
        self._steering.put(agents, steering)
        self._walks.open(agents, positions, windows=windows, nudges=nudges, now=self._time)
        return agents

    def remove(self, agents: IntArray) -> tuple[Problem, ...]:
        """Takes agents away. The others keep their numbers and are not touched by it.

        Args:
            agents: Shape (M,).

        Returns:
            Those that are not there.

        Raises:
            UsdfootError: If they are no whole numbers in a row.
        """
        agents = agent_numbers(agents)
        known = self._roster.knows(agents)
        self._roster.leave(agents[known])
        self._steering.active[agents[known]] = False
        self._windows.retire(agents[known])
        return tuple(problem_of_agent("error", agent, self._roster.absence(agent)) for agent in agents[~known])

    def _standing(self, positions: FloatArray, yaws: FloatArray) -> tuple[Windows, Nudges, Steering]:
        """What agents have who stand from now on."""
        feet = np.stack([positions + _aside(yaws, side, self.stance_width) for side in (0, 1)], axis=1)
        source = self._library.source
        return (
            Windows(feet, yaws, start=self._time, usual_swing=self.usual_swing),
            Nudges(len(yaws), len(source.skeleton.joints), pelvis=source.biped.pelvis),
            Steering(len(yaws), self._gaits, body=self._body, options=self._options.engine.follow),
        )

    @property
    def footing(self) -> Footsteps:
        """Where everyone's last footstep known is, executed; the next one is of the other foot."""
        windows, agents = self._windows, np.arange(len(self))
        place = agents, windows.last % windows.sides.shape[1]
        return Footsteps(
            sides=windows.sides[place],
            positions=windows.positions[place],
            yaws=windows.yaws[place],
            strike_times=windows.strikes[place],
            liftoff_times=windows.liftoffs[place],
        )

    def plan(self, agents: IntArray, footsteps: Footsteps, *, instead: bool = False) -> tuple[Problem, ...]:
        """Gives agents their next footsteps.

        Args:
            agents: Whose each footstep is, shape (M,); one agent's in order of strike.
            footsteps: M of them.
            instead: Whether they replace footsteps whose swings have not begun.

        Returns:
            Footsteps that were refused, with all that follow of the same agent, and warnings of those that came too
            late and strike later. The others are not touched by either.

        Raises:
            UsdfootError: If there are not as many agents as footsteps, or they are no whole numbers in a row.
        """
        agents = agent_numbers(agents, count=len(footsteps), of="footsteps")
        faults, windows, known = footsteps.faults(), self._windows, self._roster.knows(agents)
        faults |= {row: self._roster.absence(int(agents[row])) for row in np.flatnonzero(~known).tolist()}
        if instead:
            windows.forget(np.unique(np.delete(agents, list(faults))), now=self._time)
        problems: list[Problem] = []
        refused = np.zeros(len(self), dtype=bool)
        for rows in rounds_of(agents):
            whole = np.array([row not in faults for row in rows.tolist()], dtype=bool)
            problems += [problem_of_agent("error", agents[row], faults[row]) for row in rows[~whole].tolist()]
            refused[agents[rows[~whole & known[rows]]]] = True
            own = rows[whole]
            own = own[~refused[agents[own]]]
            wrong, full = windows.refuses(agents[own], footsteps[own], now=self._time)
            sides = "the other foot has to move next; left and right alternate"
            problems += [problem_of_agent("error", agent, sides) for agent in agents[own[wrong]]]
            crowded = "knows as many footsteps ahead as it can; give the next ones later"
            problems += [problem_of_agent("error", agent, crowded) for agent in agents[own[full & ~wrong]]]
            refused[agents[own[wrong | full]]] = True
            own = own[~(wrong | full)]
            late = windows.append(agents[own], footsteps[own], now=self._time)
            for row in np.flatnonzero(late > 1e-6):
                problems.append(
                    problem_of_agent("warning", agents[own[row]], f"a footstep came late by {late[row]:.3g} s")
                )
        self._steering.active[agents[known]] = False
        return tuple(problems)

    def steer(self, agents: IntArray, velocities: FloatArray, yaws: FloatArray) -> tuple[Problem, ...]:
        """Has agents go on at velocities, with footsteps of their own ([B] 5), until they are told otherwise.

        A velocity counts from the next footstep on that is not planned yet, and 0 brings the feet together.

        Args:
            agents: Shape (M,).
            velocities: Of the roots in the world, (x, z) [m/s], shape (M, 2).
            yaws: Headings [rad], shape (M,).

        Returns:
            Those refused, since a value is not finite, nobody is as fast, or there is no such agent.

        Raises:
            UsdfootError: If the arrays are not of these shapes.
        """
        agents = agent_numbers(agents)
        velocities = float_array("velocities", velocities, (len(agents), 2))
        yaws = float_array("yaws", yaws, (len(agents),))
        whole, there = np.isfinite(velocities).all(axis=1) & np.isfinite(yaws), self._roster.knows(agents)
        wild = whole & (np.abs(velocities) > BODILY[1]).any(axis=1)
        good = whole & there & ~wild
        self._steering.set(agents[good], velocities[good], yaws[good])
        problems = [
            problem_of_agent("error", agent, "velocity or yaw is not a finite number") for agent in agents[~whole]
        ]
        beyond = f"velocity is beyond {BODILY[1]:g} m/s"
        problems += [problem_of_agent("error", agent, beyond) for agent in agents[wild]]
        problems += [problem_of_agent("error", agent, self._roster.absence(agent)) for agent in agents[~there]]
        return tuple(problems)

    def pose(self, time: float) -> CrowdPose:
        """Everyone at `time` [s], not before the time asked for last.

        Raises:
            UsdfootError: If the time is, or is not finite.
        """
        time = float(float_array("time", time, ()))
        if not self._time <= time < np.inf:
            raise UsdfootError("time", f"is {time}", f"time goes on from {self._time} s")
        if self._steering.active.any():
            for instant in np.arange(self._time, time - LONGEST_WAIT, LONGEST_WAIT):
                self._go_on(float(instant))
        self._go_on(time)
        windows, agents = self._windows, self.there
        if not agents.size:
            return self._rest.pose(time, len(self))
        bodies = self._walks.bodies(agents, time, nudged=True)
        poses = bodies.pose()
        bodies.plant(poses)
        pose = self._rest.finish(
            poses, bodies.roots(), origins=self._walks.origins[agents], time=time, halted=windows.halted[agents]
        )
        return pose if len(agents) == len(self) else pose.among(self._rest.pose(time, len(self)), agents)

    def _go_on(self, time: float) -> None:
        """What is known of the footsteps by `time` [s] is made ready for poses."""
        windows = self._windows
        windows.advance(time)
        while self._steering.step(windows, self._ground, now=time):
            pass
        self._halt(windows.wanting(time))
        self._walks.prepare(self._time)
        self._time = time

    def _halt(self, agents: IntArray) -> None:
        if agents.size:
            windows = self._windows
            number = windows.last[agents]
            sides = 1 - windows.sides[agents, number % windows.sides.shape[1]]
            yaws = windows.at(windows.yaws, agents, number)
            across = np.where(sides == 0, 1.0, -1.0)[:, None] * _aside(yaws, 0, 2.0 * self.stance_width)
            places = windows.at(windows.positions, agents, number) + across
            windows.halt(agents, farthest=self._options.farthest_stand * self._body.leg_length, beside=places)


def _aside(yaws: FloatArray, side: int, width: float) -> FloatArray:
    """From the root to a foot that stands beside it [m], shape (N, 3)."""
    across = planar.rotate(yaws, np.tile([0.5 * width if side == 0 else -0.5 * width, 0.0], (len(yaws), 1)))
    return np.stack([across[:, 0], np.zeros(len(yaws)), across[:, 1]], axis=1)
