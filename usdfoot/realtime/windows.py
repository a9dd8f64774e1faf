"""Windows: the last, current and next contacts of every agent, in rings."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.realtime.footsteps import Footsteps
from usdfoot.realtime.slots import Slots

__all__ = ["CLEAN", "RING", "Windows"]

RING = 16
"""Contacts an agent has room for."""
KEPT = 6
"""Contacts before the current one that are kept: what the poses between now and the next footsteps depend on."""
FOREVER = 1.0e4
"""How long a body stands that has no footstep to go to [s]."""
SHORTEST_SWING = 0.25
"""Least time from a foot's liftoff to its strike if nobody timed its liftoff [s]."""
QUICKEST_SWING = 0.05
"""The same if somebody did [s]."""
SHORTEST_STEP = 0.15
"""Least time from the strike of one foot to that of the other [s]."""
SHORTEST_CONTACT = 0.08
"""Least time from a strike to the liftoff [s]."""
LAST_SUPPORT = 0.12
"""Time a foot that has been stood on stays after the other one's strike if nobody says otherwise [s]."""
CLEAN = np.iinfo(np.int64).max
"""No contact has changed."""


class Windows(Slots):
    """What the agents know of their footsteps: contact n of an agent is in place n % RING of its rings.

    The first two contacts are where it stands from the start. An agent *halts* when it needs a footstep it does not
    have: its last two contacts then stand until another comes. `dirty` is the first contact since the last preparation
    that is new or left at another time.

    Args:
        positions: Where the first two contacts stand [m], shape (N, 2, 3).
        yaws: Direction of the feet [rad], shape (N,).
        start: First instant [s].
        usual_swing: Time of a swing nobody times [s].
    """

    def __init__(self, positions: FloatArray, yaws: FloatArray, *, start: float, usual_swing: float) -> None:
        count = len(yaws)
        self.sides = np.zeros((count, RING), dtype=np.intp)
        self.sides[:, 1] = 1
        self.positions = np.zeros((count, RING, 3))
        self.positions[:, :2] = positions
        self.yaws = np.zeros((count, RING))
        self.yaws[:, :2] = yaws[:, None]
        self.strikes = np.full((count, RING), start)
        self.given_liftoffs = np.full((count, RING), -np.inf)
        """When the footsteps said that the foot leaves."""
        self.liftoffs = np.full((count, RING), start + FOREVER)
        """When it does."""
        self.last = np.ones(count, dtype=np.intp)
        """Number of the last contact known."""
        self.current = np.ones(count, dtype=np.intp)
        """Number of the last contact struck."""
        self.halted = np.ones(count, dtype=bool)
        self.caught = np.zeros(count, dtype=bool)
        """Whether the last contact is nobody's footstep but a step to a halt."""
        self.dirty = np.zeros(count, dtype=np.intp)
        self._usual_swing = usual_swing

    def __len__(self) -> int:
        return len(self.last)

    def at(self, values: FloatArray, agents: IntArray, numbers: IntArray) -> FloatArray:
        """Values (N, RING, ...) of contacts by number."""
        return values[agents, numbers % RING]

    @property
    def room(self) -> IntArray:
        """How many footsteps more each agent can take, shape (N,)."""
        return RING - KEPT - 1 - (self.last - self.current)

    def advance(self, time: float) -> None:
        """Makes the contacts current that have been struck by `time` [s]."""
        agents = np.arange(len(self))
        while True:
            further = np.minimum(self.current + 1, self.last)
            struck = (further > self.current) & (self.at(self.strikes, agents, further) <= time)
            if not struck.any():
                return
            self.current += struck

    def wanting(self, time: float) -> IntArray:
        """Agents that lack a footstep to be posed at `time` [s]: two after the current one, three in a flight."""
        agents = np.arange(len(self))
        flying = self.at(self.liftoffs, agents, self.current) <= time
        return np.flatnonzero(~self.halted & (self.last < self.current + 2 + flying))

    def halt(self, agents: IntArray, *, farthest: float, beside: FloatArray) -> None:
        """Has agents stand where their footsteps end.

        Who ends in a flight or would stand with the feet farther apart than `farthest` [m] takes one step to a halt,
        to `beside` (N, 3) [m] its last footstep.
        """
        last = self.last[agents]
        apart = self.at(self.positions, agents, last) - self.at(self.positions, agents, last - 1)
        flies = self.at(self.liftoffs, agents, last - 1) < self.at(self.strikes, agents, last)
        steps = flies | (np.linalg.norm(apart, axis=1) > farthest)
        self._catch(agents[steps], beside[steps])
        last = self.last[agents]
        for number in (last - 1, last):
            self.liftoffs[agents, number % RING] = self.at(self.strikes, agents, last) + FOREVER
        self.halted[agents] = True
        self.caught[agents] = steps
        self.dirty[agents] = np.minimum(self.dirty[agents], last)

    def _catch(self, agents: IntArray, positions: FloatArray) -> None:
        """One step more, in the time of the last one."""
        last = self.last[agents]
        strikes = self.at(self.strikes, agents, last)
        duration = np.clip(strikes - self.at(self.strikes, agents, last - 1), 0.35, 0.7)
        earliest = self.at(self.liftoffs, agents, last - 1) + SHORTEST_SWING
        step = Footsteps(
            sides=1 - self.sides[agents, last % RING],
            positions=positions,
            yaws=self.at(self.yaws, agents, last),
            strike_times=np.maximum(strikes + duration, earliest),
            liftoff_times=strikes + FOREVER,
        )
        self._put(agents, step)

    def _put(self, agents: IntArray, footsteps: Footsteps) -> None:
        """One more contact of each agent."""
        self.last[agents] += 1
        place = agents, self.last[agents] % RING
        self.sides[place] = footsteps.sides
        self.positions[place] = footsteps.positions
        self.yaws[place] = footsteps.yaws
        self.strikes[place] = footsteps.strike_times
        self.given_liftoffs[place] = footsteps.liftoff_times
        self.liftoffs[place] = footsteps.liftoff_times
        self.dirty[agents] = np.minimum(self.dirty[agents], self.last[agents])

    def refuses(self, agents: IntArray, footsteps: Footsteps, *, now: float) -> tuple[BoolArray, BoolArray]:
        """Of agents, each once, whose next footstep would be of the foot it stands on, and who has no room for it."""
        self._forget_catch(agents, footsteps, now)
        fresh = (self.last[agents] == 1) & (self.sides[agents, 1] == footsteps.sides)
        self._swap_stand(agents[fresh])
        wrong = self.sides[agents, self.last[agents] % RING] == footsteps.sides
        return wrong, self.room[agents] <= 0

    def _forget_catch(self, agents: IntArray, footsteps: Footsteps, now: float) -> None:
        """A step to a halt that is still in the air goes where the footstep says."""
        last = self.last[agents]
        same = self.caught[agents] & (self.sides[agents, last % RING] == footsteps.sides)
        own = agents[same & (self.at(self.strikes, agents, last) > now + SHORTEST_SWING)]
        self.last[own] -= 1
        self.caught[own] = False
        self.dirty[own] = np.minimum(self.dirty[own], self.last[own])
        self.liftoffs[own, self.last[own] % RING] = self.given_liftoffs[own, self.last[own] % RING]

    def _swap_stand(self, agents: IntArray) -> None:
        """Who begins with the other foot has stood on it second."""
        for values in (self.sides, self.positions):
            values[agents, :2] = values[agents, 1::-1]
        self.dirty[agents] = 0

    def append(self, agents: IntArray, footsteps: Footsteps, *, now: float) -> FloatArray:
        """One more footstep of each agent, each once.

        A footstep that comes too late for the foot to get there begins at once and strikes later.

        Args:
            agents: Shape (M,).
            footsteps: M of them, of the feet that are not the last.
            now: [s].

        Returns:
            How much later than wanted they strike [s], shape (M,).
        """
        last = self.last[agents]
        leaving, staying = (agents, (last - 1) % RING), (agents, last % RING)
        earliest = np.maximum(self.strikes[leaving] + SHORTEST_CONTACT, np.where(self.halted[agents], now, -np.inf))
        given, wanted = self.given_liftoffs[leaving], footsteps.strike_times
        timed = given > now
        shortest = np.where(timed, QUICKEST_SWING, SHORTEST_SWING)
        leave = np.where(timed, given, wanted - self._usual_swing)
        leave = np.maximum(np.minimum(leave, wanted - shortest), earliest)
        strikes = np.maximum(wanted, np.maximum(leave + shortest, self.strikes[staying] + SHORTEST_STEP))
        kept = self.given_liftoffs[staying]
        known = np.isfinite(kept) & (kept > leave) & (kept < strikes + FOREVER / 2.0)
        kept = np.where(known, kept, strikes + LAST_SUPPORT)
        changed = (self.liftoffs[leaving] != leave) | (self.liftoffs[staying] != kept)
        self.liftoffs[leaving] = leave
        self.given_liftoffs[staying] = self.liftoffs[staying] = kept
        late = strikes - wanted
        liftoffs = np.maximum(footsteps.liftoff_times + late, strikes + SHORTEST_CONTACT)
        self._put(
            agents,
            Footsteps(
                sides=footsteps.sides,
                positions=footsteps.positions,
                yaws=footsteps.yaws,
                strike_times=strikes,
                liftoff_times=liftoffs,
            ),
        )
        self.dirty[agents] = np.minimum(self.dirty[agents], np.where(changed, last, last + 1))
        self.halted[agents] = self.caught[agents] = False
        return late

    def retire(self, agents: IntArray) -> None:
        """Has agents who are gone want nothing any more."""
        self.halted[agents] = True
        self.dirty[agents] = CLEAN

    def leave(self, agents: IntArray, times: FloatArray) -> None:
        """Says when the feet that are to move next leave the ground [s]."""
        self.given_liftoffs[agents, (self.last[agents] - 1) % RING] = times

    def forget(self, agents: IntArray, *, now: float) -> None:
        """Forgets the footsteps whose swings have not begun."""
        current = self.current[agents]
        begun = self.at(self.liftoffs, agents, current - 1) <= now
        kept = np.minimum(current + begun, self.last[agents])
        dropped = agents[kept < self.last[agents]]
        self.last[agents] = kept
        self.dirty[dropped] = np.minimum(self.dirty[dropped], self.last[dropped] + 1)
        self.halted[dropped] = self.caught[dropped] = False
