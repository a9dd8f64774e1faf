"""Makes `stages/`: the person, its clips, a bird, a dinosaur, terrains and scenes. The same bytes on every run.

Example: python tools/make_stages.py -o stages
"""

import argparse
from pathlib import Path

from stagecraft.animal_stage import write_animal
from stagecraft.bird import bird
from stagecraft.clips_stage import make_clip, write_clips
from stagecraft.dinosaur import dinosaur
from stagecraft.figures import measure, table
from stagecraft.gaits import all_clips
from stagecraft.goal_stages import write_goal_scenes
from stagecraft.human_stage import write_human
from stagecraft.physics_stages import write_physics_scenes
from stagecraft.rig import human_foot, human_rig
from stagecraft.scene_stages import write_scenes
from stagecraft.terrain_stages import write_terrains


def make_stages(folder: Path) -> list[Path]:
    """Write every stage into `folder` and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    rig, foot = human_rig(), human_foot()
    clips = [make_clip(plan, rig, foot) for plan in all_clips()]
    write_human(folder / "human.usdc", rig, foot)
    write_animal(folder / "bird.usdc", bird())
    write_animal(folder / "dinosaur.usdc", dinosaur())
    write_clips(folder / "clips.usdc", clips, rig, human="./human.usdc")
    write_terrains(folder)
    write_scenes(folder)
    write_goal_scenes(folder)
    write_physics_scenes(folder)
    return sorted(folder.glob("*.usd?"))


def main(argv: list[str] | None = None) -> int:
    """Parse the command line; make the stages, or measure the clips."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("stages"), help="folder to write (default: stages)")
    parser.add_argument("--figures", action="store_true", help="print what the clips measure instead of writing")
    options = parser.parse_args(argv)
    if options.figures:
        rig, foot = human_rig(), human_foot()
        print("\n".join(table([measure(make_clip(plan, rig, foot), rig, foot) for plan in all_clips()])))
        return 0
    for path in make_stages(options.output):
        print(f"{path}  {path.stat().st_size / 1024:.0f} kB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
