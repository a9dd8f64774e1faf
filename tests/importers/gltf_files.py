"""glTF files made up for tests, and a textbook reader of them: matrices, loops over everything, plain JSON."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
SIZES = {"translation": 3, "rotation": 4, "scale": 3}


class GltfBuilder:
    """A document and its one buffer, put together piece by piece."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "nodes": [],
            "accessors": [],
            "bufferViews": [],
            "animations": [],
        }

    def view(self, data: bytes, stride: int = 0) -> int:
        """Index of a new buffer view."""
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.document["bufferViews"].append(view | ({"byteStride": stride} if stride else {}))
        self.data += data
        return len(self.document["bufferViews"]) - 1

    def numbers(self, values: np.ndarray, *, short: bool = False, gap: int = 0) -> int:
        """Index of a new accessor: floats, or normalised shorts; `gap` bytes between elements."""
        values = np.asarray(values, dtype=float).reshape(len(values), -1)
        raw = np.round(values * 32767).astype("<i2") if short else values.astype("<f4")
        rows = [row.tobytes() + bytes(gap) for row in raw]
        stride = raw.dtype.itemsize * values.shape[1] + gap
        accessor = {
            "bufferView": self.view(b"".join(rows), stride if gap else 0),
            "componentType": 5122 if short else 5126,
            "count": len(values),
            "type": TYPES[values.shape[1]],
        }
        self.document["accessors"].append(accessor | ({"normalized": True} if short else {}))
        return len(self.document["accessors"]) - 1

    def animate(self, name: str, channels: list[tuple[int, str, str, np.ndarray, np.ndarray]], **options) -> None:
        """An animation of (node, path, interpolation, times, values)."""
        animation: dict[str, Any] = {"name": name, "channels": [], "samplers": []}
        for node, path, interpolation, times, values in channels:
            sampler = {"input": self.numbers(times), "output": self.numbers(values, **options)}
            animation["samplers"].append(sampler | {"interpolation": interpolation})
            target = {"node": node, "path": path}
            animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})
        self.document["animations"].append(animation)

    def save(self, file: Path, how: str = "embedded") -> Path:
        """Write .gltf with an embedded buffer or one beside it, or .glb."""
        buffer: dict[str, Any] = {"byteLength": len(self.data)}
        if how == "embedded":
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        elif how == "beside":
            buffer["uri"] = "some%20data.bin"
            (file.parent / "some data.bin").write_bytes(self.data)
        text = json.dumps(self.document | {"buffers": [buffer]})
        if how != "glb":
            file.write_text(text)
            return file
        chunk = text.encode() + b" " * (-len(text.encode()) % 4)
        blob = bytes(self.data) + bytes(-len(self.data) % 4)
        size = 12 + 8 + len(chunk) + 8 + len(blob)
        parts = [b"glTF", struct.pack("<II", 2, size), struct.pack("<I", len(chunk)), b"JSON", chunk]
        file.write_bytes(b"".join([*parts, struct.pack("<I", len(blob)), b"BIN\0", blob]))
        return file


def random_gltf(generator: np.random.Generator) -> GltfBuilder:
    """Ten nodes, some of them joints of one or two skins, moved by keys of every interpolation."""
    builder, count = GltfBuilder(), 10
    parents = [-1, *(int(generator.integers(-1, node)) for node in range(1, count))]
    for node in range(count):
        one: dict[str, Any] = {"name": f"node {node}"}
        if generator.random() < 0.2:
            matrix = np.eye(4)
            matrix[:3, :3] = quaternion.to_matrix(random_turns(generator, 1))[0] * generator.uniform(0.5, 2.0)
            matrix[:3, 3] = generator.normal(size=3)
            one["matrix"] = matrix.T.ravel().tolist()
        else:
            one |= {"translation": generator.normal(size=3).tolist()} if generator.random() < 0.9 else {}
            one |= {"rotation": random_turns(generator, 1)[0].tolist()} if generator.random() < 0.7 else {}
            one |= {"scale": [float(generator.uniform(0.2, 2.0))] * 3} if generator.random() < 0.4 else {}
        children = [child for child, parent in enumerate(parents) if parent == node]
        builder.document["nodes"].append(one | ({"children": children} if children else {}))
    skins = int(generator.integers(0, 3))
    if skins:
        builder.document["skins"] = [
            {"joints": sorted(generator.choice(count, size=5, replace=False).tolist())} for _ in range(skins)
        ]
    channels = []
    for node in generator.choice(count, size=6, replace=False).tolist():
        if "matrix" in builder.document["nodes"][node]:
            continue
        for path, size in SIZES.items():
            if generator.random() < 0.6:
                channels.append(random_channel(generator, node, path, size))
    channels.append(random_channel(generator, random_plain_node(builder), "rotation", 4))
    builder.animate("moves", channels)
    return builder


def random_plain_node(builder: GltfBuilder) -> int:
    """A node without a matrix, which may not be animated; one is made if there is none."""
    for node, one in enumerate(builder.document["nodes"]):
        if "matrix" not in one:
            return node
    del builder.document["nodes"][0]["matrix"]
    return 0


