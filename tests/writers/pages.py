"""Small crowds to make pages of, with known truth; and pages taken apart again, independent of the page's scripts."""

from __future__ import annotations

import base64
import json
import re
import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.page.ground import picture_ground
from usdfoot.writers.page.pictures import AgentPicture, CrowdPicture, PageFigure, StickFigure

STICK = StickFigure(
    joints=(0, 1, 2, 3, 4), parents=(-1, 0, 1, 0, 3), sides=(2, 0, 0, 1, 1), head=-1, leg_length=0.9, foot_length=0.15
)
FIGURES = (
    PageFigure(key="placement", title="placement error", unit="mm", digits=3, meaning="m", target=3.0),
    PageFigure(key="clearance", title="clearance", unit="mm", digits=1, meaning="m", target=10.0, at_least=True),
    PageFigure(
        key="sole", title="lowest sole", unit="mm", digits=3, meaning="m", target=-2.0, at_least=True, per_agent=True
    ),
)
FRAME_TIME = 1.0 / 30.0
STRIKES = 0.5 * np.arange(4)


def walker(name: str, *, x: float = 0.0, status: tuple[str, ...] = ("ok",) * 4, frames: int = 61) -> AgentPicture:
    """An agent that goes along +Z at 1 m/s, x metres to the left, with its knees on its ankles."""
    count = len(STRIKES)
    sides = np.arange(count) % 2
    times = FRAME_TIME * np.arange(frames)
    roots = np.stack([np.full(frames, x), np.zeros(frames), times], axis=1)
    offsets = np.array([(0.0, 0.9, 0.0), (0.1, 0.5, 0.0), (0.1, 0.1, 0.0), (-0.1, 0.5, 0.0), (-0.1, 0.1, 0.0)])
    positions = np.stack([x + np.where(sides == 0, 0.1, -0.1), np.zeros(count), STRIKES], axis=1)
    none = np.zeros(count)
    return AgentPicture(
        name=name,
        source=f"/World/{name}",
        plan=FootstepPlan(
            name=f"/Crowd/Plans/{name}",
            sides=sides,
            positions=positions,
            orientations=quaternion.yaw_quaternion(none),
            strike_times=STRIKES,
            liftoff_times=STRIKES + 0.6,
            root_weights=none,
        ),
        flat_times=STRIKES + 0.1,
        stick_figure=STICK,
        times=times,
        roots=roots,
        joints=roots[:, None] + offsets,
        sole_heights=np.stack([np.sin(times) ** 2, np.full(frames, np.nan)], axis=1),
        stood=positions + (0.001, 0.0, 0.0),
        promised=np.array([each in ("ok", "outsideHull") for each in status]),
        results=StepResults(
            **dict.fromkeys(
                ("blend_error", "placement_error", "slide", "yaw_error", "hull_distance", "time_warp", "root_weight"),
                none,
            ),
            beta=none,
            root_velocity_error=none,
            status=status,
            clip_counts=np.array([0, 1, 2, 1]),
            clips=("/Clips/walk", "/Clips/walk", "/Clips/run", "/Clips/run"),
            clip_weights=np.array([1.0, 0.25, 0.75, 1.0]),
        ),
        steps={"placement": np.array([0.1, 0.2, 4.0, np.nan]), "clearance": np.array([np.nan, np.nan, 20.0, 5.0])},
        whole={"sole": -0.5},
    )


def crowd_of(*agents: AgentPicture, **changes: Any) -> CrowdPicture:
    """The crowd of some agents on a plane."""
    places = np.concatenate([agent.plan.positions for agent in agents])
    crowd = CrowdPicture(
        title="shot/crowd.usd",
        agents=agents,
        figures=FIGURES,
        ground=picture_ground(None, places),
        frame_time=FRAME_TIME,
        code_rate=30.0,
        total=({"name": "slide", "unit": "mm", "value": np.nan, "target": 1.0, "at_least": False, "passed": True},),
        problems=(),
        notes=(),
        facts={},
    )
    return replace(crowd, **changes)


def taken_apart(text: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of a page."""
    header = json.loads(re.search(r'id="header">(.*?)</script>', text, re.S)[1])
    block = zlib.decompress(base64.b64decode(re.search(r'id="block">(.*?)</script>', text, re.S)[1]))
    arrays, offset = {}, 0
    for entry in header["arrays"]:
        kind = np.dtype(entry["type"]).newbyteorder("<")
        size = entry["count"] * kind.itemsize
        planes = np.frombuffer(block[offset : offset + size], dtype=np.uint8).reshape(kind.itemsize, entry["count"])
        values = np.ascontiguousarray(planes.T).view(kind).ravel()
        arrays[entry["name"]] = np.cumsum(values, dtype=kind) if kind.kind in "iu" else values
        offset += size
    assert offset == len(block)
    return header, arrays
