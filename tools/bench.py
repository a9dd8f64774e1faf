"""Measures the speed of usdfoot on one core and prints a table: `make bench`.

Example: python tools/bench.py --json
"""

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from benching.disk import disk_times
from benching.kernels import frame_times, step_times

from usdfoot.model.clip import ClipLibrary
from usdfoot.readers.libraries import read_libraries

STAGES = Path(__file__).resolve().parents[1] / "stages"
JOINTS = (22, 30, 65)
CLIPS = 24
"""Clips of the library that frames and steps are measured with."""
TARGETS = {"frame": "<= 4 at 65 joints", "locate, weights, correction": "<= 30", "ratio": "<= 1.5"}


def measure(*, agents: int, frames: int) -> dict[str, dict[str, float]]:
    """All figures: microseconds per agent-frame and per step, seconds on disk.

    Args:
        agents: People of the crowd on disk.
        frames: Samples of each.
    """
    library = read_libraries(STAGES / "clips.usdc").libraries[0]
    few = spread_clips(library)
    figures = {f"frame, {joints} joints [us]": frame_times(few, joints) for joints in JOINTS}
    figures["step [us]"] = step_times(few)
    figures[f"disk, {agents} agents x {frames} frames [s]"] = disk_times(STAGES, agents=agents, frames=frames)
    return figures


def spread_clips(library: ClipLibrary) -> ClipLibrary:
    """CLIPS of the library's clips, evenly chosen."""
    every = max(1, len(library.clips) // CLIPS)
    return replace(library, clips=library.clips[::every])


def table(figures: Mapping[str, Mapping[str, float]]) -> str:
    """Figures as text, targets beside them."""
    lines = []
    for title, parts in figures.items():
        lines.append(title)
        for part, value in parts.items():
            target = TARGETS.get(part, "") if part != "frame" or "65" in title else ""
            lines.append(f"  {part:<30} {value:9.3f}  {target}".rstrip())
    return "\n".join(lines)


def main(argv: list[str] | None = None) -> int:
    """Parse the command line, measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=100, help="people of the crowd on disk (default: 100)")
    parser.add_argument("--frames", type=int, default=240, help="samples of each (default: 240)")
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args(argv)
    figures = measure(agents=arguments.agents, frames=arguments.frames)
    print(json.dumps(figures, indent=1) if arguments.json else table(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