def random_channel(generator: np.random.Generator, node: int, path: str, size: int):
    interpolation = ["LINEAR", "STEP", "CUBICSPLINE"][generator.integers(3)]
    frames = np.sort(generator.choice(24, size=generator.integers(2, 6), replace=False))
    rows = len(frames) * (3 if interpolation == "CUBICSPLINE" else 1)
    values = generator.normal(size=(rows, size)) if path == "translation" else random_turns(generator, rows)
    if path == "scale":
        values = np.repeat(generator.uniform(0.5, 2.0, (rows, 1)), 3, axis=1)
    return node, path, interpolation, frames / 30.0, values


def random_turns(generator: np.random.Generator, count: int) -> np.ndarray:
    turns = generator.normal(size=(count, 4))
    return turns / np.linalg.norm(turns, axis=1, keepdims=True)


def gltf_of(skeleton: Skeleton, clip: Clip, *, above: dict[str, Any] | None = None, short: bool = False) -> GltfBuilder:
    """A clip as keys of all joints of a skin; `above` is a node over the skeleton."""
    builder = GltfBuilder()
    count = len(skeleton.joints)
    for joint, path in enumerate(skeleton.joints):
        children = np.flatnonzero(skeleton.parents == joint).tolist()
        one = {"name": path.rsplit("/", 1)[-1], "translation": skeleton.rest_translations[joint].tolist()}
        one["rotation"] = skeleton.rest_rotations[joint].tolist()
        builder.document["nodes"].append(one | ({"children": children} if children else {}))
    builder.document["nodes"].append({"name": "Armature", "children": [0], **(above or {})})
    builder.document["skins"] = [{"joints": list(range(count))}]
    times = clip.times
    moves = [(joint, "translation", "LINEAR", times, clip.translations[:, joint]) for joint in range(count)]
    turns = [(joint, "rotation", "LINEAR", times, clip.rotations[:, joint]) for joint in range(count)]
    builder.animate("walk", moves)
    (first,) = builder.document["animations"]
    builder.animate("walk", turns, short=short)
    second = builder.document["animations"].pop()
    for channel in second["channels"]:
        first["channels"].append(channel | {"sampler": channel["sampler"] + len(first["samplers"])})
    first["samplers"] += second["samplers"]
    return builder


def naive_positions(file: Path, times) -> dict[str, np.ndarray]:
    """World positions (T, 3) of all nodes by name, of a .gltf with an embedded buffer and its first animation."""
    document = json.loads(file.read_text())
    data = base64.b64decode(document["buffers"][0]["uri"].split(",")[1])
    nodes = document["nodes"]
    parents = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}

    def numbers(index: int) -> list[list[float]]:
        accessor = document["accessors"][index]
        size = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
        return [list(struct.unpack_from(f"<{size}f", data, start + 4 * size * i)) for i in range(accessor["count"])]

    tracks = {}
    animation = document["animations"][0]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        keys = [row[0] for row in numbers(sampler["input"])]
        entry = (sampler["interpolation"], keys, numbers(sampler["output"]))
        tracks[channel["target"]["node"], channel["target"]["path"]] = entry

    def value(node: int, path: str, time: float) -> np.ndarray:
        if (node, path) not in tracks:
            default = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}[path]
            return np.array(nodes[node].get(path, default), dtype=float)
        kind, keys, rows = tracks[node, path]
        values = rows[1::3] if kind == "CUBICSPLINE" else rows
        if time <= keys[0] or time >= keys[-1]:
            return np.array(values[0 if time <= keys[0] else -1])
        i = max(k for k in range(len(keys)) if keys[k] <= time)
        t = (time - keys[i]) / (keys[i + 1] - keys[i])
        a, b = np.array(values[i]), np.array(values[i + 1])
        if kind == "STEP":
            return a
        if kind == "CUBICSPLINE":
            length = keys[i + 1] - keys[i]
            out, into = length * np.array(rows[3 * i + 2]), length * np.array(rows[3 * i + 3])
            return ((2 * t**3 - 3 * t**2 + 1) * a + (t**3 - 2 * t**2 + t) * out + (-2 * t**3 + 3 * t**2) * b) + (
                t**3 - t**2
            ) * into
        if path != "rotation":
            return (1 - t) * a + t * b
        angle = np.arccos(min(1.0, abs(a @ b)))
        b = b if a @ b >= 0 else -b
        return a if angle < 1e-9 else (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)

    def world(node: int, time: float) -> np.ndarray:
        local = np.eye(4)
        if "matrix" in nodes[node]:
            local = np.array(nodes[node]["matrix"]).reshape(4, 4).T
        else:
            x, y, z, w = value(node, "rotation", time) / np.linalg.norm(value(node, "rotation", time))
            turned = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
            local[:3, :3] = np.array(turned) @ np.diag(value(node, "scale", time))
            local[:3, 3] = value(node, "translation", time)
        return world(parents[node], time) @ local if node in parents else local

    return {node["name"]: np.array([world(index, time)[:3, 3] for time in times]) for index, node in enumerate(nodes)}
