"""A glTF 2.0 file: its nodes, and the numbers of its accessors."""

from __future__ import annotations

import base64
import binascii
import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from usdfoot.errors import ClipError
from usdfoot.importers.text_lines import LARGEST
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import Limits, check_limit

__all__ = ["GltfFile", "open_gltf"]

MALFORMED = (ValueError, KeyError, TypeError, AttributeError, IndexError, struct.error, RecursionError)
"""What loading raises for documents that are no glTF."""
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
COMPRESSION = "EXT_meshopt_compression"


@dataclass(frozen=True, kw_only=True)
class GltfFile:
    """One file; its checked parts and the document as pygltflib has it."""

    path: Path
    document: Any
    """`pygltflib.GLTF2`."""
    parents: IntArray
    """Node above each node, -1 for roots, shape (N,)."""
    names: tuple[str, ...]
    """Of the nodes."""
    buffers: dict[int, bytes] = field(default_factory=dict)
    """What has been read of them, by index."""

    def error(self, what: str, remedy: str = "") -> ClipError:
        """An error that names the file."""
        return ClipError(self.path, what, remedy)

    def item(self, kind: str, index: object) -> Any:
        """One of the document's accessors, bufferViews and so on.

        Raises:
            ClipError: If there is none with that index.
        """
        items = getattr(self.document, kind) or []
        if not isinstance(index, int) or not 0 <= index < len(items):
            raise self.error(f"refers to {kind}[{index}], it has {len(items)}", "export it again")
        return items[index]

    def numbers(self, accessor: object, where: str) -> FloatArray:
        """Values of an accessor, normalised where it says so, shape (count, components).

        Args:
            accessor: Its index.
            where: What they are, for messages.

        Raises:
            ClipError: If the accessor or what it refers to is malformed, or values are not finite.
        """
        one = self.item("accessors", accessor)
        where = f"accessors[{accessor}] ({where})"
        size = SIZES.get(one.type)
        if size is None or one.componentType not in COMPONENTS or not _is_count(one.count):
            what = f"{where} has type {one.type}, componentType {one.componentType}, count {one.count}"
            raise self.error(what, "these are none of glTF's")
        kind = np.dtype(COMPONENTS[one.componentType])
        if one.bufferView is None:
            check_limit(self.path, "frames", one.count, limit=100_000_000)
            values = np.zeros((one.count, size), dtype=kind)
        else:
            values = self._view(one.bufferView, one.byteOffset or 0, (one.count, size), kind, where)
        if one.sparse is not None:
            values = self._with_sparse(values, one.sparse, where)
        numbers = values.astype(float)
        if one.normalized and kind.kind != "f":
            numbers = np.maximum(numbers / np.iinfo(kind).max, -1.0)
        if not (np.abs(numbers) <= LARGEST).all():
            raise self.error(f"{where} has values that are not finite or too large", "export it again")
        return numbers

    def _with_sparse(self, values: np.ndarray, sparse: Any, where: str) -> np.ndarray:
        """Values with those replaced that a sparse accessor replaces."""
        if not _is_count(sparse.count) or sparse.indices.componentType not in COMPONENTS:
            raise self.error(f"{where} has a malformed sparse part", "export it again")
        kind = np.dtype(COMPONENTS[sparse.indices.componentType])
        indices = self._view(sparse.indices.bufferView, sparse.indices.byteOffset or 0, (sparse.count, 1), kind, where)
        shape = (sparse.count, values.shape[1])
        replaced = self._view(sparse.values.bufferView, sparse.values.byteOffset or 0, shape, values.dtype, where)
        if kind.kind == "f" or indices.max(initial=0) >= len(values) or indices.min(initial=0) < 0:
            raise self.error(f"{where} replaces values that it does not have", "export it again")
        result = values.copy()
        result[indices[:, 0]] = replaced
        return result

    def _view(self, index: object, offset: int, shape: tuple[int, int], kind: np.dtype, where: str) -> np.ndarray:
        """Values (count, components) in a buffer view."""
        view = self.item("bufferViews", index)
        if COMPRESSION in (view.extensions or {}):
            raise self.error(f"{where} is compressed ({COMPRESSION})", "export it without compression")
        data = self._buffer(view.buffer)
        start, length = view.byteOffset or 0, view.byteLength
        width = kind.itemsize * shape[1]
        stride = view.byteStride or width
        needed = offset + stride * (shape[0] - 1) + width
        if not _is_count(length) or start < 0 or offset < 0 or stride < width or needed > length:
            raise self.error(
                f"{where} needs {needed} bytes of bufferViews[{index}], which has {length}", "export it again"
            )
        if start + length > len(data):
            what = (
                f"bufferViews[{index}] ends at byte {start + length} of buffers[{view.buffer}], which has {len(data)}"
            )
            raise self.error(what, "the file may be cut off")
        return np.ndarray(shape, kind, data, start + offset, (stride, kind.itemsize))

    def _buffer(self, index: object) -> bytes:
        one = self.item("buffers", index)
        if index not in self.buffers:
            self.buffers[int(index)] = self._loaded(one.uri)  # type: ignore[call-overload]
        return self.buffers[index]  # type: ignore[index]

    def _loaded(self, uri: str | None) -> bytes:
        """Bytes of the binary chunk, of a data URI or of a file beside this one."""
        if uri is None:
            blob = self.document.binary_blob()
            if blob is None:
                raise self.error("has a buffer without uri or binary chunk", "export it again")
            return blob
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except binascii.Error as error:
                raise self.error("has a buffer that is no base64", "export it again") from error
        try:
            return (self.path.parent / unquote(uri)).read_bytes()
        except OSError as error:
            raise self.error(f"buffer {uri} cannot be read ({error.strerror})", "put it beside the file") from error


