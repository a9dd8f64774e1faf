"""glTF and GLB: skins and animated nodes as skeletons, animations as clips; in metres, +Y up, as glTF defines it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.bridge.names import valid_name
from usdfoot.errors import ClipError
from usdfoot.importers.bones import joint_paths
from usdfoot.importers.gltf_file import GltfFile, open_gltf
from usdfoot.importers.gltf_tracks import Track, key_rate, read_tracks, sampled
from usdfoot.importers.text_lines import LARGEST
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.capture import Capture
from usdfoot.model.clip import Clip
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem
from usdfoot.model.skeleton import Skeleton

__all__ = ["import_gltf"]

MOST_SAMPLES = 10_000_000
"""Joints times frames of a clip; a small file can ask for more than memory holds."""


def import_gltf(
    file: str | os.PathLike[str], *, rate: float = 0.0, limits: Limits = DEFAULT_LIMITS
) -> tuple[tuple[Capture, ...], tuple[Problem, ...]]:
    """Skeletons with their clips, and what was left out.

    A skeleton is what skins have in common: their joints and the nodes between them. A file without skins has one of
    all nodes that move and hang below those. Nodes above are applied to the root joints, moving ones too, and scales
    anywhere to the places of the joints, so that bones have the lengths they are seen with.

    Args:
        file: .gltf or .glb.
        rate: Samples a second of the clips; 0 = the lowest usual one on whose frames the keys lie.
        limits: How many joints and frames there may be.

    Raises:
        ClipError: If the file is malformed or has no animation of nodes.
        SceneError: If it has more joints or frames than the limits allow.
    """
    path = Path(file)
    gltf = open_gltf(path, limits)
    animations = [read_tracks(gltf, index) for index in range(len(gltf.document.animations or []))]
    names = [animation.name for animation in gltf.document.animations or []]
    moved = sorted({track.node for tracks, _ in animations for track in tracks})
    if not moved:
        raise ClipError(path, "has no animation that moves nodes", "export the animation with it")
    problems = [
        _warning(path, f"animation {name or index}: {', '.join(ignored)} is not imported, only joints are")
        for index, (name, (_, ignored)) in enumerate(zip(names, animations, strict=True))
        if ignored
    ]
    captures = []
    for title, nodes in _skeletons(gltf, moved):
        check_limit(path, "joints", len(nodes), limit=limits.joints)
        skeleton, clips = _skeleton(gltf, title, nodes), []
        for index, (name, (tracks, _)) in enumerate(zip(names, animations, strict=True)):
            own = _above_and(gltf, nodes)
            moving = [track for track in tracks if track.node in own]
            named = str(name) if name else path.stem if len(names) == 1 else f"{path.stem}_{index}"
            if not moving:
                continue
            try:
                clips.append(_clip(gltf, nodes, moving, name=named, rate=rate, limits=limits))
            except ClipError as error:
                problems.append(Problem(severity="warning", where=str(path), message=str(error)))
        if clips:
            captures.append(Capture(skeleton=skeleton, clips=tuple(clips)))
        else:
            problems.append(_warning(path, f"skeleton {title} has no clip and is left out"))
    if not captures:
        raise ClipError(path, "has no clip for a skeleton", names=[problem.message for problem in problems])
    return tuple(captures), tuple(problems)


def _warning(path: Path, message: str) -> Problem:
    return Problem(severity="warning", where=str(path), message=f"{path}: {message}")


def _skeletons(gltf: GltfFile, moved: Sequence[int]) -> list[tuple[str, list[int]]]:
    """Name and nodes, parents first, of each skeleton."""
    skins = gltf.document.skins or []
    if not skins:
        nodes = _between(gltf, set(moved)) | _below(gltf, moved)
        return [(gltf.path.stem, _in_order(gltf, nodes))]
    groups: list[tuple[str, set[int]]] = []
    for skin in skins:
        for joint in skin.joints or []:
            gltf.item("nodes", joint)
        nodes = _between(gltf, set(skin.joints or []))
        name = str(skin.name) if skin.name and len(skins) > 1 else gltf.path.stem
        tops = _tops(gltf, nodes)
        touching = [group for group in groups if group[1] & nodes or _tops(gltf, group[1]) & tops]
        for group in touching:
            name, nodes = group[0], _between(gltf, group[1] | nodes)
            groups.remove(group)
        if nodes:
            groups.append((name, nodes))
    return [(name, _in_order(gltf, nodes)) for name, nodes in groups]


def _ancestors(gltf: GltfFile, node: int) -> list[int]:
    """The node and all above it, lowest first."""
    way = [node]
    while gltf.parents[way[-1]] >= 0:
        way.append(int(gltf.parents[way[-1]]))
    return way


def _between(gltf: GltfFile, nodes: set[int]) -> set[int]:
    """Nodes with all that lie between two of them."""
    result = set(nodes)
    for node in nodes:
        way = _ancestors(gltf, node)
        inside = [place for place, above in enumerate(way) if above in nodes]
        result.update(way[: inside[-1] + 1])
    return result


def _below(gltf: GltfFile, nodes: Sequence[int]) -> set[int]:
    """All nodes below some that hold no mesh or camera."""
    chosen = set(nodes)
    return {
        node
        for node, one in enumerate(gltf.document.nodes)
        if one.mesh is None and one.camera is None and not chosen.isdisjoint(_ancestors(gltf, node))
    }


def _tops(gltf: GltfFile, nodes: set[int]) -> set[int]:
    """The nodes of a set with none of it right above."""
    return {node for node in nodes if int(gltf.parents[node]) not in nodes}


def _above_and(gltf: GltfFile, nodes: Sequence[int]) -> set[int]:
    """Nodes with all above them."""
    return {above for node in nodes for above in _ancestors(gltf, node)}


def _in_order(gltf: GltfFile, nodes: set[int]) -> list[int]:
    """Parents before children, each with all below it before the next, in the file's order."""
    children: dict[int, list[int]] = {}
    for node in sorted(nodes, reverse=True):
        children.setdefault(int(gltf.parents[node]), []).append(node)
    order: list[int] = []
    waiting = sorted(_tops(gltf, nodes), reverse=True)
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])
    return order


