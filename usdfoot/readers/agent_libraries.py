"""Agent libraries: the clips of agents on their characters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from pxr import Sdf, Usd

from usdfoot.bridge.scene import Character
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import ClipError, UsdfootError
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.hashing import content_hash
from usdfoot.model.report import Problem
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.clips import ClipSource, missing_leg_joints, read_clip

__all__ = ["AgentLibraries"]


@dataclass(kw_only=True)
class AgentLibraries:
    """Libraries of agents; characters with one body, as variants of an asset have it, share that of the same clips."""

    finder: ClipFinder
    units: StageUnits
    most_frames: int
    """Samples that a clip may have."""
    problems: list[Problem]
    """Clips that cannot be used are added to it."""
    libraries: list[ClipLibrary] = field(default_factory=list)
    _alike: dict[object, int] = field(default_factory=dict)
    _unfit: dict[str, str] = field(default_factory=dict)

    def add(self, scopes: tuple[Sdf.Path, ...], own: Character, skeleton: Usd.Prim, *, required: bool) -> int:
        """Index of the library with an agent's clips, which is read unless there is one like it.

        Args:
            scopes: Of the agent's clips; none = every clip that fits.
            own: The agent's character.
            skeleton: Its Skeleton.
            required: Whether the agent needs clips.

        Raises:
            UsdfootError: If it needs some and has none that can be used.
        """
        sources = self._sources(scopes, skeleton)
        body = content_hash(replace(own.skeleton, name=""), own.biped, own.bind_pose)
        made_on = [found.skeleton_prim.GetPath() for found in sources.values() if isinstance(found, ClipSource)]
        key = (body, scopes, required, tuple(made_on))
        if key not in self._alike:
            clips = self._clips(scopes, own, sources, required=required)
            self.libraries.append(
                ClipLibrary(skeleton=own.skeleton, biped=own.biped, clips=clips, bind_pose=own.bind_pose)
            )
            self._alike[key] = len(self.libraries) - 1
        return self._alike[key]

    def unfit_clips(self) -> tuple[Problem, ...]:
        """A warning for each clip nobody asked for that fits none of the characters."""
        used = {clip.name for library in self.libraries for clip in library.clips}
        return tuple(
            Problem(severity="warning", where=path, message=f"{path}: not used, lacks leg joints of {skeleton}")
            for path, skeleton in self._unfit.items()
            if path not in used
        )

    def _sources(self, scopes: Sequence[Sdf.Path], skeleton: Usd.Prim) -> dict[str, ClipSource | UsdfootError]:
        """Animations by path, with the skeletons they were made on, or why these are none."""
        found: dict[str, ClipSource | UsdfootError] = {}
        for animation in self.finder.animations_below(scopes):
            path = str(animation.GetPath())
            try:
                found[path] = self.finder.source_of(animation, skeleton)
            except UsdfootError as error:
                found[path] = error
        return found

    def _clips(
        self,
        scopes: Sequence[Sdf.Path],
        own: Character,
        sources: Mapping[str, ClipSource | UsdfootError],
        *,
        required: bool,
    ) -> tuple[Clip, ...]:
        """Clips of an agent's scopes that can be used. Clips nobody asked for may be of other skeletons."""
        clips: list[Clip] = []
        unfit: list[str] = []
        faults: list[UsdfootError] = []
        for path, source in sources.items():
            try:
                if isinstance(source, UsdfootError):
                    raise source
                if not scopes and missing_leg_joints(source, own.skeleton, own.biped):
                    self._unfit.setdefault(path, own.skeleton.name)
                    unfit.append(path)
                    continue
                clips.append(read_clip(source, own.skeleton, own.biped, units=self.units, most_frames=self.most_frames))
            except UsdfootError as error:
                faults.append(error)
                severity = "error" if scopes else "warning"
                self.problems.append(Problem(severity=severity, where=path, message=str(error)))
        if required and not clips:
            raise _no_clips(scopes, own, unfit, faults)
        return tuple(clips)


def _no_clips(
    scopes: Sequence[Sdf.Path], own: Character, unfit: Sequence[str], faults: Sequence[UsdfootError]
) -> ClipError:
    """The error of an agent none of whose clips can be used: of another rig, or faulty."""
    count = len(unfit) + len(faults)
    where = ", ".join(str(path) for path in scopes) or "the stage"
    if not count:
        return ClipError(where, "has no clips (SkelAnimation prims)", "add some, or point usdfoot:agent:clips at them")
    if faults:
        first = faults[0]
        what = f"none of {count} clip(s) can be used on {own.skeleton.name}; {first.where}: {first.what}"
        return ClipError(where, what, first.remedy, first.names)
    return ClipError(
        where,
        f"none of {count} clip(s) fits {own.skeleton.name}",
        "put them on it with usdfoot retarget, or name their joints as the Skeleton's leg joints",
        unfit,
    )