def open_gltf(file: str | os.PathLike[str], limits: Limits) -> GltfFile:
    """The file with its tree of nodes checked.

    Raises:
        ClipError: If it cannot be read, is no glTF 2.0, or a node hangs on two others or on itself.
        SceneError: If it has more nodes than a hundred skeletons of the limits' joints.
    """
    path = Path(file)
    pygltflib = _pygltflib()
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ClipError(path, f"cannot be read ({error.strerror})", "name a .gltf or .glb file") from error
    is_binary = data[:4] == b"glTF"
    if _is_first_version(data, is_binary):
        raise ClipError(path, "is glTF 1.0, which is another format", "convert it to glTF 2.0")
    try:
        document = pygltflib.GLTF2.load_from_bytes(data) if is_binary else pygltflib.GLTF2.gltf_from_json(data.decode())
        version, nodes = str(document.asset.version), list(document.nodes)
        links = [list(node.children or []) for node in nodes]
        names = tuple(str(node.name or f"node{index}") for index, node in enumerate(nodes))
    except MALFORMED as error:
        raise ClipError(path, f"is no glTF file ({type(error).__name__}: {error})"[:300], "export it again") from error
    if not version.startswith("2."):
        raise ClipError(path, f"is glTF {version}", "2.0 can be imported")
    check_limit(path, "joints", len(nodes), limit=100 * limits.joints)
    return GltfFile(path=path, document=document, parents=_parents(path, links), names=names)


def _is_first_version(data: bytes, is_binary: bool) -> bool:
    """Whether a file is of glTF 1.0, which pygltflib cannot load."""
    if is_binary:
        return data[4:8] == b"\x01\x00\x00\x00"
    try:
        return isinstance(json.loads(data).get("nodes"), dict)  # 2.0 has a list
    except MALFORMED:
        return False


def _parents(path: Path, links: Sequence[Sequence[object]]) -> IntArray:
    """Node above each of N nodes, of the children of each."""
    parents = np.full(len(links), -1)
    for node, children in enumerate(links):
        for child in children:
            if not isinstance(child, int) or not 0 <= child < len(links) or parents[child] >= 0 or child == node:
                raise ClipError(path, f"nodes[{node}] has child {child}, which cannot hang there", "export it again")
            parents[child] = node
    reached = np.flatnonzero(parents < 0)
    count = len(reached)
    while len(reached):
        reached = np.flatnonzero(np.isin(parents, reached))
        count += len(reached)
    if count < len(links):
        raise ClipError(path, "has nodes that hang on themselves", "export it again")
    return parents


def _is_count(value: object) -> bool:
    return isinstance(value, int) and value > 0


def _pygltflib() -> Any:
    try:
        import pygltflib
    except ImportError as error:
        raise ClipError("glTF", "pygltflib is not installed", "pip install 'usdfoot[import]'") from error
    return pygltflib
