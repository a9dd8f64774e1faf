"""Leave-one-out replay: each clip's footsteps, animated from all other clips, against the clip itself.

A take's footsteps are those of its range and of one stride on either side (--whole: all of them). Its own clip and
mirror image leave the library, the rest is blended onto the footsteps, and the joints are compared with the take from
the first strike to the last: in the world, and each from its own pelvis. Beside it stand two single clips placed on the
same footsteps by the same engine: the *nearest*, whose steps land most alike in place and time, and the *best*, chosen
afterwards among all because its error is the smallest. *own* is the take's own clip: what cutting, warping and planting
add by themselves.

With --fill a column says what the same clips make of the footsteps when the holes they leave are filled with steps of
physics (`usdfoot analyze --fill`). --without kind leaves out all clips that show the same kind of movement.

With --motion hybrid the pelvis of what is blended from all others is on the optimised centre of mass. The columns
*world, pelvis* are root mean squares, to be held against those of --motion physics.

With --motion physics the pelvis that physics puts over the same footsteps is compared with the take's: distances, rise
and sway, and how late it rises. How the person carries the pelvis in walks is measured of all other takes; *average* is
the distance without any clip.

Examples:
  python tools/replay.py clips.usdc --set correction=false --json
  python tools/replay.py clips.usdc --motion physics
  python tools/replay.py clips.usdc --motion hybrid
  python tools/replay.py clips.usdc --fill --without kind
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase

import numpy as np
from pxr import Usd
from replaying.filling import with_fill
from replaying.leave_out import ReplayErrors, nearest_clips, replay_takes, with_clips
from replaying.outcomes import MEASURES, Replay, replay_json, replay_table
from replaying.pelvis import pelvis_json, pelvis_table, replay_pelvises
from replaying.takes import Take, read_take

from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.clip import ClipLibrary
from usdfoot.readers.libraries import read_libraries
from usdfoot.spaces.holes import HoleOptions

MOST_UNUSABLE = 2
"""Takes of no more footsteps have no stride to compare."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What is left out and put in."""

    options: EngineOptions
    whole: bool = False
    """Replay all footsteps of the takes, not only those about their range."""
    only: str = "*"
    """Glob for the names of the clips to replay."""
    gap: float | None = None
    """Gap of the holes to be filled [m]; None = fill none."""
    kind_apart: bool = False
    """Leave out all clips of a take's kind, not only its own."""
    hybrid: bool = False
    """Blend with the pelvis on the optimised centre of mass; single clips keep theirs."""


def replay_library(library: ClipLibrary, setting: Setting, *, kinds: dict[str, str]) -> list[Replay]:
    """Replays of the clips of a library that the setting names, in the library's order."""
    prepared = prepare_library(library, setting.options)
    takes = read_takes(library, whole=setting.whole, only=setting.only)
    return [
        replay
        for rate in sorted({take.rate for take in takes})
        for replay in _replay_rate(prepared, [take for take in takes if take.rate == rate], setting, kinds)
    ]


def read_takes(library: ClipLibrary, *, whole: bool, only: str) -> list[Take]:
    """The takes of a library whose name fits the glob `only` and whose footsteps can be found."""
    takes: list[Take] = []
    for index, clip in enumerate(library.clips):
        if fnmatchcase(clip.name, f"*{only}"):
            try:
                takes.append(read_take(library, index, whole=whole))
            except UsdfootError as error:
                print(f"left out: {error}", file=sys.stderr)
    return takes


def print_pelvises(library_file: str, *, whole: bool, only: str, as_json: bool) -> int:
    """Prints how far physics is from the pelvises of all takes; the exit code."""
    names: list[str] = []
    kinds: list[str] = []
    errors = []
    for library in read_libraries(library_file).libraries:
        found = read_kinds(library_file, library)
        takes = [take for take in read_takes(library, whole=whole, only=only) if len(take.plan) > MOST_UNUSABLE]
        errors += replay_pelvises(library, takes)
        names += [take.name.rsplit("/", 1)[-1] for take in takes]
        kinds += [found.get(take.name, "") for take in takes]
    if as_json:
        rows = [
            {"clip": name, "kind": kind, **pelvis_json(each)}
            for name, kind, each in zip(names, kinds, errors, strict=True)
        ]
        print(json.dumps(rows, indent=1))
    elif errors:
        print(pelvis_table(names, kinds, errors))
    return 0 if errors else 2


