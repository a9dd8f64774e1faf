"""Times of footstep plans in a layer over the stage whose prints they are."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pxr import Sdf

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import StageInfo
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.layers import apply_schemas
from usdfoot.writers.layers_over import author_times, layer_over
from usdfoot.writers.staging import staged_files

__all__ = ["write_plan_times"]


def write_plan_times(
    output: str | os.PathLike[str], plans: Mapping[str, FootstepPlan], *, info: StageInfo, default_prim: str
) -> Path:
    """Write a layer that sublayers a stage and authors strike and liftoff times over its plans.

    Args:
        output: File to write.
        plans: By prim path.
        info: Of the stage.
        default_prim: Its default prim.

    Returns:
        The file written.

    Raises:
        OutputError: If the file is one of the stage's layers or cannot be written.
    """
    target, layer = layer_over(output, info, default_prim=default_prim)
    codes = info.units.times_to_codes(np.array([(plan.start, plan.end) for plan in plans.values()]))
    layer.startTimeCode = min(info.start_code, float(codes.min()))
    layer.endTimeCode = max(info.end_code, float(codes.max()))
    for path, plan in plans.items():
        with Sdf.ChangeBlock():
            prim = Sdf.CreatePrimInLayer(layer, path)
            apply_schemas(prim, [tokens.Schema.PLAN])
            author_times(prim, tokens.Plan.STRIKE_TIMES, plan.strike_times, units=info.units)
            author_times(prim, tokens.Plan.LIFTOFF_TIMES, plan.liftoff_times, units=info.units)
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target
