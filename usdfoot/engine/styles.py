"""The style of each step, and how a step goes on from one in another style ([B] 7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from usdfoot.engine.corrections import CorrectedSteps, correct_steps
from usdfoot.engine.poses import Setup
from usdfoot.engine.queries import StepQueries
from usdfoot.errors import PlanError
from usdfoot.maths.types import IntArray, StyleArray
from usdfoot.model.agent import Agent
from usdfoot.model.contact_table import ContactTable
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["contact_styles", "continue_styles"]


def contact_styles(
    contacts: ContactTable, agents: Sequence[Agent], *, known: Sequence[str], default: str
) -> StyleArray:
    """Style of the step to each contact, shape (C,); those after the last footstep go on in its style.

    Args:
        contacts: Of all agents.
        agents: Their plans may name styles.
        known: Styles of the library's examples.
        default: Style of steps that name none.

    Raises:
        PlanError: If no clip of the library has a style that a plan names.
    """
    styles = []
    for agent in agents:
        own = np.array([style or default for style in agent.plan.styles or [""] * len(agent.plan)], dtype=object)
        unknown = [_named(style, np.flatnonzero(own == style)) for style in sorted(set(own) - set(known))]
        if unknown:
            remedy = f"the styles of its clips are {', '.join(sorted(set(known)))}"
            raise PlanError(agent.plan.name, "names styles that no clip has", remedy, unknown)
        styles.append(own)
    firsts = np.concatenate([[0], np.cumsum([len(own) for own in styles])])
    lengths = np.diff(firsts)[contacts.agents]
    begins = np.arange(len(contacts.agents)) == contacts.first[contacts.agents]
    footsteps = np.where(contacts.steps >= 0, contacts.steps, np.where(begins, 0, lengths - 1))
    return np.concatenate(styles)[firsts[contacts.agents] + footsteps]


def _named(style: str, steps: IntArray) -> str:
    """A style with the first of the footsteps (N,) that have it, and how many more there are."""
    more = f" and {len(steps) - 1} more" if len(steps) > 1 else ""
    return f"{style!r} of footstep {steps[0]}{more}"


def continue_styles(
    setup: Setup, spaces: FootstepSpaces, steps: IntArray, *, queries: StepQueries, corrected: CorrectedSteps
) -> CorrectedSteps:
    """The steps, those that change the style solved again for examples that begin in the pose and pace they come from.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        steps: Segments, in order of agents and time, shape (N,).
        queries: Of these segments.
        corrected: Their blends, whatever came before.
    """
    if spaces.poses is None or len(steps) < 2:
        return corrected
    supports = setup.segments.supports[steps]
    follows = (np.diff(supports) == 1) & ~setup.segments.stands[steps[1:] - 1]
    changed = 1 + np.flatnonzero(follows & (queries.styles[1:] != queries.styles[:-1]))
    if not changed.size:
        return corrected
    before = changed - 1
    ends = spaces.poses.ends[corrected.examples[before]]
    entries = np.einsum("nk,nkp->np", corrected.weights[before], ends)
    again = correct_steps(setup, spaces, queries[changed], corrections=setup.options.corrections, entries=entries)
    merged = {field.name: getattr(corrected, field.name).copy() for field in fields(corrected)}
    for name, values in merged.items():
        values[changed] = getattr(again, name)
    return replace(corrected, **merged)
