"""The scenes whose agents physics moves: characters, tracks and terrain, no clips."""

from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom

from stagecraft.plan_prim import BIRD_SOLE, DINOSAUR_SOLE, SOLE, author_plan, last_code
from stagecraft.rotation import FloatArray
from stagecraft.stage_file import new_stage, relate, uniform
from stagecraft.tracks import Track, bird_tracks, bird_walk, dinosaur_leaps, dinosaur_stairs, human_run

FIGURES = {
    "physics_bird_walk": (bird_walk, "bird", BIRD_SOLE, "a walking bird (Figure 15)"),
    "physics_dinosaur_stairs": (dinosaur_stairs, "dinosaur", DINOSAUR_SOLE, "a dinosaur on stairs (Figure 16)"),
    "physics_dinosaur_leaps": (dinosaur_leaps, "dinosaur", DINOSAUR_SOLE, "a turn and two leaps (Figure 17)"),
    "physics_human_run": (human_run, "human", SOLE, "a run over variable terrain (Figure 18)"),
    "physics_bird_tracks": (bird_tracks, "bird", BIRD_SOLE, "tracks timed by their distances (Figure 19)"),
}
"""Results of van de Panne 1997: track, character, shape of the prints, what it shows."""


def write_physics_scenes(folder: Path) -> None:
    """Write all scenes into `folder`."""
    for name, (track, character, sole, about) in FIGURES.items():
        _write(folder / f"{name}.usda", track(), character, sole, about)


def _write(path: Path, track: Track, character: str, sole: FloatArray, about: str) -> None:
    plan = track.plan
    stage = new_stage(path, "World", "Xform", f"{about} after van de Panne 1997")
    UsdGeom.Scope.Define(stage, "/World/Terrain")
    for terrain in track.terrains:
        xform = UsdGeom.Xform.Define(stage, f"/World/Terrain/{terrain.capitalize()}")
        xform.GetPrim().GetReferences().AddReference(f"./terrain_{terrain}.usda")
    UsdGeom.Scope.Define(stage, "/World/Plans")
    author_plan(stage, f"/World/Plans/{plan.name}", plan, sole=sole)
    agent = stage.DefinePrim("/World/Walker")
    agent.GetReferences().AddReference(f"./{character}.usdc")
    agent.AddAppliedSchema("UsdfootAgentAPI")
    relate(agent, "usdfoot:agent:plan", [f"/World/Plans/{plan.name}"])
    uniform(agent, "usdfoot:agent:motion", Sdf.ValueTypeNames.Token, "physics")
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(float(np.ceil(last_code(plan))))
    stage.Save()
