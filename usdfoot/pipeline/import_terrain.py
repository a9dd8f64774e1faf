"""Import terrain: meshes and height grids of other programs become a layer to put under a scene."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from usdfoot import __version__
from usdfoot.bridge.names import unique_name
from usdfoot.bridge.units import CANONICAL
from usdfoot.errors import TerrainError, UsdfootError
from usdfoot.importers.height_grids import GRID_SUFFIXES
from usdfoot.importers.terrain_files import MESH_SUFFIXES, TerrainFormat, import_terrain_file
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.readers.stage import open_stage, read_stage_info
from usdfoot.writers.terrain import write_terrain

__all__ = ["TERRAIN_SUFFIXES", "ImportedTerrain", "import_terrain"]

TERRAIN_SUFFIXES = (*MESH_SUFFIXES, *GRID_SUFFIXES)
"""Of files that can be imported as terrain."""


@dataclass(frozen=True, kw_only=True)
class ImportedTerrain:
    """Outcome of one import."""

    file: Path
    """The layer written."""
    terrains: Mapping[str, Terrain]
    """What is in it, by name."""
    problems: tuple[Problem, ...]
    """Files that were skipped (errors) and what was odd (warnings)."""


def import_terrain(
    files: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    terrain_format: TerrainFormat | None = None,
    scene: str | os.PathLike[str] | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> ImportedTerrain:
    """Write terrain files as a layer with UsdfootTerrainAPI, to be a sublayer of a scene.

    Args:
        files: .obj, .ply, .stl; heights as .png, .tif, .asc, .npz, .npy, .txt.
        output: .usd, .usda or .usdc to write.
        terrain_format: Units and sizes that the files do not state.
        scene: Stage the terrain is for: its units and axes; None = metres, Y up.
        progress: Told which file is read, how many are done, and of how many.

    Raises:
        UsdfootError: If no file can be used; the first error.
        OutputError: If the layer cannot be written.
    """
    info = read_stage_info(open_stage(scene)) if scene is not None else None
    terrains: dict[str, Terrain] = {}
    names: set[str] = set()
    problems: list[Problem] = []
    errors: list[UsdfootError] = []
    for done, file in enumerate(files):
        progress(Path(file).name, done, len(files))
        try:
            terrain, doubts = import_terrain_file(file, terrain_format=terrain_format)
        except UsdfootError as error:
            errors.append(error)
            continue
        terrains[unique_name(Path(file).stem, names)] = terrain
        problems += doubts
    if not terrains:
        raise errors[0] if errors else TerrainError("files", "there are none", "name at least one")
    problems += [Problem(severity="error", where=error.where, message=str(error)) for error in errors]
    progress("write", 0, 0)
    provenance = {"version": __version__, "sources": ", ".join(Path(file).name for file in files)}
    sources = (*(info.layers if info else ()), *(os.fspath(file) for file in files))
    units = info.units if info else CANONICAL
    target = write_terrain(output, terrains, units=units, sources=sources, provenance=provenance)
    return ImportedTerrain(file=target, terrains=terrains, problems=tuple(problems))
