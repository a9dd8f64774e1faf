"""Ways of six people on hilly ground that have no footsteps: animated Xforms, and tracked points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stagecraft.rotation import FloatArray
from stagecraft.terrains import Surface, ground_under

SPACING = 0.1
"""Time between samples of the Xforms [s]."""
TRACKED = 0.4
"""Time between samples of the points, as trackers of people give them [s]."""
JITTER = 0.02
"""Standard deviation of the points' noise [m]."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """Where somebody goes."""

    name: str
    times: FloatArray
    """[s], shape (K,)."""
    places: FloatArray
    """On the ground [m], shape (K, 3)."""
    yaws: FloatArray | None = None
    """Headings [rad], shape (K,); None = along the way."""

    @property
    def number(self) -> int:
        """The id at the end of the name."""
        return int(self.name.rsplit("_", 1)[1])


def xform_ways(surface: Surface) -> list[Way]:
    """One who stops and goes, one who turns on the spot, one who breaks into a jog."""
    times = np.arange(0.0, 10.0 + 0.5 * SPACING, SPACING)
    pause = np.interp(times, [0.5, 1.2, 3.5, 4.2, 6.3, 7.0], [0.0, 1.2, 1.2, 0.0, 0.0, 1.3])
    approach = np.interp(times, [2.5, 3.3, 6.2, 7.0], [1.1, 0.0, 0.0, 1.1])
    turned = np.interp(times, [3.5, 6.0], [1.6, 1.6 + np.pi])
    jog = np.interp(times, [0.0, 3.0, 4.5, 8.0, 9.5], [1.2, 1.2, 2.6, 2.6, 1.2])
    bend = 0.35 * times - 0.2
    return [
        _way("Pauses", times, pause, np.full_like(times, 0.3), (-4.0, -5.0), surface),
        _way("Turns", times, approach, turned, (-3.0, 2.0), surface, faces=True),
        _way("Jogs", times, jog, bend, (-6.5, -4.0), surface),
    ]


def tracked_ways(surface: Surface) -> list[Way]:
    """Three people as a tracker sees them: coarse and noisy, one comes late, one leaves early."""
    generator = np.random.default_rng(1)
    ways = []
    for name, start, end, speed, heading, place in (
        ("Tracked_3", 0.0, 10.0, 1.3, 3.0, (3.0, 6.5)),
        ("Tracked_8", 2.0, 10.0, 1.0, -2.2, (6.0, 5.0)),
        ("Tracked_5", 0.0, 6.0, 0.35, 1.2, (-0.5, 3.0)),
    ):
        times = np.arange(start, end + 0.5 * TRACKED, TRACKED)
        way = _way(name, times, np.full_like(times, speed), np.full_like(times, heading), place, surface)
        noise = generator.normal(scale=JITTER, size=(len(times), 2))
        ways.append(_on(name, times, way.places[:, [0, 2]] + noise, surface))
    return ways


def _way(
    name: str,
    times: FloatArray,
    speeds: FloatArray,
    yaws: FloatArray,
    start: tuple[float, float],
    surface: Surface,
    *,
    faces: bool = False,
) -> Way:
    """The way from `start` (x, z) at speeds [m/s] along yaws [rad]; with these as headings if it `faces` along them."""
    velocities = speeds[:, None] * np.stack([np.sin(yaws), np.cos(yaws)], axis=1)
    moved = 0.5 * (velocities[1:] + velocities[:-1]) * np.diff(times)[:, None]
    places = np.array(start) + np.concatenate([np.zeros((1, 2)), np.cumsum(moved, axis=0)])
    return _on(name, times, places, surface, yaws if faces else None)


def _on(name: str, times: FloatArray, places: FloatArray, surface: Surface, yaws: FloatArray | None = None) -> Way:
    """The way over (x, z) `places` (K, 2) at the surface's height."""
    heights, _ = ground_under([surface], places)
    return Way(name=name, times=times, places=np.insert(places, 1, heights, axis=1), yaws=yaws)
