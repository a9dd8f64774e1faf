"""Leave-one-out replay: each clip's footsteps, animated from all other clips, against the clip itself.

A take's footsteps are those of its range and of one stride on either side (--whole: all of them). Its own clip and
mirror image leave the library, the rest is blended onto the footsteps, and the joints are compared with the take from
the first strike to the last: in the world, and each from its own pelvis. Beside it stand two single clips placed on the
same footsteps by the same engine: the *nearest*, whose steps land most alike in place and time, and the *best*, chosen
afterwards among all because its error is the smallest. *own* is the take's own clip: what cutting, warping and planting
add by themselves.

With --motion physics the pelvis that physics puts over the same footsteps, without any clip, is compared with the
take's: distances, rise and sway, and how late it rises.

Examples:
  python tools/replay.py clips.usdc --set correction=false --json
  python tools/replay.py clips.usdc --motion physics
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
from replaying.leave_out import ReplayErrors, nearest_clips, replay_takes, with_clips
from replaying.pelvis import pelvis_json, pelvis_table, replay_pelvises
from replaying.takes import Take, read_take

from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.readers.libraries import read_libraries

MOST_UNUSABLE = 2
"""Takes of no more footsteps have no stride to compare."""
MEASURES = ("pelvis_legs", "pelvis", "world_legs", "world")


@dataclass(frozen=True, kw_only=True)
class Replay:
    """One take and what became of its footsteps."""

    clip: str
    kind: str
    """What the clip shows, from customData.kind; "" if it does not say."""
    steps: int
    blended: ReplayErrors
    """All other clips."""
    nearest: ReplayErrors | None
    """The other clip with the nearest steps; None where there is no other."""
    best: dict[str, float]
    """Smallest error of any other clip, by measure; chosen for each measure on its own."""
    own: ReplayErrors | None
    """The clip itself: what the engine adds; None where it has no usable step."""


def replay_library(
    library: ClipLibrary, options: EngineOptions, *, kinds: dict[str, str], whole: bool, only: str
) -> list[Replay]:
    """Replays of all clips of a library whose name fits the glob `only`, in the library's order."""
    prepared = prepare_library(library, options)
    takes = read_takes(library, whole=whole, only=only)
    return [
        replay
        for rate in sorted({take.rate for take in takes})
        for replay in _replay_rate(prepared, [take for take in takes if take.rate == rate], options, kinds)
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
    library: PreparedLibrary, takes: Sequence[Take], options: EngineOptions, kinds: dict[str, str]
) -> list[Replay]:
    """Replays of takes of one rate."""
    clips = np.unique(library.examples.clip_indices[:-1])
    single = {int(clip): _single_clip(library, int(clip), takes, options) for clip in clips}
    nearest = nearest_clips(library.examples, takes, len(library.source.clips))
    replays = []
    for row, take in enumerate(takes):
        others = clips[clips != take.index]
        if not others.size:
            continue
        blended = replay_takes(with_clips(library, others, style=take.style), [take], options)[0]
        candidates = [found for clip in others if (found := single[int(clip)][row]) is not None]
        replays.append(
            Replay(
                clip=take.name.rsplit("/", 1)[-1],
                kind=kinds.get(take.name, ""),
                steps=len(take.plan),
                blended=blended,
                nearest=single[int(nearest[row])][row],
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


def table(replays: Sequence[Replay]) -> str:
    """Errors in centimetres by clip, by kind and in all."""
    header = f"{'[cm]':<42} {'steps':>5} {'out':>4}"
    for title in ("from pelvis, legs", "from pelvis, all", "world, legs", "world, all"):
        header += f" | {title:^27}"
    lines = [header, " " * 53 + " |   blend nearest   best    own" * len(MEASURES)]

    def row(label: str, steps: str, outside: str, values: dict[str, FloatArray]) -> str:
        text = f"{label:<42} {steps:>5} {outside:>4}"
        for name in MEASURES:
            text += " | " + "".join(f"{100.0 * value:7.2f}" for value in values[name])
        return text

    for replay in replays:
        lines.append(row(replay.clip, str(replay.steps), str(replay.blended.outside), _values(replay)))
    groups = [(kind, [r for r in replays if r.kind == kind]) for kind in sorted({r.kind for r in replays}) if kind]
    for label, members in [*groups, ("all", list(replays))]:
        for name, middle in (("mean", np.nanmean), ("median", np.nanmedian)):
            each = [_values(member) for member in members]
            values = {key: middle([value[key] for value in each], axis=0) for key in MEASURES}
            steps = str(sum(member.steps for member in members))
            lines.append(row(f"{label} ({len(members)}), {name}", steps, "", values))
    return "\n".join(lines)


def _values(replay: Replay) -> dict[str, FloatArray]:
    """Errors of blend, nearest, best and own clip by measure [m]."""
    values = {}
    for name in MEASURES:
        nearest, own = (getattr(errors, name) if errors else np.nan for errors in (replay.nearest, replay.own))
        values[name] = np.array([getattr(replay.blended, name), nearest, replay.best[name], own])
    return values


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
    parser.add_argument("--motion", choices=("clips", "physics"), default="clips", help="what walks the footsteps")
    parser.add_argument("--json", action="store_true", help="print JSON")
    arguments = parser.parse_args(argv)
    if arguments.motion == "physics":
        return print_pelvises(arguments.library, whole=arguments.whole, only=arguments.clips, as_json=arguments.json)
    options = options_of(arguments.set)
    replays: list[Replay] = []
    for library in read_libraries(arguments.library).libraries:
        kinds = read_kinds(arguments.library, library)
        replays += replay_library(library, options, kinds=kinds, whole=arguments.whole, only=arguments.clips)
    if arguments.json:
        print(json.dumps([_as_json(replay) for replay in replays], indent=1))
    else:
        print(table(replays))
    return 0 if replays else 2


def _as_json(replay: Replay) -> dict[str, object]:
    """Errors in metres."""
    columns = ("blended", "nearest", "best", "own")
    errors = {
        name: {column: None if np.isnan(value) else float(value) for column, value in zip(columns, values, strict=True)}
        for name, values in _values(replay).items()
    }
    return {
        "clip": replay.clip,
        "kind": replay.kind,
        "steps": replay.steps,
        "outside": replay.blended.outside,
        **errors,
    }


if __name__ == "__main__":
    raise SystemExit(main())
