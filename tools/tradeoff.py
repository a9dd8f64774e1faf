"""Footstep error against root velocity error for root weights (lambda4) from 0 to 1 ([B] 5).

Animates the agents of a scene at every root weight and prints, over all steps: how far the blended landing is from its
footstep, how far the mean root velocity of the blended clips is from the wanted one, how many steps gave up their
footstep, and the largest slide of a planted ball. --plot draws the first two.

Agents with a trajectory walk the footsteps planned for it, the same at every weight.

Example: python tools/tradeoff.py stages/stepping_stones.usda --plot build/tradeoff.png
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from usdfoot.engine.animate import PreparedLibraries, animate_crowd
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.agent import Crowd
from usdfoot.pipeline.plots import require_matplotlib
from usdfoot.planning.followers import plan_followers
from usdfoot.readers.scene import read_scene


@dataclass(frozen=True, kw_only=True)
class Tradeoff:
    """Figures of all steps at one root weight."""

    root_weight: float
    footstep_mean: float
    """Blended landing to footstep, before IK [m]."""
    footstep_worst: float
    velocity_mean: float
    """Root velocity of the blended clips to the wanted one [m/s]."""
    velocity_worst: float
    given_up: float
    """Part of the steps that stand where they land."""
    slide: float
    """Largest drift of a planted ball [m]."""


def trade(crowd: Crowd, weights: Sequence[float], *, beyond: str) -> list[Tradeoff]:
    """Figures of a crowd at every root weight.

    Raises:
        UsdfootError: If no agent can be animated.
    """
    libraries = PreparedLibraries(EngineOptions())
    crowd, _, _ = plan_followers(crowd, options=EngineOptions(), libraries=libraries)
    found = []
    for weight in weights:
        options = EngineOptions(root_weight=weight, beyond_beta=beyond)
        motions, problems = animate_crowd(crowd, options=options, libraries=libraries)
        if not motions:
            raise UsdfootError("scene", "has no agent that can be animated", "; ".join(p.message for p in problems))
        results = [motion.results for motion in motions]
        blend, velocity, slide = (
            np.concatenate([getattr(result, name) for result in results])
            for name in ("blend_error", "root_velocity_error", "slide")
        )
        statuses = [status for result in results for status in result.status]
        found.append(
            Tradeoff(
                root_weight=float(weight),
                footstep_mean=float(blend.mean()),
                footstep_worst=float(blend.max()),
                velocity_mean=float(velocity.mean()),
                velocity_worst=float(velocity.max()),
                given_up=statuses.count("rootWeighted") / len(statuses),
                slide=float(np.nanmax(slide)),
            )
        )
    return found


def table(found: Sequence[Tradeoff]) -> str:
    """Figures as a Markdown table."""
    lines = [
        "| root weight | footstep mean [mm] | worst | root velocity mean [m/s] | worst | given up | slide [mm] |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {own.root_weight:.2f} | {1e3 * own.footstep_mean:.1f} | {1e3 * own.footstep_worst:.1f} | "
        f"{own.velocity_mean:.3f} | {own.velocity_worst:.3f} | {own.given_up:.0%} | {1e3 * own.slide:.3f} |"
        for own in found
    ]
    return "\n".join(lines)


def draw(found: Sequence[Tradeoff], title: str, path: str) -> None:
    """Footstep error over root velocity error, a point for each root weight."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    velocities = [own.velocity_mean for own in found]
    landings = [1e3 * own.footstep_mean for own in found]
    axes.plot(velocities, landings, color="0.6", lw=1.0)
    points = axes.scatter(velocities, landings, c=[own.root_weight for own in found], cmap="viridis", zorder=3)
    figure.colorbar(points, ax=axes, label="root weight (lambda4)")
    for own in (found[0], found[-1]):
        axes.annotate(
            f"{own.root_weight:g}",
            (own.velocity_mean, 1e3 * own.footstep_mean),
            textcoords="offset points",
            xytext=(8, 4),
        )
    axes.set(title=title, xlabel="mean root velocity error [m/s]", ylabel="mean footstep error before IK [mm]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(color="0.9", lw=0.5)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def main(argv: list[str] | None = None) -> int:
    """Parse the command line, animate and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="USD file with characters, clips and footstep plans")
    parser.add_argument("--steps", type=int, default=11, help="root weights from 0 to 1 (default: 11)")
    parser.add_argument(
        "--beyond", choices=("segment", "closest"), default="segment", help="where steps land beyond beta"
    )
    parser.add_argument("--plot", metavar="PNG", help="picture to draw (extra: report)")
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args(argv)
    try:
        if arguments.plot:
            require_matplotlib()
        weights = np.linspace(0.0, 1.0, max(arguments.steps, 2)).round(6).tolist()
        found = trade(read_scene(arguments.scene).crowd, weights, beyond=arguments.beyond)
    except UsdfootError as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps([asdict(own) for own in found], indent=1) if arguments.json else table(found))
    if arguments.plot:
        draw(found, arguments.scene, arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