def _replay_rate(
    library: PreparedLibrary, takes: Sequence[Take], setting: Setting, kinds: dict[str, str]
) -> list[Replay]:
    """Replays of takes of one rate."""
    clips, options = np.unique(library.examples.clip_indices[:-1]), setting.options
    single = {int(clip): _single_clip(library, int(clip), takes, options) for clip in clips}
    names = [clip.name for clip in library.source.clips]
    replays = []
    for row, take in enumerate(takes):
        kind = kinds.get(take.name, "")
        own = [index == take.index or (setting.kind_apart and kinds.get(names[index]) == kind) for index in clips]
        others = clips[~np.array(own)]
        if not others.size:
            continue
        left = with_clips(library, others, style=take.style)
        filled = None if setting.gap is None else with_fill(left, gap=setting.gap)
        nearest = int(nearest_clips(left.examples, [take], len(names))[0])
        candidates = [found for clip in others if (found := single[int(clip)][row]) is not None]
        replays.append(
            Replay(
                clip=take.name.rsplit("/", 1)[-1],
                kind=kind,
                steps=len(take.plan),
                blended=replay_takes(left, [take], options, hybrid=setting.hybrid)[0],
                filled=None if filled is None else replay_takes(filled, [take], options, hybrid=setting.hybrid)[0],
                nearest=single[nearest][row],
                best={name: min(getattr(errors, name) for errors in candidates) for name in MEASURES},
                own=single[take.index][row] if take.index in single else None,
            )
        )
    return replays


def _single_clip(
    library: PreparedLibrary, clip: int, takes: Sequence[Take], options: EngineOptions
) -> list[ReplayErrors | None]:
    """Errors of all takes from one clip alone; None where it cannot make them."""
    alone = with_clips(library, np.array([clip]), style="")
    try:
        return list(replay_takes(alone, takes, options))
    except UsdfootError as error:
        print(f"{library.source.clips[clip].name} alone: {error}", file=sys.stderr)
        return [None] * len(takes)


def options_of(settings: Sequence[str]) -> EngineOptions:
    """Options with `name=value` settings put in.

    Raises:
        UsdfootError: If an option is not known or its value does not fit.
    """
    defaults = asdict(EngineOptions())
    values: dict[str, object] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        if name not in defaults:
            raise UsdfootError(name, "is no option of the engine", "use one of these", sorted(defaults))
        kind = type(defaults[name])
        values[name] = text.lower() in ("1", "true", "yes", "on") if kind is bool else kind(text)
    return EngineOptions(**values)  # type: ignore[arg-type]


def read_kinds(clips_file: str, library: ClipLibrary) -> dict[str, str]:
    """customData.kind of the clips of a library."""
    stage = Usd.Stage.Open(clips_file)
    return {clip.name: str(stage.GetPrimAtPath(clip.name).GetCustomDataByKey("kind") or "") for clip in library.clips}


def main(argv: list[str] | None = None) -> int:
    """Parse the command line, replay, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("library", help="USD file with clips and the skeleton they were made on")
    parser.add_argument(
        "--clips", default="*", metavar="GLOB", help="replay only these; all others stay in the library"
    )
    parser.add_argument("--whole", action="store_true", help="all footsteps of each take")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="an option of the engine")
    parser.add_argument(
        "--motion", choices=("clips", "hybrid", "physics"), default="clips", help="what walks the plans"
    )
    parser.add_argument("--fill", action="store_true", help="also with steps of physics for the holes that are left")
    parser.add_argument("--fill-gap", type=float, default=HoleOptions().gap, metavar="METRES", help="size of a hole")
    parser.add_argument("--without", choices=("clip", "kind"), default="clip", help="what is left out of the library")
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args(argv)
    if arguments.motion == "physics":
        return print_pelvises(arguments.library, whole=arguments.whole, only=arguments.clips, as_json=arguments.json)
    setting = Setting(
        options=options_of(arguments.set),
        whole=arguments.whole,
        only=arguments.clips,
        gap=arguments.fill_gap if arguments.fill else None,
        kind_apart=arguments.without == "kind",
        hybrid=arguments.motion == "hybrid",
    )
    replays: list[Replay] = []
    for library in read_libraries(arguments.library).libraries:
        replays += replay_library(library, setting, kinds=read_kinds(arguments.library, library))
    if arguments.json:
        print(json.dumps([replay_json(replay) for replay in replays], indent=1))
    else:
        print(replay_table(replays))
    return 0 if replays else 2


if __name__ == "__main__":
    raise SystemExit(main())
