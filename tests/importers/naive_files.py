"""Textbook readers of motion capture files: matrices, loops over everything, straight from the text.

They know nothing of the importers, take only well-formed files, and give joint positions in the files' own units.
"""

from __future__ import annotations

import math

import numpy as np


def turn(axis: str, degrees: float) -> np.ndarray:
    """4x4 matrix (column vectors) of a rotation about x, y or z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def shift(offset) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def bvh_positions(text: str) -> tuple[list[str], np.ndarray]:
    """Names and positions (T, J, 3) of all joints of a BVH file; End Sites are left out."""
    words = text.split()
    names, parents, offsets, channels, stack = [], [], [], [], []
    at = words.index("ROOT")
    while words[at] != "MOTION":
        word = words[at]
        if word in ("ROOT", "JOINT"):
            names.append(words[at + 1])
            parents.append(stack[-1] if stack else None)
            stack.append(len(names) - 1)
            at += 2
        elif word == "End":
            stack.append(None)
            at += 2
        elif word == "OFFSET":
            if stack[-1] is not None:
                offsets.append([float(value) for value in words[at + 1 : at + 4]])
                channels.append([])
            at += 4
        elif word == "CHANNELS":
            count = int(words[at + 1])
            channels[stack[-1]] = words[at + 2 : at + 2 + count]
            at += 2 + count
        else:
            if word == "}":
                stack.pop()
            at += 1
    frames = int(words[at + 2])
    numbers = [float(word) for word in words[at + 6 :]]
    positions = []
    for frame in range(frames):
        row = iter(numbers[frame * sum(map(len, channels)) :])
        worlds = []
        for joint in range(len(names)):
            offset, rotation = list(offsets[joint]), np.eye(4)
            for channel in channels[joint]:
                value, axis = next(row), channel[0].lower()
                if channel.endswith("position"):
                    offset["xyz".index(axis)] = value
                else:
                    rotation = rotation @ turn(axis, value)
            above = worlds[parents[joint]] if parents[joint] is not None else np.eye(4)
            worlds.append(above @ shift(offset) @ rotation)
        positions.append([world[:3, 3] for world in worlds])
    return names, np.array(positions)


def acclaim_positions(asf: str, amc: str, *, degrees: float = 1.0) -> tuple[list[str], np.ndarray]:
    """Names and positions (T, J, 3) of the beginnings of all bones of an ASF file moved by an AMC file.

    `degrees` are those in the files' unit of angle.
    """
    bones, children = {"root": {"direction": [0, 0, 0], "length": [0], "dof": ["tx", "ty", "tz", "rx", "ry", "rz"]}}, {}
    section, bone = "", bones["root"]
    for line in asf.splitlines():
        words = line.split()
        if not words or words[0].startswith(("#", "(")):
            continue
        if words[0].startswith(":"):
            section = words[0]
        elif section == ":root":
            key = {"order": "dof", "orientation": "turned"}.get(words[0], words[0])
            bones["root"][key] = [word.lower() for word in words[1:]]
        elif section == ":bonedata" and words[0] == "name":
            bone = bones.setdefault(words[1], {"dof": []})
        elif section == ":bonedata" and words[0] in ("direction", "length", "axis", "dof"):
            bone[words[0]] = [word.lower() for word in words[1:]]
        elif section == ":hierarchy" and len(words) > 1:
            children.setdefault(words[0], []).extend(words[1:])
    root = bones["root"]
    root["axis"] = [*root.get("turned", ["0", "0", "0"]), *root.get("axis", ["xyz"])]
    frames, names = [], []
    for line in amc.splitlines():
        words = line.split()
        if words and words[0].isdigit():
            frames.append({})
        elif words and not words[0].startswith((":", "#")):
            frames[-1][words[0]] = [float(word) for word in words[1:]]
    positions = []
    for values in frames:
        places: dict[str, np.ndarray] = {}

        def place(name: str, above: np.ndarray, places=places, values=values) -> None:
            places[name] = above
            bone = bones[name]
            axis = np.eye(4)
            for letter, angle in zip(bone["axis"][3], bone["axis"][:3], strict=True):
                axis = turn(letter, degrees * float(angle)) @ axis
            local = np.eye(4)
            for freedom, value in zip(bone["dof"], values.get(name, []), strict=False):
                if freedom[0] == "r":
                    local = turn(freedom[1], degrees * value) @ local
                else:
                    above = above @ shift(np.eye(3)["xyz".index(freedom[1])] * value)
            places[name] = above
            world = above @ axis @ local @ np.linalg.inv(axis)
            end = np.array([float(word) for word in bone["direction"]]) * float(bone["length"][0])
            for child in children.get(name, []):
                place(child, world @ shift(end))

        place("root", shift([float(word) for word in root.get("position", "000")]))
        names = list(places)
        positions.append([places[name][:3, 3] for name in names])
    return names, np.array(positions)
