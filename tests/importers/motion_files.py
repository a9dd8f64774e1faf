"""Motion capture files made up for tests: random ones, and those of known clips."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

ORDERS = ("xyz", "xzy", "yxz", "yzx", "zxy", "zyx")


def random_bvh(generator: np.random.Generator, *, joints: int = 6, frames: int = 3) -> str:
    """A BVH file with any channels in any order, signs and exponents in its numbers, CRLF and comments now and then."""
    parents = [-1, *(int(generator.integers(0, joint)) for joint in range(1, joints))]
    end = ["\n", "\r\n"][generator.integers(2)]
    lines, counts = ["HIERARCHY"], []

    def number() -> str:
        value = generator.normal() * 10.0 ** generator.integers(-3, 3)
        return [f"{value:.6f}", f"{value:.7e}", f"{value:+.8g}"][generator.integers(3)]

    def write(joint: int) -> None:
        kinds = [f"{axis}rotation" for axis in ORDERS[generator.integers(6)]][: generator.choice([0, 1, 2, 3, 3, 3])]
        if joint == 0 or generator.random() < 0.3:
            places = [f"{axis}position" for axis in ORDERS[generator.integers(6)]][: generator.choice([1, 3, 3])]
            kinds = [*places, *kinds] if generator.random() < 0.7 else [*kinds, *places]
        kinds = [kind[0].upper() + kind[1:] for kind in kinds]
        bracket = [" {", end + "{"][generator.integers(2)]
        lines.append(f"{'JOINT' if joint else 'ROOT'} joint{joint}{bracket}")
        lines.append(f"  OFFSET\t{number()} {number()}  {number()}" + "  # where it is" * int(generator.integers(2)))
        lines.append(" ".join(["  CHANNELS", str(len(kinds)), *kinds]))
        counts.append(len(kinds))
        children = [child for child, parent in enumerate(parents) if parent == joint]
        for child in children:
            write(child)
        if not children:
            lines.extend(["End Site", "{", f"OFFSET {number()} 0 0", "}"])
        lines.append("}")

    write(0)
    lines += ["", "MOTION", f"Frames: {frames}", "Frame Time:\t0.0083333"]
    lines += [" ".join(number() for _ in range(sum(counts))) + " " for _ in range(frames)]
    return end.join(lines) + end * int(generator.integers(3))


def random_acclaim(generator: np.random.Generator, *, bones: int = 6, frames: int = 3) -> tuple[str, str]:
    """An ASF and an AMC file with bones of any axes and degrees of freedom."""
    angle = ["deg", "rad"][generator.integers(2)]
    scale = 1.0 if angle == "deg" else np.pi / 180.0
    freedoms = {"root": ["TX", "TY", "TZ", *(f"R{axis.upper()}" for axis in ORDERS[generator.integers(6)])]}
    lines = ["# made up", ":version 1.10", ":name test", ":units", "  mass 1.0", "  length 0.45", f"  angle {angle}"]
    position = generator.normal(size=3).round(4)
    lines += [":documentation", "  a file", ":root", f"   order {' '.join(freedoms['root'])}", "   axis XYZ"]
    lines += [f"   position {' '.join(map(str, position))}", "   orientation 0 0 0", ":bonedata"]
    parents = {}
    for bone in range(bones):
        name = f"bone{bone}"
        parents[name] = ["root", *(f"bone{other}" for other in range(bone))][generator.integers(bone + 1)]
        direction = generator.normal(size=3)
        direction /= np.linalg.norm(direction)
        axes = ORDERS[generator.integers(6)]
        freedoms[name] = [f"r{axis}" for axis in axes][: generator.integers(4)]
        angles = scale * generator.uniform(-180.0, 180.0, 3)
        lines += ["  begin", f"     id {bone + 1}", f"     name {name}"]
        lines += [f"     direction {' '.join(f'{value:.9g}' for value in direction)}"]
        lines += [f"     length {generator.uniform(0.1, 9.0):.6g}"]
        lines += [f"     axis {' '.join(f'{value:.9g}' for value in angles)}   {axes.upper()}"]
        if freedoms[name]:
            lines += [f"    dof {' '.join(freedoms[name])}", "    limits (-160.0 20.0)", "           (-70.0 70.0)"]
        lines += ["  end"]
    lines += [":hierarchy", "  begin"]
    for parent in ("root", *parents):
        own = [name for name, above in parents.items() if above == parent]
        lines += [" ".join(["   ", parent, *own])] if own else []
    lines += ["  end"]
    moved = ["#!OML:ASF made up", ":FULLY-SPECIFIED", ":DEGREES" if angle == "deg" else ":RADIANS"]
    for frame in range(frames):
        moved.append(str(frame + 7))
        for name, kinds in freedoms.items():
            if kinds:
                values = [generator.normal() if kind[0] == "T" else scale * generator.normal() * 90 for kind in kinds]
                moved.append(" ".join([name, *(f"{value:.9g}" for value in values)]))
    return "\r\n".join(lines) + "\r\n", "\n".join(moved) + "\n"


def bvh_of(skeleton: Skeleton, clip: Clip, *, metres: float = 0.01) -> str:
    """A clip as a BVH file with Z, X, Y rotations, and positions where they change; `metres` are those in its unit."""
    moving = np.ptp(clip.translations, axis=0).max(axis=1) > 0.0
    lines, order = ["HIERARCHY"], []

    def write(joint: int, depth: int) -> None:
        indent = "  " * depth
        order.append(joint)
        offset = skeleton.rest_translations[joint] / metres
        kinds = ["Zrotation", "Xrotation", "Yrotation"]
        kinds = ["Xposition", "Yposition", "Zposition", *kinds] if moving[joint] else kinds
        lines.append(f"{indent}{'JOINT' if joint else 'ROOT'} {skeleton.joints[joint].rsplit('/', 1)[-1]}")
        lines.append(f"{indent}{{\n{indent}  OFFSET {' '.join(f'{value:.7f}' for value in offset)}")
        lines.append(f"{indent}  CHANNELS {len(kinds)} {' '.join(kinds)}")
        children = np.flatnonzero(skeleton.parents == joint).tolist()
        for child in children:
            write(child, depth + 1)
        if not children:
            lines.append(f"{indent}  End Site\n{indent}  {{\n{indent}    OFFSET 0 0 0\n{indent}  }}")
        lines.append(f"{indent}}}")

    write(0, 0)
    columns = []
    for joint in order:
        columns += [clip.translations[:, joint] / metres] if moving[joint] else []
        columns.append(Rotation.from_quat(clip.rotations[:, joint]).as_euler("ZXY", degrees=True))
    rows = [" ".join(f"{value:.6f}" for value in row) for row in np.concatenate(columns, axis=1)]
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {1.0 / clip.rate:.7f}", *rows]
    return "\n".join(lines) + "\n"
