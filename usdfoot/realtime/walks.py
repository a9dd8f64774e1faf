"""Walks: the prepared steps of agents, and their bodies at an instant."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.options import EngineOptions
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.realtime.bodies import Bodies
from usdfoot.realtime.nudges import Nudges
from usdfoot.realtime.preparing import prepare_stretch
from usdfoot.realtime.rows import Rows
from usdfoot.realtime.slots import with_rows
from usdfoot.realtime.tables import REACH_BACK, cut_stretch
from usdfoot.realtime.windows import CLEAN, Windows

__all__ = ["ControllerOptions", "Walks"]

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


class Walks:
    """What is prepared of the walks of N agents, who have none yet.

    Args:
        library: Prepared.
        ground: The terrain.
        windows: Of no agents.
        nudges: Likewise.
        options: What may be turned.
    """

    def __init__(
        self, library: PreparedLibrary, ground: Ground, *, windows: Windows, nudges: Nudges, options: ControllerOptions
    ) -> None:
        self.windows, self.nudges = windows, nudges
        self.origins = np.zeros((0, 3))
        """What single precision counts from [m], shape (N, 3)."""
        self._library, self._ground, self._options = library, ground, options
        self._rows, self._starts = Rows(0), np.zeros(0)

    def open(self, agents: IntArray, positions: FloatArray, *, windows: Windows, nudges: Nudges, now: float) -> None:
        """Has agents (M,) stand at positions [m] (M, 3) from `now` [s] on, with windows and nudges of theirs."""
        self.windows.put(agents, windows)
        self.nudges.put(agents, nudges)
        self._rows.open(agents)
        self.origins = with_rows(self.origins, agents, positions)
        self._starts = with_rows(self._starts, agents, np.full(len(agents), now))
        self.prepare(now)

    def prepare(self, now: float) -> None:
        """Prepares what changed, and has those go on from the poses they have `now` [s] whom it moves."""
        windows, rows = self.windows, self._rows
        agents = np.flatnonzero(windows.dirty != CLEAN)
        if not agents.size:
            return
        seen = agents[self._moved(agents, now)]
        before = self.bodies(seen, now, nudged=True).snapshot() if seen.size else None
        distant = self._rebased(agents)
        firsts = windows.dirty[agents] - REACH_BACK
        firsts = np.where(distant, np.minimum(firsts, windows.current[agents] - 3), firsts)
        stretch = cut_stretch(
            windows,
            agents,
            np.maximum(firsts, 0),
            library=self._library,
            blends=rows.blends,
            origins=self.origins[agents],
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
            after = self.bodies(seen, now, nudged=False).snapshot()
            self.nudges.add_bodies(seen, before, after, time=now)
            bodies = self.bodies(seen, now, nudged=True)
            self.nudges.add_feet(seen, before, bodies.snapshot(), landings=bodies.landings())

    def bodies(self, agents: IntArray, time: float, *, nudged: bool) -> Bodies:
        """Agents at an instant as they are prepared now."""
        segments, contacts, numbers = self._rows.struck(agents, time)
        return Bodies(
            agents=agents,
            time=time,
            origins=self.origins[agents],
            clock=time - self._starts[agents],
            segments=segments,
            contacts=contacts,
            numbers=numbers,
            library=self._library,
            rows=self._rows,
            nudges=self.nudges if nudged else None,
        )

    def _moved(self, agents: IntArray, now: float) -> BoolArray:
        """Whose pose at the last instant may change by what is to be prepared."""
        _, _, numbers = self._rows.struck(agents, now)
        flying = self.windows.at(self.windows.liftoffs, agents, numbers) <= now
        known = self._rows.numbers[agents, 1] >= 0
        return known & (numbers + flying >= self.windows.dirty[agents] - 2)

    def _rebased(self, agents: IntArray) -> BoolArray:
        """Gives agents that are far from their origins new ones; who did."""
        windows = self.windows
        places = windows.at(windows.positions, agents, windows.current[agents])
        strikes = windows.at(windows.strikes, agents, windows.current[agents])
        distant = np.linalg.norm(places - self.origins[agents], axis=1) > FARTHEST_ORIGIN
        distant |= strikes - self._starts[agents] > LONGEST_CLOCK
        self.origins[agents[distant]], self._starts[agents[distant]] = places[distant], strikes[distant]
        return distant
