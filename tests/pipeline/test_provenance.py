"""What a crowd says of its making."""

from dataclasses import asdict, replace

from pxr import Sdf

from usdfoot.model.limits import Limits
from usdfoot.model.tuning import BodyTuning
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.provenance import CallRecord, call_of, options_of


def test_options_are_read_back_as_they_were_given(scene, tmp_path):
    options = MotionOptions(seam="crossfade", root_weight=0.25, corrections=3)
    options = replace(options, tuning=BodyTuning(crouch=0.1), follow=replace(options.follow, hurry=1.25))
    given = {"frames": (3, 40), "chunk_size": 7, "limits": Limits(frames=500)}
    crowd = animate(scene, tmp_path, options=options, agents=["Walk*", "Run*"], **given).crowd_file
    provenance = Sdf.Layer.FindOrOpen(str(crowd)).customLayerData["usdfoot"]
    assert asdict(options_of(provenance)) == asdict(options)
    assert call_of(provenance) == CallRecord(agents=["Walk*", "Run*"], **given)


def test_what_is_not_said_has_its_default():
    assert options_of({"options": {"seam": "none", "of_a_later_version": 1}}) == MotionOptions(seam="none")
    assert call_of({}) == CallRecord(agents=["*"])
