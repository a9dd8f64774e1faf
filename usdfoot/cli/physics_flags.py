"""Flags of bodies that physics moves: what an animator turns ([P] 3)."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from usdfoot.cli.quantities import number

if TYPE_CHECKING:
    from usdfoot.model.tuning import BodyTuning
    from usdfoot.physics.options import PhysicsOptions

__all__ = ["add_physics_flags", "body_tuning", "physics_options"]


def add_physics_flags(parser: argparse.ArgumentParser) -> None:
    """Add --motion and what goes with physics."""
    parser.add_argument(
        "--motion",
        choices=("clips", "physics", "hybrid"),
        help="blend clips, optimise a centre of mass (needs no clips), or both (default: as each agent says)",
    )
    group = parser.add_argument_group(
        "physics and hybrid", "over what the agents' attributes say, such as usdfoot:agent:crouch"
    )
    group.add_argument("--gravity", metavar="M/S2", type=number, help="default: as each agent says, else 9.81")
    group.add_argument(
        "--comfort", metavar="K", type=number, help="weight of comfort against physics (default: as people walk)"
    )
    group.add_argument(
        "--solver", choices=("lm", "greedy"), default="lm", help="least squares, or the paper's (default: %(default)s)"
    )
    group.add_argument("--crouch", metavar="X", type=number, help="part of the leg that stays bent, -0.2 to 0.6")
    group.add_argument(
        "--hip-spacing", metavar="X", type=number, help="factor on the distance of the hip joints, with any motion"
    )
    group.add_argument(
        "--com-shift",
        metavar=("LEFT", "UP", "AHEAD"),
        type=number,
        nargs=3,
        help="shift of the centre of mass in the body [m]",
    )
    group.add_argument("--pitch", metavar="X", type=number, help="factor on the body's nodding")
    group.add_argument("--sway", metavar="X", type=number, help="factor on its roll and turn")


def physics_options(arguments: argparse.Namespace) -> PhysicsOptions:
    """Options of the optimisation as given."""
    from usdfoot.physics.options import PhysicsOptions

    return PhysicsOptions(solver=arguments.solver)


def body_tuning(arguments: argparse.Namespace) -> BodyTuning:
    """The tuning of all agents as given."""
    from usdfoot.model.tuning import BodyTuning

    left, up, ahead = arguments.com_shift or (None, None, None)
    return BodyTuning(
        hip_spacing=arguments.hip_spacing,
        crouch=arguments.crouch,
        com_left=left,
        com_up=up,
        com_ahead=ahead,
        pitch=arguments.pitch,
        sway=arguments.sway,
        gravity=arguments.gravity,
        comfort=arguments.comfort,
    )
