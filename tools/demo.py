"""Animates the obstacle course and the stepping stones of stages/ into build/demo, measures and draws them.

Leaves build/demo/crowd.usd and build/demo/stones/crowd.usd, each with a picture and a shot.usda that shows the crowd on
its terrain.
"""

import os
import sys
from pathlib import Path

from draw import draw_contact_sheet
from pxr import Sdf, Usd

from usdfoot.cli.console import print_problems, results_console, shown_progress
from usdfoot.cli.tables import step_table, target_table
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate

REPOSITORY = Path(__file__).resolve().parents[1]
SCENES = (("obstacle_course.usda", ""), ("stepping_stones.usda", "stones"))
"""Scenes in stages/ and the folders within build/demo they go to."""


SET = ("/World/Terrain", "/World/Obstacles")
"""What a shot takes from the scene."""


def write_shot(crowd: Path, scene: Path) -> Path:
    """A stage beside the crowd with the crowd and the scene's terrain."""
    shot, root, source = crowd.with_name("shot.usda"), Sdf.Layer.FindOrOpen(str(crowd)), Usd.Stage.Open(str(scene))
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(root)
    layer.customLayerData = {}
    layer.subLayerPaths = [f"./{crowd.name}"]
    asset = Path(os.path.relpath(scene, shot.parent)).as_posix()
    for path in SET:
        if source.GetPrimAtPath(path):
            prim = Sdf.CreatePrimInLayer(layer, f"/Set/{Sdf.Path(path).name}")
            prim.specifier = Sdf.SpecifierDef
            prim.referenceList.prependedItems = [Sdf.Reference(asset, path)]
    layer.GetPrimAtPath("/Set").specifier = Sdf.SpecifierDef
    layer.Export(str(shot))
    return shot


def show(scene: Path, folder: Path) -> bool:
    """Animate, measure and draw one scene; gives back whether every agent was written."""
    console = results_console()
    console.rule(scene.name)
    with shown_progress(quiet=False) as progress:
        report = animate(scene, folder, progress=progress)
        progress("validate", 0, 0)
        validation = validate(report.crowd_file)
        progress("draw", 0, 0)
        picture = draw_contact_sheet(write_shot(report.crowd_file, scene), folder / f"{scene.stem}.png")
    print_problems(report.skipped, quiet=False)
    console.print(step_table(report.results, report.totals))
    console.print(target_table(validation.total))
    for file in (report.crowd_file, picture):
        console.print(f"wrote {file.relative_to(REPOSITORY)}")
    return not report.skipped


def main() -> int:
    """All demo scenes; 0 = every agent was written."""
    target = REPOSITORY / "build" / "demo"
    written = [show(REPOSITORY / "stages" / scene, target / folder) for scene, folder in SCENES]
    return 0 if all(written) else 1


if __name__ == "__main__":
    sys.exit(main())
