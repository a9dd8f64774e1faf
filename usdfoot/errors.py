"""The family of errors: every message says where, what is wrong, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = [
    "BipedError",
    "ClipError",
    "OutputError",
    "PlanError",
    "SceneError",
    "SkeletonError",
    "TerrainError",
    "TrackError",
    "UsdfootError",
]


class UsdfootError(ValueError):
    """Base of all usdfoot errors.

    Args:
        where: Prim path, file or argument the error is about.
        what: What is wrong, in a few words.
        remedy: What would be right. Empty if there is nothing to add.
        names: Offending names (joints, prims); at most ten are printed.
    """

    def __init__(self, where: object, what: str, remedy: str = "", names: Iterable[object] = ()) -> None:
        self.where = str(where)
        self.what = what
        self.remedy = remedy
        self.names = tuple(str(name) for name in names)
        super().__init__(self._message())

    def _message(self) -> str:
        shown = ", ".join(self.names[:10]) + (f" and {len(self.names) - 10} more" if len(self.names) > 10 else "")
        text = f"{self.where}: {self.what}" + (f": {shown}" if shown else "")
        return f"{text}. {self.remedy}" if self.remedy else text

    def __reduce__(self) -> tuple[type, tuple[str, str, str, tuple[str, ...]]]:
        return type(self), (self.where, self.what, self.remedy, self.names)


class SceneError(UsdfootError):
    """The stage cannot be opened, or lacks what the job needs."""


class SkeletonError(UsdfootError):
    """A skeleton is missing, empty or inconsistent."""


class BipedError(UsdfootError):
    """Pelvis, hips, knees, ankles or balls of a skeleton could not be found."""


class ClipError(UsdfootError):
    """A clip cannot be used."""


class PlanError(UsdfootError):
    """A footstep plan is inconsistent."""


class TerrainError(UsdfootError):
    """A terrain mesh is empty or malformed."""


class TrackError(UsdfootError):
    """A file of pedestrian tracks cannot be read, or does not say what its numbers mean."""


class OutputError(UsdfootError):
    """The output cannot be written where it was asked for."""