def _parents(gltf: GltfFile, nodes: Sequence[int]) -> IntArray:
    places = {node: place for place, node in enumerate(nodes)}
    return np.array([places.get(int(gltf.parents[node]), -1) for node in nodes], dtype=int)


def _skeleton(gltf: GltfFile, name: str, nodes: Sequence[int]) -> Skeleton:
    """The skeleton, resting as the nodes stand without any animation."""
    parents = _parents(gltf, nodes)
    translations, rotations = _local_samples(gltf, nodes, {}, np.zeros(1))
    return Skeleton(
        name=str(gltf.path.with_name(valid_name(name))),
        joints=joint_paths([gltf.names[node] for node in nodes], parents.tolist()),
        parents=parents,
        rest_translations=translations[0],
        rest_rotations=rotations[0],
    )


def _clip(
    gltf: GltfFile, nodes: Sequence[int], tracks: Sequence[Track], *, name: str, rate: float, limits: Limits
) -> Clip:
    rate = rate or key_rate(tracks)
    start = min(float(track.times[0]) for track in tracks)
    end = max(float(track.times[-1]) for track in tracks)
    frames = int(min(np.floor((end - start) * rate + 1e-3), 1e12)) + 1
    check_limit(gltf.path, "frames", frames, limit=limits.frames)
    if frames * len(nodes) > MOST_SAMPLES:
        what = f"{name} has {frames} frames of {len(nodes)} joints, more than {MOST_SAMPLES} samples"
        raise gltf.error(what, "give a lower --rate")
    if frames < 2:
        what = f"animation {name} lasts {end - start:.3g} s, less than a frame at {rate:g} a second"
        raise gltf.error(what, "a pose is no clip; it is left out")
    times = start + np.arange(frames) / rate
    keyed = {(track.node, track.path): track for track in tracks}
    translations, rotations = _local_samples(gltf, nodes, keyed, times)
    return Clip(
        name=name,
        rate=rate,
        start_time=start,
        translations=translations,
        rotations=quaternion.continuous(rotations),
    )


