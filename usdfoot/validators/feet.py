"""Check of written agents: planted feet stand on their footsteps."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Usd

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import SIDES, Agent, Schema, Status
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.pipeline.measures import measure_placement
from usdfoot.readers.authored import targets
from usdfoot.readers.stage import read_stage_info
from usdfoot.readers.written import read_agent_prim
from usdfoot.validators.animations import animation_of, check_complete, check_contacts, check_joints
from usdfoot.validators.findings import finding
from usdfoot.validators.plans import check_plan

__all__ = ["check_feet"]

FARTHEST = 0.003
"""Mean horizontal distance of a planted ball to its footstep that is let pass [m]: the target of the worst footstep."""
MOMENTS = (0.3, 0.45, 0.6, 0.75, 0.9)
"""Parts of a contact's time near which its samples are looked at: a check for every stage must be quick."""


def check_feet(prim: Usd.Prim, time_range: Any) -> list[Any]:
    """The ball must be on its footstep while it is planted, wherever the plan's status promises so.

    Agents without an executed plan promise nothing: its layer may be deleted.
    """
    if not has_api(prim, Schema.AGENT):
        return []
    plans = [prim.GetStage().GetPrimAtPath(path) for path in targets(prim, Agent.PLAN)]
    if not plans or not plans[0] or not has_api(plans[0], Schema.RESULT):
        return []
    if _is_reported(prim, plans[0], time_range):
        return []
    units = read_stage_info(prim.GetStage()).units
    try:
        agent = read_agent_prim(prim, units)
    except UsdfootError as error:
        return [finding("AgentUnreadable", prim, str(error))]
    inside = [time_range.GetInterval().Contains(code) for code in agent.frame_codes.tolist()]
    errors = measure_placement(agent, units, _moments(agent.plan, agent.frame_codes[inside], units))
    promised = np.array([status in Status.PLACED for status in agent.status or (Status.OK,) * len(agent.plan)])
    missed = np.flatnonzero(promised & (errors > FARTHEST))
    if not missed.size:
        return []
    worst = missed[np.argmax(errors[missed])]
    what = (
        f"{missed.size} of {len(agent.plan)} footsteps are missed; footstep {worst} "
        f"({SIDES[agent.plan.sides[worst]]}) of {agent.plan.name} "
        f"by {errors[worst] / units.meters_per_unit:.3g} units, {1e3 * errors[worst]:.1f} mm"
    )
    remedy = f"at most {1e3 * FARTHEST:g} mm where the status is {' or '.join(Status.PLACED)}: animate the agent again"
    return [finding("FootOffFootstep", prim, what, remedy=remedy)]


def _moments(plan: FootstepPlan, codes: FloatArray, units: StageUnits) -> FloatArray:
    """The samples nearest to some moments of each contact, of all samples (F,)."""
    if not len(codes):
        return codes
    durations = plan.liftoff_times - plan.strike_times
    wanted = units.times_to_codes(plan.strike_times[:, None] + durations[:, None] * np.array(MOMENTS)).ravel()
    after = np.clip(np.searchsorted(codes, wanted), 1, len(codes) - 1) if len(codes) > 1 else np.zeros(1, dtype=int)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(codes[before] - wanted) <= np.abs(codes[after] - wanted), before, after)
    return codes[np.unique(nearest)]


def _is_reported(prim: Usd.Prim, plan: Usd.Prim, time_range: Any) -> bool:
    """Whether the other checks find what makes feet miss by itself: a broken animation, contacts or plan."""
    bound = animation_of(prim)
    checks = (check_complete, check_joints, check_contacts)
    return bool(
        check_plan(plan, time_range)
        or check_joints(prim, time_range)
        or (bound is not None and any(check(bound[1], time_range) for check in checks))
    )
