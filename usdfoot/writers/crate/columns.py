"""Columns of USD's binary format: compressed integers and bytes, both ways.

Columns are differences of two bits each that say how wide they are, and then a block of LZ4. A block without any match
is LZ4 too, which is what is written.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

__all__ = ["pack_bytes", "pack_column", "unpack_bytes", "unpack_column"]

_MORE = 15
"""What of four bits says that the length goes on in the next byte."""
_SHORTEST = 4
"""Bytes of the shortest match."""


def pack_column(integers: Sequence[int] | np.ndarray) -> bytes:
    """Integers as a value that is frequent, two bits each that say how wide they are, and their differences."""
    differences = np.diff(np.asarray(integers, dtype=np.int64), prepend=0).astype("<i4")
    widths = b"\xff" * ((2 * len(differences) + 7) // 8)  # 32 bits all
    return pack_bytes(struct.pack("<i", 0) + widths + differences.tobytes())


def unpack_column(content: bytes, count: int) -> np.ndarray:
    """The integers of a column, shape (count,), from an LZ4 block.

    Raises:
        ValueError: If it has fewer.
    """
    if not count:
        return np.zeros(0, dtype=np.int64)
    coded = np.frombuffer(unpack_bytes(content), dtype=np.uint8)
    start = 4 + (2 * count + 7) // 8
    if len(coded) < start:
        raise ValueError("a column is shorter than it says")
    if (coded[4:start] == 0xFF).all():  # as by `pack_column`
        return np.cumsum(np.frombuffer(coded, dtype="<i4", count=count, offset=start), dtype=np.int64)
    codes = (coded[4:start, None] >> np.array([0, 2, 4, 6], dtype=np.uint8) & 3).reshape(-1)[:count]
    widths = np.array([0, 1, 2, 4])[codes]
    places = start + np.cumsum(widths) - widths
    differences = np.full(count, np.frombuffer(coded[:4], dtype="<i4")[0], dtype=np.int64)
    for width in (1, 2, 4):
        chosen = np.flatnonzero(widths == width)
        rows = coded[places[chosen, None] + np.arange(width)]
        differences[chosen] = np.ascontiguousarray(rows).view(f"<i{width}").ravel()
    return np.cumsum(differences)


def pack_bytes(content: bytes) -> bytes:
    """Size and LZ4 block, in one piece, all of it literals."""
    more = len(content) - _MORE
    length = b"\xff" * (more // 255) + bytes([more % 255]) if more >= 0 else b""
    block = b"\0" + bytes([min(len(content), _MORE) << 4]) + length + content
    return struct.pack("<Q", len(block)) + block


def unpack_bytes(block: bytes) -> bytes:
    """What an LZ4 block in one piece stands for, its size not included.

    Raises:
        ValueError: If it is in several pieces, as blocks of gigabytes are, or is no block.
    """
    if block[0]:
        raise ValueError("a block in several pieces")
    content, place = bytearray(), 1
    while place < len(block):
        lengths = block[place]
        count, place = _length(block, place + 1, lengths >> 4)
        content += block[place : place + count]
        place += count
        if place >= len(block):
            break
        back = block[place] | block[place + 1] << 8
        count, place = _length(block, place + 2, lengths & _MORE)
        if not 0 < back <= len(content):
            raise ValueError("a match before the beginning of a block")
        content += _repeated(content[-back:], count + _SHORTEST)
    return bytes(content)


def _repeated(content: bytearray, count: int) -> bytearray:
    """So many bytes of content that begins again where it ends."""
    return (content * (count // len(content) + 1) if count > len(content) else content)[:count]


def _length(block: bytes, place: int, count: int) -> tuple[int, int]:
    """A length of which the first four bits are known, and where the block goes on."""
    more = 255 if count == _MORE else 0
    while more == 255:
        more = block[place]
        count, place = count + more, place + 1
    return count, place
