"""Time warps: planned durations of steps against those of their clips ([B] 5, with the total time put right).

T = sum lambda_i t(A_i) + lambda4 sum w_j t(A_j): the clips of the root have their share lambda4 of the time as of the
pose. A footstep's times are the plan's and are always kept. So what is clamped is what the plan leaves open: a step
that takes longer than the range allows is begun late, the body standing on both feet until the plan lifts one; what the
swing itself is hurried or drawn out beyond the range is reported.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.engine.options import EngineOptions
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.agent import Agent
from usdfoot.model.examples import Examples
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem

__all__ = ["blended_durations", "extreme_warps", "longest_step"]


def blended_durations(examples: Examples, chosen: IntArray, weights: FloatArray) -> FloatArray:
    """T of blends of the `chosen` examples (M, K), those of the root among them, with all their weights (M, K) [s]."""
    return np.asarray(np.sum(weights * examples.durations[chosen], axis=1))


def longest_step(examples: Examples, options: EngineOptions) -> float:
    """Duration beyond which a step is drawn out more than the range allows, whatever clips it has [s].

    Args:
        examples: Steps, and a stand as the last.
        options: Have the range.
    """
    return options.most_time_warp * float(np.max(examples.durations[:-1]))


def extreme_warps(agents: Sequence[Agent], motions: Sequence[Motion], options: EngineOptions) -> list[Problem]:
    """A warning for every agent with steps warped beyond the range: which, how much, and what would be right."""
    least, most = options.least_time_warp, options.most_time_warp
    sources = {agent.name: agent for agent in agents}
    problems = []
    for motion in motions:
        agent, warps = sources[motion.name], motion.results.time_warp
        beyond = np.flatnonzero((warps < least) | (warps > most))
        if not beyond.size:
            continue
        worst = int(beyond[np.argmax(np.abs(np.log(warps[beyond])))])
        taken = float(agent.plan.strike_times[worst] - agent.plan.strike_times[worst - 1])
        message = (
            f"{agent.plan.name}: {len(beyond)} step(s) are taken far from the pace of the clips, first to footstep "
            f"{beyond[0]}; that to footstep {worst} in {warps[worst]:.2g} times the time ({taken:.3g} s). give it "
            f"{least / warps[worst] * taken:.2g} to {most / warps[worst] * taken:.2g} s, or add clips of this pace"
        )
        problems.append(Problem(severity="warning", where=agent.source, message=message))
    return problems
