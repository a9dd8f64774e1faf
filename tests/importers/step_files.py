"""Footstep files of other programs made up for tests, from plans."""

from __future__ import annotations

import struct

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.model.plan import FootstepPlan


def stp_of(plan: FootstepPlan, *, metres: float = 0.0254) -> str:
    """A plan as an STP file of 3ds Max: +Z up, footsteps face +X, 4800 ticks a second."""
    lines = ["VERSION", "54", "STEPS", str(len(plan))]
    forward, normal = (quaternion.rotate(plan.orientations, np.array(axis)) for axis in ((0, 0, 1.0), (0, 1.0, 0)))
    rows = np.stack([forward, np.cross(normal, forward), normal, plan.positions / metres], axis=1)
    for x, y, z in rows.reshape(-1, 3):
        lines.append(f"{x:.7f} {-z:.7f} {y:.7f}")
    lines.append("SCORE")
    for side, leg in ((1, "RLEG"), (0, "LLEG")):
        own = np.flatnonzero(plan.sides == side)
        lines += [leg, str(len(own))]
        for number, step in enumerate(own):
            start, end = 4800.0 * plan.strike_times[step], 4800.0 * plan.liftoff_times[step]
            lines += [f"step{number}", f"{start:.0f}", f"{end - start:.0f}", str(step)]
    lines += [
        "SCALE",
        "0.0",
        "10.0",
        "1.0",
        "0.2",
        "100.0",
        "KEYFF",
        *["0"] * (2 * len(plan)),
        "1",
        "206",
        "160",
        "END",
    ]
    return "\n".join(lines) + "\n"


def recording_of(agents: list[list[tuple[float, float, int, float, float, float]]], *, kind: int = 3) -> bytes:
    """A SteerSuite recording of agents' footsteps (start, end, foot, x, z, phi), with one box."""
    size = {3: 140, 4: 144, 5: 176}[kind]
    tables, steps = b"", b""
    first = 20 + 16 + 8 * len(agents)
    for agent in agents:
        tables += struct.pack("<II", len(agent), first + len(steps))
        for start, end, foot, x, z, phi in agent:
            head = struct.pack("<7fB3x", start, end, 9.0, 9.0, phi, phi - 0.1, phi + 0.1, foot)
            steps += (head + struct.pack("<11f", *[9.0] * 11) + struct.pack("<2f", x, z)).ljust(size, b"\xff")
    header = struct.pack("<5I", kind, len(agents), 1, 36, 20) + struct.pack("<4f", 0.0, 1.0, 0.0, 1.0)
    return header + tables + steps
