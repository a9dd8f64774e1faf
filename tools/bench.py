"""Measures the speed of usdfoot on one core and prints a table: `make bench`.

Examples:
  python tools/bench.py --json
  python tools/bench.py --crowd 10,100,1000,10000 --markdown build/bench/crowds.md
"""

import argparse
import json
import os
import platform
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from benching.crowd import crowd_times, draw_growth, growth_exponent
from benching.disk import disk_times
from benching.kernels import frame_times, step_times
from benching.physics import physics_times
from benching.plans import plan_times
from benching.realtime import realtime_times
from benching.spaces import space_figures

from usdfoot.bridge.versions import library_versions
from usdfoot.model.clip import ClipLibrary
from usdfoot.physics.biped import measure_biped
from usdfoot.readers.libraries import read_libraries

STAGES = Path(__file__).resolve().parents[1] / "stages"
GROWTH = STAGES.parent / "build" / "bench" / "growth.png"
DURATIONS = ("one process [s]", "author alone [s]")
"""Figures of crowds that should grow as the crowds do."""
JOINTS = (22, 30, 65)
REALTIME_AGENTS = 1500
CLIPS = 24
"""Clips of the library that frames and steps are measured with."""
TARGETS = {
    "frame": "<= 4 at 65 joints",
    "locate, weights, correction": "<= 30",
    "locate, weights, correction [us]": "<= 30",
    "agents at 25 frames a second": ">= 1500 ([B]: 60)",
    "ratio": "<= 1.5",
    "together": "<= 1",
    "footsteps, together": "<= 1",
    "12 steps": "<= 10",
    "one footstep more": "<= 1",
}


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
    figures |= {f"space, {title}": parts for title, parts in space_figures(few).items()}
    figures[f"real time, {REALTIME_AGENTS} agents, {JOINTS[-1]} joints"] = realtime_times(
        few, JOINTS[-1], agents=REALTIME_AGENTS
    )
    figures |= {f"plan of 12 footsteps, {name} [ms]": parts for name, parts in plan_times().items()}
    figures["physics, centre of mass [ms]"] = physics_times(measure_biped(library.skeleton, library.biped))
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


def crowd_report(figures: Mapping[int, Mapping[str, float]], *, frames: int) -> str:
    """Figures of crowds as Markdown, with the machine they were measured on."""
    names = list(next(iter(figures.values())))
    lines = [
        "# Benchmarks",
        "",
        f"`python tools/bench.py --crowd {','.join(map(str, figures))}`: people who walk for {frames} frames, with the",
        f"clips of `stages/`, on {machine()}.",
        "",
        "| | " + " | ".join(f"{agents:,} agents" for agents in figures) + " |",
        "|---|" + "---|" * len(figures),
        *(f"| {name} | " + " | ".join(rounded(row[name]) for row in figures.values()) + " |" for name in names),
        "",
        "Growth from the smallest to the largest crowd, as the exponent of the number of agents (1 = twice the agents",
        "take twice the time):",
        "",
        *(f"- {name}: {growth_exponent(figures, name):.2f}" for name in DURATIONS),
    ]
    return "\n".join(lines) + "\n"


def rounded(value: float) -> str:
    """A figure with three digits, or with all before the point."""
    return f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def machine() -> str:
    """Processor, cores and versions."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    versions = ", ".join(f"{name} {version}" for name, version in library_versions().items())
    processor = names[0] if names else platform.processor() or platform.machine()
    return f"{os.cpu_count()} cores of {processor}, {platform.system()}, Python {platform.python_version()}, {versions}"


def main(argv: list[str] | None = None) -> int:
    """Parse the command line, measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=100, help="people of the crowd on disk (default: 100)")
    parser.add_argument("--frames", type=int, default=240, help="samples of each (default: 240)")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--crowd", metavar="N,N", type=sizes, help="measure crowds of these sizes instead")
    parser.add_argument("--markdown", metavar="FILE", type=Path, help="write the crowds' figures there")
    arguments = parser.parse_args(argv)
    if arguments.crowd:
        return main_crowd(arguments)
    figures = measure(agents=arguments.agents, frames=arguments.frames)
    print(json.dumps(figures, indent=1) if arguments.json else table(figures))
    return 0


def main_crowd(arguments: argparse.Namespace) -> int:
    """Measure crowds, draw how they grow, print and perhaps write the figures."""
    figures = {n: crowd_times(STAGES, agents=n, frames=arguments.frames) for n in arguments.crowd}
    draw_growth(figures, DURATIONS, GROWTH)
    report = crowd_report(figures, frames=arguments.frames)
    if arguments.markdown:
        arguments.markdown.write_text(report, encoding="utf-8")
    print(json.dumps(figures, indent=1) if arguments.json else report)
    print(f"drew {GROWTH.relative_to(STAGES.parent)}", file=sys.stderr)
    return 0


def sizes(text: str) -> list[int]:
    """Numbers of agents, increasing."""
    numbers = sorted({int(part) for part in text.split(",") if part.isdecimal()})
    if len(numbers) < 2 or numbers[0] < 1:
        raise argparse.ArgumentTypeError(f"{text!r} are no two sizes; give numbers of agents, like 10,100,1000")
    return numbers


if __name__ == "__main__":
    sys.exit(main())
