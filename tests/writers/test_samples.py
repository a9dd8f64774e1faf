"""Samples given to USD in a file against samples set one by one."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from usdfoot.writers.crate import Samples
from usdfoot.writers.samples import sampled_attributes

FRAMES = np.array([-3.0, 0.0, 0.125, 1.0, 1e6])
VALUES = {
    "double": (Sdf.ValueTypeNames.Double, (), float),
    "double3": (Sdf.ValueTypeNames.Double3, (3,), lambda row: Gf.Vec3d(*row.tolist())),
    "float[]": (Sdf.ValueTypeNames.FloatArray, (3,), Vt.FloatArray.FromNumpy),
    "float3[]": (Sdf.ValueTypeNames.Float3Array, (2, 3), Vt.Vec3fArray.FromNumpy),
    "quatf[]": (Sdf.ValueTypeNames.QuatfArray, (300, 4), Vt.QuatfArray.FromNumpy),
}


def values_of(type_name: str, seed: int) -> np.ndarray:
    shape = VALUES[type_name][1]
    drawn = np.random.default_rng(seed).normal(size=(len(FRAMES), *shape))
    return drawn.astype(np.float32 if type_name.endswith("[]") else float)


@pytest.mark.parametrize("agents", [0, 1, 2, 70])
def test_layers_are_the_same_as_with_samples_set_one_by_one(tmp_path: Path, agents: int) -> None:
    samples = [
        {name: Samples(type_name=name, codes=FRAMES, values=values_of(name, number)) for name in VALUES}
        for number in range(agents)
    ]
    named = {name: f"a:{name.removesuffix('[]')}{len(name)}" for name in VALUES}
    given, expected = (Sdf.Layer.CreateAnonymous(".usdc") for _ in range(2))
    by_attribute = [{named[name]: value for name, value in agent.items()} for agent in samples]
    for number, sampled in enumerate(sampled_attributes(by_attribute, tmp_path / "samples.usdc")):
        prim = Sdf.CreatePrimInLayer(given, f"/Crowd/Agent_{number}")
        for name in named.values():
            sampled.author(prim, name)
    for number, agent in enumerate(samples):
        prim = Sdf.CreatePrimInLayer(expected, f"/Crowd/Agent_{number}")
        for name, (kind, _, convert) in VALUES.items():
            spec = Sdf.AttributeSpec(prim, named[name], kind)
            for code, value in zip(FRAMES.tolist(), agent[name].values, strict=True):
                expected.SetTimeSample(spec.path, code, convert(value))
    assert given.ExportToString() == expected.ExportToString()
