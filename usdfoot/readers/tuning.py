"""Tuning authored on agent prims: hips, crouch, centre of mass, sway, gravity, comfort."""

from __future__ import annotations

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.tuning import BodyTuning
from usdfoot.readers.agents import AgentSource, said_of

__all__ = ["TUNINGS", "UNTUNED", "read_tuning"]

UNTUNED = BodyTuning()
"""Of whom nothing is said."""

_TOKENS = {
    "hip_spacing": Token.HIP_SPACING,
    "crouch": Token.CROUCH,
    "com_left": Token.COM_SHIFT,
    "com_up": Token.COM_SHIFT,
    "com_ahead": Token.COM_SHIFT,
    "pitch": Token.PITCH,
    "sway": Token.SWAY,
    "gravity": Token.GRAVITY,
    "comfort": Token.COMFORT,
}
TUNINGS = frozenset(_TOKENS.values())
"""Attributes that tune a body."""
_COM_AXES = ("com_left", "com_up", "com_ahead")


def read_tuning(source: AgentSource, units: StageUnits) -> BodyTuning:
    """What is said of an agent on its prim, and over it, lengths in metres.

    Raises:
        SceneError: If a value is out of its range.
    """
    said = said_of(source, TUNINGS)
    if not said:
        return UNTUNED
    values = {name: said.get(token) for name, token in _TOKENS.items() if name not in _COM_AXES}
    shift, gravity = said.get(Token.COM_SHIFT), values["gravity"]
    if shift is not None:
        values.update({name: value * units.meters_per_unit for name, value in zip(_COM_AXES, shift, strict=True)})
    if gravity is not None:
        values["gravity"] = gravity * units.meters_per_unit
    try:
        return BodyTuning(**values)
    except UsdfootError as error:
        raise SceneError(source.prim.GetPath(), f"{_TOKENS[error.where]} {error.what}", error.remedy) from error
