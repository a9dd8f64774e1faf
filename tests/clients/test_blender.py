"""Blender opens crowd.expanded.usda and moves the joints to where they are; it is optional, since it is large.

`USDFOOT_BLENDER_PYTHON` names a Python that can `import bpy` (`pip install bpy` into an environment of its own).
"""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest

from tests.clients.joints import joint_positions

CODES = (0, 37, 150, 429)

IMPORT = """
import json, sys
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
(armature,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
(body,) = [thing for thing in bpy.data.objects if thing.name == "Shoes"]
frames = {}
for code in json.loads(sys.argv[2]):
    bpy.context.scene.frame_set(code)
    graph = bpy.context.evaluated_depsgraph_get()
    posed, skinned = armature.evaluated_get(graph), body.evaluated_get(graph)
    heads = {bone.name: list(posed.matrix_world @ bone.head) for bone in posed.pose.bones}
    lowest = min((skinned.matrix_world @ vertex.co)[2] for vertex in skinned.data.vertices)
    frames[code] = {"heads": heads, "lowest": lowest}
scene = bpy.context.scene
print("RESULT" + json.dumps({"frames": frames, "range": [scene.frame_start, scene.frame_end]}))
"""


@pytest.fixture(scope="module")
def blender():
    """A Python with bpy."""
    python = os.environ.get("USDFOOT_BLENDER_PYTHON")
    if not python:
        pytest.skip("no Blender: set USDFOOT_BLENDER_PYTHON to a Python that has bpy")
    if shutil.which(python) is None:
        pytest.fail(f"USDFOOT_BLENDER_PYTHON is {python}, which cannot be run")
    return python


def test_blender_opens_and_animates_what_is_written(blender, stones, tmp_path):
    expanded = stones.crowd_file.with_name("crowd.expanded.usda")
    command = [blender, "-c", IMPORT, str(expanded), json.dumps(CODES)]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout.split("RESULT")[1].splitlines()[0])
    assert result["range"] == [0, 429]
    for code in CODES:
        frame = result["frames"][str(code)]
        right = joint_positions(expanded, "Walker", float(code))
        assert set(frame["heads"]) == set(right)
        for name, place in frame["heads"].items():
            x, y, z = place  # Blender turns Y up into its own Z up
            np.testing.assert_allclose([x, z, -y], right[name], atol=1e-5, err_msg=f"{name} at {code}")
        lowest_ball = min(right[name][1] for name in ("LeftToe", "RightToe"))
        assert abs(frame["lowest"] - lowest_ball) < 0.06  # skinned to the feet, not left in the rest pose
