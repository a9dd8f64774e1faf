"""Controller: footsteps or velocities in as they come, the poses of many agents out by the frame ([B] 6)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import warp as wp

from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.device import start_warp
from usdfoot.model.ground import Ground
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain, no_terrain
from usdfoot.planning.predictions import build_gaits
from usdfoot.planning.proportions import proportions_of
from usdfoot.realtime.arguments import agent_numbers, finite_array, float_array, number_array
from usdfoot.realtime.bodies import Bodies
from usdfoot.realtime.crowd_pose import CrowdPose, rest_joints
from usdfoot.realtime.footsteps import Footsteps, rounds_of
from usdfoot.realtime.nudges import Nudges
from usdfoot.realtime.preparing import prepare_stretch
from usdfoot.realtime.roster import Roster, problem_of_agent
from usdfoot.realtime.rows import Rows
from usdfoot.realtime.slots import with_rows
from usdfoot.realtime.steering import Steering
from usdfoot.realtime.tables import REACH_BACK, cut_stretch
from usdfoot.realtime.windows import CLEAN, Windows

__all__ = ["Controller", "ControllerOptions"]

FARTHEST_ORIGIN = 20.0
"""An agent this far from its origin gets a new one, since single precision grows coarse [m]."""
LONGEST_CLOCK = 60.0
"""The same for its clock [s]."""


@dataclass(frozen=True, kw_only=True)
class ControllerOptions:
    """What may be turned."""

    engine: EngineOptions = field(default_factory=lambda: EngineOptions(corrections=2))
    """By default the landing is corrected twice, which leaves IK a little more than offline but costs a third."""
    ik_reach: float = 0.3
    """Largest horizontal distance IK may pull a landing to its footstep [m] ([B] 5)."""
    farthest_stand: float = 0.8
    """Who runs out of footsteps with its feet farther apart than this brings them together [leg lengths]."""


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
        self._body = proportions_of(source.skeleton, source.biped)
        self._gaits = build_gaits(
            examples, self._library.spaces, style=self._library.style, leg_length=self._body.leg_length
        )
        self.stance_width = self._gaits.stance_width
        """Between the feet of a stand [m]."""
        swings = (examples.durations - np.maximum(examples.swing_liftoffs, 0.0))[:-1]
        self.usual_swing = float(np.median(swings))
        """Time of a swing whose liftoff nobody gave [s]."""
        self._windows, self._nudges, self._steering = self._standing(np.zeros((0, 3)), np.zeros(0))
        self._rows, self._roster = Rows(0), Roster()
        self._origins, self._starts = np.zeros((0, 3)), np.zeros(0)
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
            UsdfootError: If the arrays are not of these shapes, or a value is not finite.
        """
        count = len(number_array("yaws", yaws).reshape(-1))
        positions, yaws = finite_array("positions", positions, (count, 3)), finite_array("yaws", yaws, (count,))
        agents = self._roster.enter(count)
        if not count:
            return agents
        windows, nudges, steering = self._standing(positions, yaws)
        self._windows.put(agents, windows)
        self._nudges.put(agents, nudges)
        self._steering.put(agents, steering)
        self._rows.open(agents)
        self._origins = with_rows(self._origins, agents, positions)
        self._starts = with_rows(self._starts, agents, np.full(count, self._time))
        self._prepare()
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
            Those refused, since a value is not finite or there is no such agent.

        Raises:
            UsdfootError: If the arrays are not of these shapes.
        """
        agents = agent_numbers(agents)
        velocities = float_array("velocities", velocities, (len(agents), 2))
        yaws = float_array("yaws", yaws, (len(agents),))
        whole, there = np.isfinite(velocities).all(axis=1) & np.isfinite(yaws), self._roster.knows(agents)
        good = whole & there
        self._steering.set(agents[good], velocities[good], yaws[good])
        problems = [
            problem_of_agent("error", agent, "velocity or yaw is not a finite number") for agent in agents[~whole]
        ]
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
        windows = self._windows
        windows.advance(time)
        while self._steering.step(windows, self._ground, now=time):
            pass
        self._halt(windows.wanting(time))
        self._prepare()
        agents, self._time = self.there, time
        if not agents.size:
            return self._rest.pose(time, len(self))
        bodies = self._bodies(agents, time, nudged=True)
        poses = bodies.pose()
        bodies.plant(poses)
        pose = self._rest.finish(
            poses, bodies.roots(), origins=self._origins[agents], time=time, halted=windows.halted[agents]
        )
        return pose if len(agents) == len(self) else pose.among(self._rest.pose(time, len(self)), agents)

    def _halt(self, agents: IntArray) -> None:
        if agents.size:
            windows = self._windows
            number = windows.last[agents]
            sides = 1 - windows.sides[agents, number % windows.sides.shape[1]]
            yaws = windows.at(windows.yaws, agents, number)
            across = np.where(sides == 0, 1.0, -1.0)[:, None] * _aside(yaws, 0, 2.0 * self.stance_width)
            places = windows.at(windows.positions, agents, number) + across
            windows.halt(agents, farthest=self._options.farthest_stand * self._body.leg_length, beside=places)

    def _prepare(self) -> None:
        """Prepares what changed, and has those go on from their present poses whom it moves."""
        windows, rows = self._windows, self._rows
        agents = np.flatnonzero(windows.dirty != CLEAN)
        if not agents.size:
            return
        seen = agents[self._moved(agents)]
        before = self._bodies(seen, self._time, nudged=True).snapshot() if seen.size else None
        distant = self._rebased(agents)
        firsts = windows.dirty[agents] - REACH_BACK
        firsts = np.where(distant, np.minimum(firsts, windows.current[agents] - 3), firsts)
        stretch = cut_stretch(
            windows,
            agents,
            np.maximum(firsts, 0),
            library=self._library,
            blends=rows.blends,
            origins=self._origins[agents],
            starts=self._starts[agents],
            options=self._options.engine,
        )
        prepare_stretch(
            stretch,
            windows,
            rows,
            library=self._library,
            ground=self._ground,
            reach=self._options.ik_reach,
            options=self._options.engine,
        )
        windows.dirty[agents] = CLEAN
        if before is not None:
            after = self._bodies(seen, self._time, nudged=False).snapshot()
            self._nudges.add_bodies(seen, before, after, time=self._time)
            bodies = self._bodies(seen, self._time, nudged=True)
            self._nudges.add_feet(seen, before, bodies.snapshot(), landings=bodies.landings())

    def _bodies(self, agents: IntArray, time: float, *, nudged: bool) -> Bodies:
        """Agents at an instant as they are prepared now."""
        segments, contacts, numbers = self._rows.struck(agents, time)
        return Bodies(
            agents=agents,
            time=time,
            origins=self._origins[agents],
            clock=time - self._starts[agents],
            segments=segments,
            contacts=contacts,
            numbers=numbers,
            library=self._library,
            rows=self._rows,
            nudges=self._nudges if nudged else None,
        )

    def _moved(self, agents: IntArray) -> BoolArray:
        """Whose pose at the last instant may change by what is to be prepared."""
        _, _, numbers = self._rows.struck(agents, self._time)
        flying = self._windows.at(self._windows.liftoffs, agents, numbers) <= self._time
        known = self._rows.numbers[agents, 1] >= 0
        return known & (numbers + flying >= self._windows.dirty[agents] - 2)

    def _rebased(self, agents: IntArray) -> BoolArray:
        """Gives agents that are far from their origins new ones; who did."""
        windows = self._windows
        places = windows.at(windows.positions, agents, windows.current[agents])
        strikes = windows.at(windows.strikes, agents, windows.current[agents])
        distant = np.linalg.norm(places - self._origins[agents], axis=1) > FARTHEST_ORIGIN
        distant |= strikes - self._starts[agents] > LONGEST_CLOCK
        self._origins[agents[distant]], self._starts[agents[distant]] = places[distant], strikes[distant]
        return distant


def _aside(yaws: FloatArray, side: int, width: float) -> FloatArray:
    """From the root to a foot that stands beside it [m], shape (N, 3)."""
    across = planar.rotate(yaws, np.tile([0.5 * width if side == 0 else -0.5 * width, 0.0], (len(yaws), 1)))
    return np.stack([across[:, 0], np.zeros(len(yaws)), across[:, 1]], axis=1)
