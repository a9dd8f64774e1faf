"""Flags of bodies that physics moves: what an animator turns ([P] 3)."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from usdfoot.physics.options import PhysicsOptions
    from usdfoot.physics.style import BodyStyle

__all__ = ["add_physics_flags", "body_style", "physics_options"]


def add_physics_flags(parser: argparse.ArgumentParser) -> None:
    """Add --motion and what goes with physics."""
    parser.add_argument(
        "--motion",
        choices=("clips", "physics", "hybrid"),
        help="blend clips, optimise a centre of mass (needs no clips), or both (default: as each agent says)",
    )
    group = parser.add_argument_group("physics and hybrid")
    group.add_argument("--gravity", metavar="M/S2", type=number, default=9.81, help="default: %(default)s")
    group.add_argument(
        "--comfort", metavar="K", type=number, help="weight of comfort against physics (default: as people walk)"
    )
    group.add_argument(
        "--solver", choices=("lm", "greedy"), default="lm", help="least squares, or the paper's (default: %(default)s)"
    )
    group.add_argument(
        "--crouch",
        metavar="X",
        type=number,
        default=0.0,
        help="part of the leg that stays bent (default: %(default)s)",
    )
    group.add_argument(
        "--hip-spacing",
        metavar="X",
        type=number,
        default=1.0,
        help="factor on the hips' spacing (default: %(default)s)",
    )
    group.add_argument(
        "--com-shift",
        metavar=("LEFT", "UP", "AHEAD"),
        type=number,
        nargs=3,
        default=(0.0, 0.0, 0.0),
        help="shift of the centre of mass in the body [m]",
    )
    group.add_argument(
        "--pitch", metavar="X", type=number, default=1.0, help="factor on the body's nodding (default: %(default)s)"
    )
    group.add_argument(
        "--sway", metavar="X", type=number, default=1.0, help="factor on its roll and turn (default: %(default)s)"
    )


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no number")
    return value


def physics_options(arguments: argparse.Namespace) -> PhysicsOptions:
    """Options of the optimisation as given."""
    from usdfoot.physics.options import PhysicsOptions

    usual = PhysicsOptions()
    comfort = usual.comfort if arguments.comfort is None else arguments.comfort
    return PhysicsOptions(solver=arguments.solver, gravity=arguments.gravity, comfort=comfort)


def body_style(arguments: argparse.Namespace) -> BodyStyle:
    """The body's style as given."""
    from usdfoot.physics.style import BodyStyle

    usual = BodyStyle()
    left, up, ahead = arguments.com_shift
    return BodyStyle(
        hip_spacing=arguments.hip_spacing,
        crouch=arguments.crouch,
        com_left=left,
        com_up=up,
        com_ahead=ahead,
        pitch=arguments.pitch * usual.pitch,
        sway=arguments.sway * usual.sway,
        turn=arguments.sway * usual.turn,
    )
