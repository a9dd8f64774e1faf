"""Samples: the time samples of many attributes given to USD at once.

From Python USD takes samples one by one, which costs more than to make them. It reads them all from a file, and
`Sdf.CopySpec` takes an attribute from there: file and copies take 0.2 to 0.4 of the time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from pxr import Sdf

from usdfoot.writers.crate import SAMPLES_PRIM, Samples, attribute_name, write_samples

__all__ = ["SampledAttributes", "sampled_attributes"]


@dataclass(frozen=True, kw_only=True)
class SampledAttributes:
    """Attributes of an agent, with their samples, to be authored."""

    layer: Sdf.Layer
    """Has them."""
    paths: Mapping[str, Sdf.Path]
    """Where, by name."""

    def author(self, prim: Sdf.PrimSpec, name: str) -> None:
        """Author one of the attributes, which the prim does not have yet."""
        Sdf.CopySpec(self.layer, self.paths[name], prim.layer, prim.path.AppendProperty(name))


def sampled_attributes(agents: Sequence[Mapping[str, Samples]], file: Path) -> list[SampledAttributes]:
    """The attributes of agents, as long as a file that is written for them is there.

    Args:
        agents: Samples of each agent, by the name of the attribute.
        file: Path of the file.

    Raises:
        OSError: If it cannot be written.
    """
    with file.open("wb") as stream:
        write_samples(stream, [samples for agent in agents for samples in agent.values()])
    layer = Sdf.Layer.OpenAsAnonymous(str(file))
    prim, index = Sdf.Path.absoluteRootPath.AppendChild(SAMPLES_PRIM), count()
    return [
        SampledAttributes(layer=layer, paths={name: prim.AppendProperty(attribute_name(next(index))) for name in agent})
        for agent in agents
    ]
