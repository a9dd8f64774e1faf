"""Grids of heights: pictures, ESRI ASCII grids, numpy arrays and text files of numbers."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.errors import TerrainError, UsdfootError
from usdfoot.importers.text_lines import TextLine, number_in, number_rows, read_text_lines
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import Limits, check_limit

__all__ = ["GRID_SUFFIXES", "PICTURE_SUFFIXES", "HeightGrid", "read_height_grid"]

PICTURE_SUFFIXES = (".png", ".tif", ".tiff")
GRID_SUFFIXES = (*PICTURE_SUFFIXES, ".asc", ".npz", ".npy", ".txt")
DEGREE = 1.1119e5
"""Of latitude, or of longitude at the equator [m]."""
ESRI = ("ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "nodata_value")
UNREADABLE = (ValueError, OSError, EOFError, KeyError, OverflowError, MemoryError, zipfile.BadZipFile)
"""What numpy raises for files that are none of its own."""


@dataclass(frozen=True, kw_only=True)
class HeightGrid:
    """Heights as they stand in a file."""

    values: FloatArray
    """Rows from north to south, columns from west to east, NaN where there is no ground, shape (R, C); of pictures
    0 is black and 1 is white."""
    cell: float
    """Distance of two columns or rows as the file says, 0 if it does not."""
    remarks: tuple[str, ...] = ()
    """What was odd."""
    degrees: tuple[float, float] = (0.0, 0.0)
    """Distances of columns and rows if what the file says of them are degrees of a map [m]; 0 = it says nothing."""


def read_height_grid(path: Path, limits: Limits) -> HeightGrid:
    """The grid in a file.

    Raises:
        TerrainError: If the file cannot be read or is malformed; the line of a text file is named.
        SceneError: If it would have more triangles than the limits allow.
    """
    suffix = path.suffix.lower()
    if suffix in PICTURE_SUFFIXES:
        grid = _read_picture(path, limits)
    elif suffix in (".npz", ".npy"):
        values, numbers = _read_array(path, limits)
        grid = HeightGrid(values=values, cell=0.0, degrees=_degree_sizes(numbers))
    elif suffix == ".asc":
        grid = _read_esri(path, limits)
    else:
        lines = read_text_lines(path, split=_words, error_type=TerrainError)
        if not lines:
            raise TerrainError(path, "has no numbers", "a line is a row of heights")
        _check_size(path, (len(lines), len(lines[0].words)), limits)
        grid = HeightGrid(values=number_rows(lines, len(lines[0].words), "columns"), cell=0.0)
    if min(grid.values.shape) < 2:
        raise TerrainError(
            path, f"has {grid.values.shape[0]} rows and {grid.values.shape[1]} columns", "two are needed"
        )
    return grid


def _check_size(path: Path, shape: tuple[int, ...], limits: Limits) -> None:
    check_limit(path, "triangles", 2.0 * shape[0] * shape[1], limit=limits.triangles)


def _words(line: str) -> list[str]:
    return line.replace(",", " ").replace(";", " ").split()


def _read_picture(path: Path, limits: Limits) -> HeightGrid:
    """Grey values from 0 to 1; the first channel of pictures in colour."""
    try:
        from PIL import Image
    except ImportError as error:
        raise TerrainError(path, "cannot be read: pillow is not installed", "pip install 'usdfoot[import]'") from error
    try:
        with Image.open(path) as picture:
            _check_size(path, picture.size, limits)
            grey = picture.convert("RGBA") if picture.mode == "P" else picture
            pixels: Any = np.asarray(grey)
    except UsdfootError:
        raise
    except (*UNREADABLE, SyntaxError, Image.DecompressionBombError) as error:
        raise TerrainError(path, f"is no picture that can be read ({error})", "save it as PNG again") from error
    remarks = []
    if pixels.ndim == 3:
        colours = 3 if pixels.shape[2] > 2 else 1
        channels, alpha = pixels[..., :colours], pixels[..., colours:]
        if np.any(channels != channels[..., :1]):
            remarks.append("its red, green and blue differ; red is taken as the height")
        if alpha.size and alpha.min() < alpha.max():
            remarks.append("it is partly transparent, which is ignored")
        pixels = channels[..., 0]
    full = 1.0 if pixels.dtype.kind in "fb" else 255.0 if pixels.itemsize == 1 else 65535.0
    return HeightGrid(values=pixels.astype(float) / full, cell=0.0, remarks=tuple(remarks))


def _read_array(path: Path, limits: Limits) -> tuple[FloatArray, dict[str, float]]:
    """The only array of two dimensions in a file of numpy's, and the single numbers beside it."""
    try:
        if path.suffix.lower() == ".npy":
            arrays = {path.stem: np.load(path, mmap_mode="r", allow_pickle=False)}
        else:
            with zipfile.ZipFile(path) as archive:
                size = sum(part.file_size for part in archive.infolist())
            check_limit(path, "triangles", size / 4, limit=limits.triangles)
            with np.load(path, allow_pickle=False) as archive_arrays:
                arrays = {name: archive_arrays[name] for name in archive_arrays.files}
    except UsdfootError:
        raise
    except UNREADABLE as error:
        raise TerrainError(path, f"cannot be read by numpy ({error})", "save it with numpy.save or savez") from error
    grids = {name: array for name, array in arrays.items() if array.ndim == 2 and array.dtype.kind in "iufb"}
    if len(grids) != 1:
        what = f"has {len(grids)} arrays of two dimensions"
        raise TerrainError(path, what, "exactly one is the height", arrays)
    (grid,) = grids.values()
    _check_size(path, grid.shape, limits)
    numbers = {name: float(array) for name, array in arrays.items() if array.ndim == 0 and array.dtype.kind in "iuf"}
    return grid.astype(float), numbers


