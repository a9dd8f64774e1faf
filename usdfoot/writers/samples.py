"""Samples: layers that have the time samples of many attributes before anything else is authored in them.

From Python USD takes samples one by one, which costs more than to make them, and it copies those of another layer into
the file. Here they are in the file to begin with: USD reads them only when asked, and when it saves a layer to the file
that it was opened from it leaves them where they are.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pxr import Sdf

from usdfoot.writers.crate.sampled import SAMPLE_KINDS, Samples, write_samples
from usdfoot.writers.crate.stored import read_samples
from usdfoot.writers.layers import author, author_samples, author_targets

__all__ = ["copy_unsampled", "sampled_layer", "sampled_prims", "samples_of"]

PRIM_FIELDS = ("typeName", "instanceable", "references", "apiSchemas")
"""What agents and animations say of themselves, in the order in which it is made: USD keeps it, but does not tell."""


def sampled_layer(file: Path, scope: str, prims: Mapping[str, Mapping[str, Samples]]) -> Sdf.Layer:
    """A layer in a new file with the attributes of prims, and nothing else but the prims and those above them.

    Args:
        file: Path of the file.
        scope: Path of the prim above.
        prims: Samples by the name of the attribute, by the name of the prim.

    Raises:
        OSError: If the file cannot be written.
    """
    with file.open("wb") as stream:
        write_samples(stream, scope.strip("/").split("/"), prims)
    held = Sdf.Layer.Find(str(file))  # by the traceback of a run that failed
    if held:
        held.Reload(force=True)
    return Sdf.Layer.FindOrOpen(str(file))


def sampled_prims(file: Path, prims: Sequence[Sdf.PrimSpec]) -> dict[str, dict[str, Samples]]:
    """Attributes of prims that a sampled layer can have, by the prims' names: what `samples_of` says of each, at once.

    Args:
        file: Of their layer.
        prims: Some below one prim.
    """
    try:
        found = read_samples(file, str(prims[0].path.GetParentPath())) if prims else {}
        return {prim.name: _in_order(prim, found.get(prim.name, {})) for prim in prims}
    except (ValueError, LookupError, struct.error):  # somebody wrote it with another program
        return {prim.name: samples_of(prim) for prim in prims}


def _in_order(prim: Sdf.PrimSpec, samples: Mapping[str, Samples]) -> dict[str, Samples]:
    """Samples in the order that the prim's attributes have."""
    return {attribute.name: samples[attribute.name] for attribute in prim.attributes if attribute.name in samples}


def samples_of(prim: Sdf.PrimSpec) -> dict[str, Samples]:
    """The attributes of a prim that a sampled layer can have, by name."""
    layer, found = prim.layer, {}
    for attribute in prim.attributes:
        codes = layer.ListTimeSamplesForPath(attribute.path)
        if codes and str(attribute.typeName) in SAMPLE_KINDS:
            values = [np.asarray(layer.QueryTimeSample(attribute.path, code)) for code in codes]
            found[attribute.name] = Samples(
                type_name=str(attribute.typeName), codes=np.array(codes), values=np.array(values)
            )
    return found


def copy_unsampled(source: Sdf.PrimSpec, prim: Sdf.PrimSpec) -> None:
    """Authors in a prim of a sampled layer what else there is in a prim of another layer, as if it were made there."""
    for field in PRIM_FIELDS:
        if source.HasInfo(field):
            prim.SetInfo(field, source.GetInfo(field))
    for each in source.properties:
        if isinstance(each, Sdf.RelationshipSpec):
            author_targets(prim, each.name, [str(path) for path in each.targetPathList.explicitItems])
        elif each.name not in prim.attributes:
            _copy_attribute(each, prim)


def _copy_attribute(source: Sdf.AttributeSpec, prim: Sdf.PrimSpec) -> None:
    is_uniform = source.variability == Sdf.VariabilityUniform
    codes = source.layer.ListTimeSamplesForPath(source.path)
    samples = [source.layer.QueryTimeSample(source.path, code) for code in codes]
    author_samples(author(prim, source.name, source.typeName, source.default, uniform=is_uniform), codes, samples)