def _local_samples(
    gltf: GltfFile, nodes: Sequence[int], tracks: Mapping[tuple[int, str], Track], times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint-local translations [m] (T, J, 3) and rotations (T, J, 4) without scales, of J nodes, parents first."""
    parents = _parents(gltf, nodes)
    worlds: dict[int, FloatArray] = {}
    for node in sorted(_above_and(gltf, nodes), key=lambda node: len(_ancestors(gltf, node))):
        local = _local_matrices(gltf, node, tracks, times)
        above = int(gltf.parents[node])
        worlds[node] = worlds[above] @ local if above >= 0 else local
    places = np.stack([np.broadcast_to(worlds[node][:, :3, 3], (len(times), 3)) for node in nodes], axis=1)
    turns = np.stack([np.broadcast_to(_rotations(worlds[node]), (len(times), 4)) for node in nodes], axis=1)
    translations, rotations = places.copy(), turns.copy()
    below = np.flatnonzero(parents >= 0)
    back = quaternion.inverse(turns[:, parents[below]])
    translations[:, below] = quaternion.rotate(back, places[:, below] - places[:, parents[below]])
    rotations[:, below] = quaternion.compose(back, turns[:, below])
    return translations, rotations


def _local_matrices(
    gltf: GltfFile, node: int, tracks: Mapping[tuple[int, str], Track], times: FloatArray
) -> FloatArray:
    """Matrices (column vectors) of a node, shape (T, 4, 4), or (1, 4, 4) if nothing moves it."""
    one = gltf.document.nodes[node]
    keyed = {path: tracks[node, path] for path in ("translation", "rotation", "scale") if (node, path) in tracks}
    if one.matrix is not None and not keyed:
        return _numbers(gltf, node, "matrix", one.matrix, 16).reshape(1, 4, 4).swapaxes(-1, -2)
    values = {}
    for path, default in (("translation", [0.0] * 3), ("rotation", [0.0, 0.0, 0.0, 1.0]), ("scale", [1.0] * 3)):
        stated = getattr(one, path)
        own = _numbers(gltf, node, path, default if stated is None else stated, len(default))[None]
        values[path] = sampled(keyed[path], times) if path in keyed else own
    if np.any(np.linalg.norm(values["rotation"], axis=-1) < 1e-6):
        raise gltf.error(f"nodes[{node}] has a rotation that is zero", "rotations are unit quaternions")
    matrices = np.tile(np.eye(4), (max(len(value) for value in values.values()), 1, 1))
    turned = quaternion.to_matrix(quaternion.normalised(values["rotation"]))
    matrices[:, :3, :3] = turned * values["scale"][:, None, :]
    matrices[:, :3, 3] = values["translation"]
    return matrices


def _numbers(gltf: GltfFile, node: int, name: str, value: Any, count: int) -> FloatArray:
    """So many finite numbers of a node's property."""
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (count,) or not (np.abs(numbers) <= LARGEST).all():
        raise gltf.error(f"nodes[{node}].{name} is {str(value)[:80]}", f"{count} finite numbers are right")
    return numbers


def _rotations(matrices: FloatArray) -> FloatArray:
    """The nearest rotations to the linear parts of matrices (..., 4, 4), scales and mirrors taken out."""
    linear = matrices[..., :3, :3]
    linear = linear * np.where(np.linalg.det(linear) < 0.0, -1.0, 1.0)[..., None, None]
    left, _, right = np.linalg.svd(linear)
    handed = np.linalg.det(left @ right)
    left[..., :, 2] *= np.where(handed < 0.0, -1.0, 1.0)[..., None]
    return quaternion.from_matrix(left @ right)
