"""A picture of a soup: perspective camera, sun with a shadow, sky light."""

from dataclasses import dataclass

import numpy as np

from stagedraw.raster import Coverage, FloatArray, cover
from stagedraw.soup import Soup

SUN = np.array([0.45, 0.80, 0.40]) / np.linalg.norm([0.45, 0.80, 0.40])
SKY_TOP, SKY_LOW = np.array([0.62, 0.72, 0.84]), np.array([0.90, 0.92, 0.94])
SHADOW_PIXELS = 1024


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where the picture is taken from; +Y is up."""

    eye: FloatArray
    """Place of the camera, shape (3,)."""
    target: FloatArray
    """What it looks at, shape (3,)."""
    lens: float
    """Focal length over the height of the picture."""

    def project(self, points: FloatArray, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Pixels (..., 2) and nearness, 1 over the depth (...,), of points (..., 3); negative behind the camera."""
        ahead = (self.target - self.eye) / np.linalg.norm(self.target - self.eye)
        right = np.cross(ahead, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        offset = points - self.eye
        depth = offset @ ahead
        safe = np.where(np.abs(depth) < 1e-6, 1e-6, depth)
        scale = self.lens * size[1] / safe
        pixels = np.stack([offset @ right * scale, -(offset @ np.cross(right, ahead)) * scale], axis=-1)
        return pixels + np.asarray(size) / 2.0, np.where(depth > 0.05, 1.0 / safe, -1.0)


def paint(soup: Soup, camera: Camera, size: tuple[int, int], *, smooth: int = 2) -> tuple[FloatArray, FloatArray]:
    """The picture.

    Args:
        soup: what is there, Y up.
        camera: from where.
        size: width and height [pixels].
        smooth: samples a pixel along x and y.

    Returns:
        sRGB values 0..1, shape (H, W, 3), and nearness, shape (H, W).
    """
    width, height = size[0] * smooth, size[1] * smooth
    screen, nearness = camera.project(soup.corners, (width, height))
    seen = cover(screen, nearness, (width, height))
    linear = np.linspace(0.0, 1.0, height)[:, None, None] * (SKY_LOW - SKY_TOP) + SKY_TOP
    linear = np.broadcast_to(linear**2.2, (height, width, 3)).copy()
    hit = seen.triangle >= 0
    linear[hit] = _shade(soup, seen, hit, nearness, camera)
    taps = [(slice(dy, None, smooth), slice(dx, None, smooth)) for dx in range(smooth) for dy in range(smooth)]
    blocks = sum(linear[tap] for tap in taps) / smooth**2
    near = np.max([seen.nearness[tap] for tap in taps], axis=0)
    return np.clip(blocks, 0.0, 1.0) ** (1.0 / 2.2), near


def _shade(soup: Soup, seen: Coverage, hit: np.ndarray, nearness: FloatArray, camera: Camera) -> FloatArray:
    """Colour of every pixel that shows something, linear, shape (P, 3)."""
    number = seen.triangle[hit]
    share = seen.corners[hit] * nearness[number]
    share /= (share[:, 0] + share[:, 1] + share[:, 2])[:, None]
    places, colours, normals = (
        np.einsum("pk,pkc->pc", share, field[number]) for field in (soup.corners, soup.colours, soup.normals)
    )
    normals /= np.maximum(np.sqrt(np.einsum("pc,pc->p", normals, normals)), 1e-9)[:, None]
    facing = np.einsum("pc,pc->p", normals, camera.eye - places) < 0.0
    normals[facing] *= -1.0
    sun = np.clip(normals @ SUN, 0.0, 1.0) * _lit(soup, places + 0.012 * normals, camera)
    sky = 0.5 + 0.5 * normals[:, 1]
    light = 0.95 * sun[:, None] * [1.0, 0.96, 0.90] + (0.16 + 0.34 * sky)[:, None] * [0.90, 0.95, 1.0]
    return colours * light


def _lit(soup: Soup, places: FloatArray, camera: Camera) -> FloatArray:
    """1 where the sun shines, 0 in shadow, soft over 3 x 3 texels, shape (P,); only around the camera's target."""
    right = np.cross(SUN, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    plane = np.stack([right, np.cross(right, SUN)], axis=1)
    radius = 0.75 * float(np.linalg.norm(camera.eye - camera.target))
    scale = 0.5 * SHADOW_PIXELS / radius
    corner = camera.target @ plane - radius
    height = soup.corners @ SUN
    base = float(height.min()) - 1.0
    shade = cover((soup.corners @ plane - corner) * scale, height - base, (SHADOW_PIXELS, SHADOW_PIXELS)).nearness
    texel = np.floor((places @ plane - corner) * scale).astype(int)
    covered = ((texel > 0) & (texel < SHADOW_PIXELS - 1)).all(axis=1)
    x, y = texel[covered].T
    own = places[covered] @ SUN - base + 1.6 / scale
    lit = np.ones(len(places))
    lit[covered] = sum((shade[y + dy, x + dx] <= own).astype(float) for dx in (-1, 0, 1) for dy in (-1, 0, 1)) / 9.0
    return lit
