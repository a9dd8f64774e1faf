"""Joined: a binary layer with what the layers of several chunks have, put together as they come."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from pxr import Sdf, Tf

from usdfoot.bridge.tokens import File
from usdfoot.errors import OutputError
from usdfoot.writers.crate.join import CrateError, JoinedLayer
from usdfoot.writers.staging import StagedFiles

__all__ = ["JoinedFile"]

_logger = logging.getLogger(__name__)


class JoinedFile:
    """A staged file with what files of others have below a scope; it waits where these do.

    Args:
        files: Among which it is.
        name: In their folder.
        layer: As it begins; the scope is empty.
        scope: Path of a prim.

    Raises:
        OutputError: If it cannot be written, also by the methods; OSError likewise.
    """

    def __init__(self, files: StagedFiles, name: str, layer: Sdf.Layer, *, scope: str) -> None:
        self._files, self._name, self._layer, self._scope = files, name, layer, scope
        self._parts: list[Path] = []
        files.add_layer(name, layer, within=File.PENDING)
        self._joined: JoinedLayer | None = JoinedLayer(files.place_of(name), scope=scope)

    def add(self, part: Path) -> None:
        """Adds a part, which stays where it is until all are there."""
        self._parts.append(part)
        try:
            if self._joined:
                self._joined.add(part)
        except CrateError as error:
            _logger.info("%s: %s; USD copies it, which takes longer", self._name, error)
            self._joined = None

    def finish(self) -> None:
        """Has the file be complete."""
        if self._joined:
            self._joined.finish()
        else:
            copied = _copied(self._layer, self._parts, self._scope)
            self._files.save(self._name, partial(copied.Export, str(self._files.place_of(self._name))))
        self._files.hash_now(self._name)


def _copied(layer: Sdf.Layer, parts: Iterable[Path], scope: str) -> Sdf.Layer:
    """The layer with what others have below the scope."""
    for part in parts:
        try:
            source = Sdf.Layer.OpenAsAnonymous(str(part))
        except Tf.ErrorException as error:
            raise OutputError(part, "cannot be read", "remove it and run again") from error
        for child in source.GetPrimAtPath(scope).nameChildren:
            Sdf.CopySpec(source, child.path, layer, child.path)
    return layer
