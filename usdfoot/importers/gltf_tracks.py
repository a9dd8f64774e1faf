"""Animations of a glTF file: keys of translations, rotations and scales of its nodes, sampled at any times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.importers.gltf_file import GltfFile
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["Track", "key_rate", "read_tracks", "sampled"]

PATHS = {"translation": 3, "rotation": 4, "scale": 3}
"""Components of what is animated."""
INTERPOLATIONS = ("LINEAR", "STEP", "CUBICSPLINE")
RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 90.0, 100.0, 120.0, 144.0, 200.0, 240.0, 24.0 / 1.001, 30.0 / 1.001)
"""Of programs that write keys, the usual ones first [Hz]."""
OTHERWISE = 60.0
"""Rate at which keys at other times are sampled [Hz]."""
ON_FRAME = 0.02
"""How far from a frame a key on it may lie [frames]: times are in single precision."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """Keys of one property of one node."""

    node: int
    path: str
    """translation | rotation | scale."""
    interpolation: str
    """LINEAR | STEP | CUBICSPLINE."""
    times: FloatArray
    """Of the keys [s], increasing, shape (K,)."""
    values: FloatArray
    """Shape (K, C), or in-tangent, value and out-tangent of CUBICSPLINE, shape (K, 3, C)."""


def read_tracks(file: GltfFile, animation: int) -> tuple[tuple[Track, ...], tuple[str, ...]]:
    """Tracks of an animation, and the paths of channels that move no joint, as morph weights.

    Raises:
        ClipError: If a channel, sampler or accessor is malformed.
    """
    one = file.item("animations", animation)
    tracks, ignored = [], []
    for index, channel in enumerate(one.channels or []):
        where = f"animations[{animation}].channels[{index}]"
        target = channel.target
        if target is None or target.path not in PATHS or target.node is None:
            ignored.append(str(target.path if target else "nothing"))
            continue
        file.item("nodes", target.node)
        samplers = one.samplers or []
        if not isinstance(channel.sampler, int) or not 0 <= channel.sampler < len(samplers):
            raise file.error(f"{where} has sampler {channel.sampler} of {len(samplers)}", "export it again")
        tracks.append(_read_track(file, where, samplers[channel.sampler], target.node, target.path))
    return tuple(tracks), tuple(sorted(set(ignored)))


def _read_track(file: GltfFile, where: str, sampler: object, node: int, path: str) -> Track:
    interpolation = getattr(sampler, "interpolation", None) or "LINEAR"
    if interpolation not in INTERPOLATIONS:
        raise file.error(f"{where} is interpolated by {interpolation}", f"{', '.join(INTERPOLATIONS)} are glTF's")
    times = file.numbers(getattr(sampler, "input", None), f"times of {where}")
    values = file.numbers(getattr(sampler, "output", None), f"values of {where}")
    size, cubic = PATHS[path], interpolation == "CUBICSPLINE"
    if times.shape[1] != 1 or values.shape != (len(times) * (3 if cubic else 1), size):
        what = f"{where} has {len(times)} times and values of shape {values.shape} for a {path}"
        raise file.error(what, f"each {'cubic key has three of' if cubic else 'key has'} {size} numbers")
    if np.any(np.diff(times[:, 0]) <= 0.0):
        raise file.error(f"{where} has times that do not increase", "export it again")
    shaped = values.reshape(len(times), 3, size) if cubic else values
    if path == "rotation":
        turns = shaped[:, 1] if cubic else shaped
        if np.any(np.linalg.norm(turns, axis=-1) < 1e-6):
            raise file.error(f"{where} has a rotation that is zero", "rotations are unit quaternions")
    return Track(node=node, path=path, interpolation=interpolation, times=times[:, 0], values=shaped)


def key_rate(tracks: Sequence[Track]) -> float:
    """The lowest usual rate on whose frames all keys lie, else `OTHERWISE` [Hz]."""
    times = np.unique(np.concatenate([track.times for track in tracks]))
    times = times - times[0]
    for rate in RATES:
        frames = times * rate
        if np.all(np.abs(frames - np.round(frames)) < ON_FRAME):
            return rate
    return OTHERWISE


def sampled(track: Track, times: FloatArray) -> FloatArray:
    """Values at times [s] (T,), held before the first and after the last key, shape (T, C).

    As glTF 2.0 defines them: appendix C, rotations by the shorter way, cubic splines normalised.
    """
    keys = track.times
    if len(keys) == 1:
        first = track.values[0, 1] if track.interpolation == "CUBICSPLINE" else track.values[0]
        return np.tile(first, (len(times), 1))
    times = np.clip(times, keys[0], keys[-1])
    before = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 2)
    length = keys[before + 1] - keys[before]
    fraction = ((times - keys[before]) / length)[:, None]
    if track.interpolation == "CUBICSPLINE":
        return _cubic(track, before, length[:, None], fraction)
    start, end = track.values[before], track.values[before + 1]
    if track.interpolation == "STEP":
        return np.where(fraction >= 1.0, end, start)
    if track.path == "rotation":
        return quaternion.slerp(quaternion.normalised(start), quaternion.normalised(end), fraction[:, 0])
    return start + fraction * (end - start)


def _cubic(track: Track, before: np.ndarray, length: FloatArray, t: FloatArray) -> FloatArray:
    """Hermite splines whose tangents are in units a second."""
    start, leave = track.values[before, 1], length * track.values[before, 2]
    end, arrive = track.values[before + 1, 1], length * track.values[before + 1, 0]
    values = (
        (2.0 * t**3 - 3.0 * t**2 + 1.0) * start
        + (t**3 - 2.0 * t**2 + t) * leave
        + (3.0 * t**2 - 2.0 * t**3) * end
        + (t**3 - t**2) * arrive
    )
    return quaternion.normalised(values) if track.path == "rotation" else values
