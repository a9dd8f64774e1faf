"""Draws a contact sheet of a USD stage: skinned characters as written, terrain, footprints, and where the feet landed.

Needs numpy, pxr and Pillow only. Example: python tools/draw.py build/demo/crowd.usd -o build/demo/sheet.png
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from pxr import Usd, UsdGeom
from stagedraw.picture import Camera, paint
from stagedraw.raster import cover
from stagedraw.soup import FloatArray, Soup, join
from stagedraw.stage_soup import Character, character_soup, read_characters, static_soup

PERSON = 2.3
"""Diagonal of a striding person's box [m]; larger characters are seen from farther away."""
MARKS = ((40, 110, 230), (240, 130, 20))


@dataclass(frozen=True, kw_only=True)
class Show:
    """A stage brought to metres and Y up."""

    static: Soup
    characters: tuple[Character, ...]
    marks: tuple[tuple[FloatArray, int], ...]
    """Where the feet landed [m] and which foot (0 left, 1 right)."""
    to_metres: FloatArray
    """Stage to metres and Y up, shape (3, 3)."""

    def posed(self, character: Character, code: float) -> Soup:
        """A character at a time code."""
        return _turned(character_soup(character, code), self.to_metres)


def draw_contact_sheet(
    stage_path: Path | str,
    png_path: Path | str,
    *,
    frames: Sequence[float] | None = None,
    count: int = 12,
    agent: str | None = None,
    size: tuple[int, int] = (1600, 1000),
) -> Path:
    """Draw a stage: above everything with a character shown at every frame, below one close picture a frame.

    Args:
        stage_path: any stage with SkelRoots (instances too), meshes and PointInstancers of prints.
        png_path: picture to write.
        frames: time codes to show; default: `count` of them, evenly from the stage's start to its end.
        count: number of frames when none are given.
        agent: part of the path of the SkelRoot to follow; default the first one.
        size: of the picture [pixels].

    Returns:
        The path written.

    Raises:
        ValueError: if the stage shows no skinned character, or none whose path has `agent` in it.
    """
    stage = Usd.Stage.Open(str(stage_path))
    codes = (
        list(frames)
        if frames is not None
        else list(np.linspace(stage.GetStartTimeCode(), stage.GetEndTimeCode(), count))
    )
    show = _read(stage, codes[0])
    chosen = [character for character in show.characters if agent is None or agent in character.path]
    if not chosen:
        raise ValueError(
            f"{stage_path}: no skinned character{f' with {agent} in its path' if agent else ''}; "
            f"there are {[character.path for character in show.characters]}"
        )
    followed = chosen[0]
    columns = min(len(codes), 6)
    rows = -(-len(codes) // columns)
    top = size[1] * 2 // 5
    cell = (size[0] // columns, (size[1] - top) // rows)
    sheet = Image.new("RGB", size, (235, 238, 240))
    sheet.paste(_overview(show, followed, codes, (size[0], top)), (0, 0))
    for number, code in enumerate(codes):
        close = _close(show, followed, codes, number, cell)
        ImageDraw.Draw(close).text((6, 4), f"{code:g}", fill=(20, 20, 20))
        sheet.paste(close, (number % columns * cell[0], top + number // columns * cell[1]))
    sheet.save(png_path)
    return Path(png_path)


def _read(stage: Usd.Stage, code: float) -> Show:
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    upright = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) if UsdGeom.GetStageUpAxis(stage) == "Z" else np.eye(3)
    matrix = scale * upright
    marks = [(matrix @ place, side) for place, side in _landings(stage)]
    return Show(
        static=_turned(static_soup(stage, code), matrix),
        characters=tuple(read_characters(stage)),
        marks=tuple(marks),
        to_metres=matrix,
    )


def _landings(stage: Usd.Stage) -> list[tuple[FloatArray, int]]:
    """Contact positions written on the animations (`UsdfootContactAPI`), and the foot."""
    found = []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        for side, name in enumerate(("left", "right")):
            attribute = prim.GetAttribute(f"usdfoot:contact:{name}:positions")
            places = attribute.Get() if attribute else None
            found += [(np.array(place, dtype=float), side) for place in places or []]
    return found


def _turned(soup: Soup, matrix: FloatArray) -> Soup:
    upright = matrix / np.linalg.norm(matrix[0])
    return Soup(corners=soup.corners @ matrix.T, normals=soup.normals @ upright.T, colours=soup.colours)


def _overview(show: Show, followed: Character, codes: Sequence[float], size: tuple[int, int]) -> Image.Image:
    """All characters: the followed one at every frame when alone, else everybody at the middle frame."""
    if len(show.characters) == 1:
        posed = [show.posed(followed, code) for code in codes]
    else:
        posed = [show.posed(character, codes[len(codes) // 2]) for character in show.characters]
    places = np.concatenate([soup.corners.reshape(-1, 3)[::50] for soup in posed])
    if show.marks:
        places = np.concatenate([places, [place for place, _ in show.marks]])
    return _picture(show, [show.static, *posed], _framing(places, size), size)


def _framing(places: FloatArray, size: tuple[int, int]) -> Camera:
    """A camera from the side and above that sees all `places`, across their longer direction."""
    low, high = places.min(axis=0), places.max(axis=0)
    middle = 0.5 * (low + high)
    extent = high - low
    sideways = np.array([-1.0, 0.0, 0.35]) if extent[2] > extent[0] else np.array([0.35, 0.0, 1.0])
    direction = sideways / np.linalg.norm(sideways) + [0.0, 0.55, 0.0]
    direction /= np.linalg.norm(direction)
    lens, far = 5.0, 8.0
    while far < 500.0:
        camera = Camera(eye=middle + far * direction, target=middle, lens=lens)
        pixels, near = camera.project(places, size)
        if (near > 0).all() and (pixels > 12).all() and (pixels < np.asarray(size) - 12).all():
            break
        far *= 1.06
    return camera


def _close(show: Show, followed: Character, codes: Sequence[float], number: int, size: tuple[int, int]) -> Image.Image:
    """The followed character and its neighbours at one frame, from ahead and one side of where it goes."""
    code = codes[number]
    soups = [show.posed(character, code) for character in show.characters]
    own = soups[show.characters.index(followed)]
    low, high = own.corners.reshape(-1, 3).min(axis=0), own.corners.reshape(-1, 3).max(axis=0)
    middle = 0.5 * (low + high) + [0.0, -0.04, 0.0]
    yaw = _heading(show, followed, code)
    away = 5.2 * max(1.0, float(np.linalg.norm(high - low)) / PERSON)
    views = [Camera(eye=middle + away * _toward(yaw + turn), target=middle, lens=2.35) for turn in (-1.15, 1.15)]
    others = join([show.static, *(soup for soup in soups if soup is not own)])
    return _picture(show, [own, others], max(views, key=lambda view: _shown(own, others, view)), size)


def _toward(yaw: float) -> FloatArray:
    """Direction to a camera at `yaw` [rad], slightly above."""
    return np.array([np.sin(yaw), 0.22, np.cos(yaw)])


def _shown(own: Soup, others: Soup, camera: Camera) -> float:
    """How much of the character is not hidden by others, in steps of a tenth, so that the first of equals wins."""
    size = (64, 96)
    alone, together = (cover(*camera.project(soup.corners, size), size).triangle for soup in (own, join([own, others])))
    return round(10.0 * float(((together >= 0) & (together < len(own.corners))).sum()) / max((alone >= 0).sum(), 1))


def _heading(show: Show, followed: Character, code: float) -> float:
    """Yaw of the pelvis against its rest pose, in the world [rad]."""
    matrix = np.array(followed.skeleton.ComputeJointSkelTransforms(Usd.TimeCode(code))[0])[:3, :3]
    to_world = np.array(UsdGeom.XformCache(Usd.TimeCode(code)).GetLocalToWorldTransform(followed.prim))[:3, :3]
    rest = np.array(followed.skeleton.ComputeJointSkelTransforms(Usd.TimeCode(code), True)[0])[:3, :3]
    ahead = show.to_metres @ (np.array([0.0, 0.0, 1.0]) @ np.linalg.inv(rest) @ matrix @ to_world)
    return float(np.arctan2(ahead[0], ahead[2]))


def _picture(show: Show, soups: Sequence[Soup], camera: Camera, size: tuple[int, int]) -> Image.Image:
    """The painted picture with the marks of the landings that are not hidden."""
    colours, near = paint(join(soups), camera, size)
    image = Image.fromarray(np.round(255.0 * colours).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    for place, side in show.marks:
        (x, y), nearness = camera.project(place + [0.0, 0.01, 0.0], size)
        if nearness <= 0 or not (0 <= x < size[0] and 0 <= y < size[1]):
            continue
        if 1.0 / nearness < 1.0 / max(near[int(y), int(x)], 1e-9) + 0.06:
            radius = float(np.clip(0.03 * camera.lens * size[1] * nearness, 1.5, 4.0))
            box = (x - radius, y - radius, x + radius, y + radius)
            pen.ellipse(box, fill=MARKS[side], outline=(255, 255, 255) if radius > 2.5 else None)
    return image


def main(argv: list[str] | None = None) -> int:
    """Parse the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage", type=Path, help="USD stage to draw")
    parser.add_argument("-o", "--output", type=Path, required=True, help="PNG to write")
    parser.add_argument("--frames", type=float, nargs="+", help="time codes to show (default: --count of them)")
    parser.add_argument("--count", type=int, default=12, help="number of frames when none are given (default: 12)")
    parser.add_argument("--agent", help="part of the path of the character to follow (default: the first)")
    options = parser.parse_args(argv)
    print(
        draw_contact_sheet(
            options.stage, options.output, frames=options.frames, count=options.count, agent=options.agent
        )
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
