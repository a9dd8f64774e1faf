"""Preparing: changed footsteps of many agents become prepared steps, each part of a step once it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.planting import prepare_planting
from usdfoot.engine.poses import Setup, device_segments, no_seams, place_segments
from usdfoot.engine.reaching import reach_footsteps
from usdfoot.engine.root import lay_root
from usdfoot.engine.seams import measure_seams
from usdfoot.engine.slopes import ankle_sinks
from usdfoot.engine.weights import align_events
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import lay_on_ground
from usdfoot.model.ground import Ground
from usdfoot.realtime.rows import Rows
from usdfoot.realtime.tables import Stretch
from usdfoot.realtime.windows import Windows

__all__ = ["prepare_stretch"]


def prepare_stretch(
    stretch: Stretch,
    windows: Windows,
    rows: Rows,
    *,
    library: PreparedLibrary,
    ground: Ground,
    reach: float,
    options: EngineOptions,
) -> None:
    """Weighs the changed steps of a stretch, measures their seams, plants their feet; all of it goes into the rows.

    Args:
        stretch: Contacts to prepare.
        windows: Take the places where footsteps out of reach are put instead.
        rows: Take what is prepared.
        library: Prepared.
        ground: The terrain.
        reach: Largest distance from blended landing to footstep [m].
        options: Of the engine.
    """
    stretch = _weighed(stretch, library, ground, reach, options)
    setup, segments = stretch.setup, stretch.setup.segments
    windows.positions[stretch.places] = setup.contacts.positions
    rows.put_blends(stretch)
    remade = np.flatnonzero(stretch.changed & segments.joined[:-1])
    arrays = device_segments(setup, stretch.blend)
    if options.seam == "none":
        seams = no_seams(len(segments), len(setup.skeleton.joints))
    else:
        seams = measure_seams(setup, arrays, seams=remade)
    source = rows.put_segments(stretch, place_segments(setup, arrays), seams, remade=remade)
    known = rows.known(stretch, source)
    rows.put_feet(stretch, prepare_planting(setup, source, ground, known=known, due=stretch.due))


def _weighed(
    stretch: Stretch, library: PreparedLibrary, ground: Ground, reach: float, options: EngineOptions
) -> Stretch:
    """The stretch with its changed steps weighed and their footsteps where they are reached, on the ground."""
    setup, blend = stretch.setup, stretch.blend
    planned = setup.contacts.positions
    wanted = stretch.changed & ~setup.segments.stands
    if wanted.any():
        reaches = np.full(len(stretch.agents), reach)
        setup, blend, _ = reach_footsteps(setup, library.spaces, wanted, blend=blend, reach=reaches)
    setup = align_events(setup, blend)
    changed = stretch.numbers >= stretch.dirty[setup.contacts.agents]
    setup = _on_ground(setup, ground, np.flatnonzero(changed), planned, options)
    return replace(stretch, setup=setup, blend=blend)


def _on_ground(setup: Setup, ground: Ground, rows: IntArray, planned: FloatArray, options: EngineOptions) -> Setup:
    """The setup with its contacts `rows` on the ground and the root path laid anew."""
    contacts = setup.contacts
    if ground.has_terrain:
        positions = contacts.positions.copy()
        laid = lay_on_ground(contacts[rows], ground, planned=planned[rows], foot_lengths=setup.rig.foot_lengths)
        positions[rows] = laid.positions
        contacts = replace(contacts, positions=positions)
    share, sinks = options.step_height_share, ankle_sinks(setup.rig, contacts, ground)
    path = lay_root(contacts, setup.segments, step_height_share=share, sinks=sinks)
    return replace(setup, contacts=contacts, path=path)