def _degree_sizes(numbers: Mapping[str, float]) -> tuple[float, float]:
    """How far columns and rows are apart [m] if dx, dy, ymin and ymax are degrees of longitude and latitude, else 0."""
    try:
        dx, dy, ends = abs(numbers["dx"]), abs(numbers["dy"]), (numbers["ymin"], numbers["ymax"])
    except KeyError:
        return 0.0, 0.0
    if not (0.0 < dx < 1.0 and 0.0 < dy < 1.0 and max(map(abs, ends)) < 90.0):
        return 0.0, 0.0
    return DEGREE * dx * float(np.cos(np.radians(0.5 * sum(ends)))), DEGREE * dy


def _read_esri(path: Path, limits: Limits) -> HeightGrid:
    """An ESRI ASCII grid: lines of keywords, then rows from north to south."""
    lines = read_text_lines(path, error_type=TerrainError)
    header: dict[str, tuple[TextLine, float]] = {}
    while len(header) < len(lines) and lines[len(header)].words[0].lower() in ESRI:
        line = lines[len(header)]
        if len(line.words) != 2 or line.words[0].lower() in header:
            raise line.error("is no keyword with one number, or is there twice", "like cellsize 30")
        header[line.words[0].lower()] = line, number_in(line, line.words[1])
    missing = [name for name in ("ncols", "nrows", "cellsize") if name not in header]
    if missing:
        raise TerrainError(path, "lacks keywords", "an ESRI grid begins with ncols, nrows and cellsize", missing)
    columns, count, cell = (header[name][1] for name in ("ncols", "nrows", "cellsize"))
    rows: Sequence[TextLine] = lines[len(header) :]
    if count != len(rows):
        raise header["nrows"][0].error(f"says {count:g} rows, there are {len(rows)}", "the file may be cut off")
    if cell <= 0.0:
        raise header["cellsize"][0].error("is no size of a cell", "a number above 0 is")
    if columns != int(columns) or columns < 1:
        raise header["ncols"][0].error("is no number of columns", "a whole number is")
    _check_size(path, (len(rows), int(columns)), limits)
    values = number_rows(rows, int(columns), "columns")
    nothing = header["nodata_value"][1] if "nodata_value" in header else np.nan
    return HeightGrid(values=np.where(values == nothing, np.nan, values), cell=cell)
