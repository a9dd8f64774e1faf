"""Own attributes: what a scene says of an agent's prim that only describes it or is inherited, as colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["BINDING", "NUMBER_TYPES", "TEXT_TYPES", "OwnAttribute", "OwnAttributes", "OwnBinding"]

NUMBER_TYPES = {
    "bool": ("|u1", 1),
    "int": ("<i4", 1),
    "int64_t": ("<i8", 1),
    "float": ("<f4", 1),
    "double": ("<f8", 1),
    **{f"GfVec{width}f": ("<f4", width) for width in (2, 3, 4)},
    **{f"GfVec{width}d": ("<f8", width) for width in (2, 3, 4)},
}
"""Type of the components and how many there are, by the type that USD has in C++ for one value."""
TEXT_TYPES = ("std::string", "TfToken")
"""Types of texts in C++."""


@dataclass(frozen=True, kw_only=True)
class OwnAttribute:
    """An attribute as it is to be on the written agent.

    Values are texts, tuples of tokens, or arrays of numbers: shape (C,), of an array's type (n, C).
    """

    type_name: str
    """USD's."""
    value: Any = None
    """At no time; None = there is none."""
    codes: tuple[float, ...] = ()
    """Time codes of samples, S of them."""
    samples: tuple[Any, ...] = ()
    """Values at these."""
    is_custom: bool = False
    is_uniform: bool = False
    interpolation: str = ""
    """Of primvars; empty = not said."""
    element_size: int | None = None
    """Values an element; None = not said."""


BINDING = "material:binding"
"""Relationship to a material, and how those begin that are for one purpose."""


@dataclass(frozen=True, kw_only=True)
class OwnBinding:
    """A material that is bound to an agent's prim, for all below it."""

    material: str
    """Path of it: from the agent's prim, or in the written crowd if it is no part of the character."""
    source: tuple[str, str] | None = None
    """Layer and prim path of one that is no part of the character."""
    strength: str = ""
    """USD's, if it is authored: whether it goes over bindings below."""


OwnAttributes = Mapping[str, OwnAttribute | OwnBinding]
"""By name."""
