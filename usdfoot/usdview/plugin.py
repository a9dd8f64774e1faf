"""The container that usdview finds through plugInfo.json: puts the menu Usdfoot together and nothing else."""

from __future__ import annotations

from typing import Any

from pxr import Tf
from pxr.Usdviewq.plugin import PluginContainer

__all__ = ["MENU", "UsdfootContainer"]

MENU = (
    (
        "Show or Hide",
        (
            ("toggle_footsteps", "Footsteps", "Prints in the colour of their status"),
            ("toggle_errors", "Errors", "Columns as high as blend and placement errors"),
            ("toggle_contacts", "Contacts", "The feet that stand, over time"),
            ("toggle_com", "Centre of Mass", "Its curve: red right, magenta left, blue both, pale blue flight"),
            ("toggle_space", "Footstep Space", "Triangulation at the current step with the blend weights"),
            ("toggle_timing", "Timing", "How long each foot stands, and when the next one comes down"),
            ("remove_all", "Remove All", "Take the overlays out of the session layer"),
            ("save", "Save Overlay...", "Write what is drawn as a layer"),
        ),
    ),
    (
        "Animate Again",
        (
            ("change_root_weight", "Root Weight...", "The selected agents with another root weight"),
            ("change_seam", "Seam...", "The selected agents with another way from step to step"),
            ("keep", "Keep Take", "Make the crowd again as the take shown last is, and drop the takes"),
            ("drop", "Drop Takes", "Show the crowd as it was and remove the takes"),
        ),
    ),
    (
        "Footstep",
        (
            ("move", "Move...", "Move the selected footstep and animate again"),
            ("move_to_point", "Move to Picked Point", "Move the selected footstep to where was clicked last"),
            ("add", "Add After", "Add a footstep after the selected one and animate again"),
            ("delete", "Delete", "Delete the selected footstep and animate again"),
        ),
    ),
    (
        "",
        (
            ("plan_along", "Plan Along Selected Curve", "Footsteps along the curve, at the edit target"),
            ("jump_to_worst", "Jump to Worst Step", "The step of the selected agents that is missed by most"),
        ),
    ),
)
"""Submenus, the menu's own items last: name in `usdfoot.usdview.actions`, label and description of each."""


class UsdfootContainer(PluginContainer):
    """Registers the commands; the modules behind them are imported when the first one is used."""

    def registerPlugins(self, plugRegistry: Any, usdviewApi: Any) -> None:
        """Register all commands of the menu.

        Args:
            plugRegistry: Of usdview.
            usdviewApi: Of usdview.
        """
        actions = self.deferredImport("usdfoot.usdview.actions")
        self._commands = {
            name: plugRegistry.registerCommandPlugin(
                f"UsdfootContainer.{name}", label, getattr(actions, name), description
            )
            for _, items in MENU
            for name, label, description in items
        }

    def configureView(self, plugRegistry: Any, plugUIBuilder: Any) -> None:
        """Build the menu.

        Args:
            plugRegistry: Of usdview.
            plugUIBuilder: Of usdview.
        """
        menu = plugUIBuilder.findOrCreateMenu("Usdfoot")
        for title, items in MENU:
            place = menu.findOrCreateSubmenu(title) if title else menu
            for name, _, _ in items:
                place.addItem(self._commands[name])


Tf.Type.Define(UsdfootContainer)
