"""Z-buffer for triangle soups, in numpy: which triangle covers which pixel, and where in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CHUNK = 2_000_000
"""Pixels tested at once, to bound the memory."""


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """What the pixels show; row 0 is the top of the picture."""

    triangle: NDArray[np.int64]
    """Triangle seen, -1 for none, shape (H, W)."""
    corners: FloatArray
    """Barycentric coordinates in it, as seen on the screen, shape (H, W, 3)."""
    nearness: FloatArray
    """1 over the depth [1/m], 0 where nothing is seen, shape (H, W)."""


def cover(screen: FloatArray, nearness: FloatArray, size: tuple[int, int]) -> Coverage:
    """Rasterise triangles.

    Args:
        screen: corners in pixels (x to the right, y down), shape (T, 3, 2).
        nearness: 1 over the depth of the corners, shape (T, 3); triangles with a corner <= 0 are left out.
        size: width and height in pixels.
    """
    width, height = size
    triangle = np.full(width * height, -1)
    corners, near = np.zeros((width * height, 3)), np.zeros(width * height)
    low = np.floor(screen.min(axis=1)).astype(np.int64)
    high = np.ceil(screen.max(axis=1)).astype(np.int64)
    low, high = np.maximum(low, 0), np.minimum(high, [width - 1, height - 1])
    spans = high - low + 1
    seen = (spans > 0).all(axis=1) & (nearness > 0.0).all(axis=1)
    level = np.ceil(np.log2(np.maximum(spans, 1))).astype(int) @ [1, 64]
    for step in np.unique(level[seen]):
        members = np.flatnonzero(seen & (level == step))
        box = spans[members].max(axis=0)
        batch = max(1, CHUNK // int(box.prod()))
        for start in range(0, len(members), batch):
            part = members[start : start + batch]
            _draw(part, screen[part], nearness[part], low[part], box, width, height, triangle, corners, near)
    return Coverage(
        triangle=triangle.reshape(height, width),
        corners=corners.reshape(height, width, 3),
        nearness=near.reshape(height, width),
    )


def _draw(
    numbers: NDArray[np.int64],
    screen: FloatArray,
    nearness: FloatArray,
    low: NDArray[np.int64],
    box: NDArray[np.int64],
    width: int,
    height: int,
    triangle: NDArray[np.int64],
    corners: FloatArray,
    near: FloatArray,
) -> None:
    """Test every pixel of each triangle's box and keep the nearest (writes into the last three)."""
    across, down, base = _share_planes(screen - low[:, None])
    x, y = np.arange(box[0], dtype=np.float32), np.arange(box[1], dtype=np.float32)
    rows = base[:, :, None] + down[:, :, None] * y
    first = rows[:, 0, :, None] + across[:, 0, None, None] * x
    second = rows[:, 1, :, None] + across[:, 1, None, None] * x
    which, row, column = np.nonzero((first >= 0.0) & (second >= 0.0) & (first + second <= 1.0))
    share = np.stack([first[which, row, column], second[which, row, column]], axis=1).astype(np.float64)
    share = np.concatenate([share, 1.0 - share.sum(axis=1, keepdims=True)], axis=1)
    pixel_x, pixel_y = low[which, 0] + column, low[which, 1] + row
    kept = (pixel_x < width) & (pixel_y < height)
    which, share, index = which[kept], share[kept], pixel_y[kept] * width + pixel_x[kept]
    depth = np.einsum("pk,pk->p", share, nearness[which])
    ahead = depth > near[index]
    order = np.flatnonzero(ahead)[np.argsort(depth[ahead], kind="stable")]  # the last write, the nearest, stays
    near[index[order]] = depth[order]
    corners[index[order]] = share[order]
    triangle[index[order]] = numbers[which[order]]


def _share_planes(screen: FloatArray) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """The first two barycentric coordinates as across * x + down * y + base at pixel centres, shape (T, 2) each."""
    a, b, c = screen[:, 0], screen[:, 1], screen[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    scale = 1.0 / np.where(np.abs(area) < 1e-9, np.inf, area)
    across = np.stack([b[:, 1] - c[:, 1], c[:, 1] - a[:, 1]], axis=1) * scale[:, None]
    down = np.stack([c[:, 0] - b[:, 0], a[:, 0] - c[:, 0]], axis=1) * scale[:, None]
    base = -np.stack(
        [
            across[:, 0] * (c[:, 0] - 0.5) + down[:, 0] * (c[:, 1] - 0.5),
            across[:, 1] * (c[:, 0] - 0.5) + down[:, 1] * (c[:, 1] - 0.5),
        ],
        axis=1,
    )
    base[np.abs(area) < 1e-9] = -1.0
    return across.astype(np.float32), down.astype(np.float32), base.astype(np.float32)
