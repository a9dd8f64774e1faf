"""Draws the pictures of stages/gallery/ from the scenes in stages/. Example: `python tools/gallery.py --only crowd`."""

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from demo import write_shot
from draw import draw_contact_sheet
from PIL import Image
from pxr import Sdf, Usd, UsdGeom

from usdfoot.pipeline.analyze import analyze
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.inspect import InspectOptions, inspect

STAGES = Path(__file__).resolve().parents[1] / "stages"
GALLERY = STAGES / "gallery"
SIZE = (1056, 660)
COM_WIDTH = 0.07
"""Of the drawn path of the centre of mass [m]."""


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A contact sheet of one animated scene."""

    scene: str
    """In stages/, without its suffix."""
    frames: tuple[float, ...] | None = None
    """Time codes shown; None = evenly over the motion."""
    com: bool = False
    """Draw the path of the centre of mass."""


SHEETS = {
    "obstacle_course": Sheet(scene="obstacle_course"),
    "stepping_stones": Sheet(scene="stepping_stones"),
    "crowd": Sheet(scene="crowd"),
    "bird": Sheet(scene="physics_bird_walk"),
    "dinosaur_stairs": Sheet(scene="physics_dinosaur_stairs"),
    "dinosaur_leaps": Sheet(
        scene="physics_dinosaur_leaps",
        frames=(140.0, 152.0, 158.0, 163.0, 168.0, 172.0, 176.0, 184.0, 200.0, 222.0, 229.0, 236.0),
        com=True,
    ),
}
SPACE = "footstep_space"
"""Name of the picture of the clips' footstep space."""


def draw_sheet(name: str, target: Path, scratch: Path) -> Path:
    """Animate the scene of a sheet and draw it."""
    sheet = SHEETS[name]
    scene = STAGES / f"{sheet.scene}.usda"
    crowd = animate(scene, scratch / name).crowd_file
    shot = write_shot(crowd, scene)
    if sheet.com:
        _add_com(shot, crowd)
    picture = draw_contact_sheet(shot, scratch / f"{name}.png", frames=sheet.frames, size=SIZE)
    return _packed(picture, target / f"{name}.png")


def draw_space(target: Path, scratch: Path) -> Path:
    """The footstep and root velocity space of most examples, with their errors."""
    report = analyze(STAGES / "clips.usdc", plots=scratch / "spaces")
    largest = max(report.plots, key=lambda path: path.stat().st_size)
    return _packed(largest, target / f"{SPACE}.png", colours=256)


def _add_com(shot: Path, crowd: Path) -> None:
    """Show the path of the centre of mass in a shot, and nothing else of the overlay."""
    overlay = inspect(crowd, crowd.with_name("overlay.usda"), options=InspectOptions(kinds=("Com",))).file
    layer = Sdf.Layer.FindOrOpen(str(shot))
    layer.subLayerPaths.append(f"./{overlay.name}")
    layer.Save()
    stage = Usd.Stage.Open(layer)
    curve = UsdGeom.BasisCurves(stage.GetPrimAtPath("/__usdfoot/Com"))
    curve.GetWidthsAttr().Set([COM_WIDTH / UsdGeom.GetStageMetersPerUnit(stage)])
    curve.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    layer.Save()


def _packed(picture: Path, path: Path, *, colours: int = 0) -> Path:
    """The picture as a small file, with a palette of so many colours (0 = none; few of them are the marks')."""
    with Image.open(picture) as image:
        packed = image.convert("RGB")
        if colours:
            packed = packed.quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        packed.save(path, optimize=True)
    return path


def main(argv: Sequence[str] | None = None) -> int:
    """Draw all pictures, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "-o", "--output", type=Path, default=GALLERY, help="folder of the pictures (default: the gallery)"
    )
    parser.add_argument("--only", choices=(*SHEETS, SPACE), action="append", help="draw this one; may be repeated")
    options = parser.parse_args(argv)
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.only or (*SHEETS, SPACE):
        with tempfile.TemporaryDirectory() as scratch:
            if name == SPACE:
                print(draw_space(options.output, Path(scratch)))
            else:
                print(draw_sheet(name, options.output, Path(scratch)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
