"""The web page: what is in it is what was given, exactly as far as it says, and stays data."""

import base64
import hashlib
import html.parser
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of
from numpy.testing import assert_allclose, assert_array_equal

from tests.writers.pages import STICK, crowd_of, taken_apart, walker
from usdfoot.errors import OutputError, UsdfootError
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton
from usdfoot.model.terrain import Terrain
from usdfoot.writers.page import three
from usdfoot.writers.page.block import encode_block, quantised
from usdfoot.writers.page.document import page_text, write_document
from usdfoot.writers.page.ground import MOST_TRIANGLES, picture_ground
from usdfoot.writers.page.stick import stick_figure

KINDS = ["int16", "int32", "uint8", "uint16", "uint32", "float32"]


@given(st.data())
def test_every_array_comes_out_of_the_block_as_it_went_in(data):
    given_arrays = {
        kind: data.draw(arrays_of.arrays(np.dtype(kind), st.integers(0, 40)))
        for kind in data.draw(st.permutations(KINDS))
    }
    directory, block = encode_block(given_arrays)
    text = f'id="header">{{"arrays": {directory}}}</script>'.replace("'", '"') + f'id="block">{block}</script>'
    for name, values in taken_apart(text)[1].items():
        assert_array_equal(values, given_arrays[name])


def test_other_types_are_refused():
    with pytest.raises(TypeError, match="heights is float64"):
        encode_block({"heights": np.zeros(3)})


def test_quantising_keeps_half_a_resolution_and_knows_nan():
    values = np.array([0.0004, -1.23456, np.nan, 100.0])
    steps = quantised(values, 0.001)
    assert_allclose(steps[:2] * 0.001, values[:2], atol=0.0005)
    assert steps[2] == -32768 and steps[3] == 32767


def test_positions_are_kept_to_a_millimetre_far_from_the_origin():
    agents = [walker("Near", x=100_000.0), walker("Far", x=100_300.0, frames=40)]
    header, arrays = taken_apart(page_text(crowd_of(*agents)))
    first_frame = first_joint = 0
    for agent in agents:
        frames, joints = agent.joints.shape[:2]
        roots = arrays["roots"][3 * first_frame :][: 3 * frames].reshape(3, frames).T * 0.001 + header["origin"]
        stored = arrays["joints"][first_joint:][: 3 * frames * joints].reshape(joints, 3, frames)
        shown = roots[:, None] + header["resolution"] * stored.transpose(2, 0, 1)
        assert header["resolution"] == 0.001
        assert_allclose(roots, agent.roots, atol=0.00051)
        assert_allclose(shown, agent.joints, atol=0.00051)
        first_frame += frames
        first_joint += 3 * frames * joints


def test_giants_are_kept_as_exactly_as_sixteen_bits_allow():
    agent = walker("Giant")
    giant = agent.__class__(**{**agent.__dict__, "joints": agent.roots[:, None] + 100.0 * np.ones((1, 5, 3))})
    header, arrays = taken_apart(page_text(crowd_of(giant)))
    assert header["resolution"] == pytest.approx(0.004)
    assert_allclose(arrays["joints"] * header["resolution"], 100.0, atol=0.0026)


def test_steps_figures_and_clips_arrive():
    status = ("ok", "outsideHull", "ikLimited", "ok")
    agents = [walker("One", status=status), walker("Two", x=2.0)]
    header, arrays = taken_apart(page_text(crowd_of(*agents)))
    assert [header["statuses"][i] for i in arrays["stepStatuses"]] == [*status, *("ok",) * 4]
    assert arrays["promised"].tolist() == [1, 1, 0, 1, 1, 1, 1, 1]
    assert [header["clips"][i] for i in arrays["clipIndices"][:4]] == list(agents[0].results.clips)
    assert_allclose(arrays["step:placement"][:4], agents[0].steps["placement"])
    assert_allclose(arrays["agent:sole"], [-0.5, -0.5])
    assert_allclose(arrays["strikeTimes"][4:], agents[1].plan.strike_times)
    soles = arrays["soles"][:61] * header["soleResolution"]
    assert_allclose(soles, agents[0].sole_heights[:, 0], atol=5.1e-5)
    assert (arrays["soles"][61:122] == -32768).all()
    assert header["stickFigures"] == [
        {"parents": [-1, 0, 1, 0, 3], "sides": [2, 0, 0, 1, 1], "head": -1, "legLength": 0.9, "footLength": 0.15}
    ]
    assert header["total"][0]["value"] is None


def test_same_picture_same_page():
    assert page_text(crowd_of(walker("One"))) == page_text(crowd_of(walker("One")))


class Reader(html.parser.HTMLParser):
    """Addresses in a page, and its scripts: attributes and text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.scripts: list[list] = []
        self.tag = ""
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tag = tag
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag == "script":
            self.scripts.append([dict(attrs), ""])

    def handle_data(self, data):
        if self.tag == "script":
            self.scripts[-1][1] += data

    def handle_endtag(self, tag):
        self.tag = ""


def test_the_page_asks_for_nothing_and_runs_only_what_it_names():
    text = page_text(crowd_of(walker("One")))
    reader = Reader(text)
    assert reader.addresses == ["data:,"]
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert policy.startswith("default-src 'none';") and "unsafe" not in policy and "http" not in policy
    running = [content for attributes, content in reader.scripts if "type" not in attributes]
    assert len(running) == 2
    for content in running:
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy


def test_whatever_a_scene_says_stays_data():
    evil = '</script><script>window.hacked = 1</script><!--"&\u2028'
    agent = walker(evil, status=(evil,) * 4)
    text = page_text(crowd_of(agent, title=evil, problems=(evil,), notes=(evil,), facts={evil: evil}))
    assert len(Reader(text).scripts) == 4
    header, _ = taken_apart(text)
    assert header["names"] == header["problems"] == [evil] and evil in header["statuses"]


def test_a_page_replaces_a_page_only_and_whole(tmp_path):
    page = tmp_path / "new" / "report.html"
    crowd = crowd_of(walker("One"))
    write_document(page, crowd)
    assert page.read_text(encoding="utf-8") == page_text(crowd)
    assert [path.name for path in page.parent.iterdir()] == ["report.html"]
    with pytest.raises(OutputError, match=r"report.json: ends in .json. name a page that ends in .html"):
        write_document(tmp_path / "report.json", crowd)
    with pytest.raises(OutputError, match="cannot be written"):
        write_document(page / "inside.html", crowd)


def test_without_three_js_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(three, "PACKAGE", "no_such_package")
    with pytest.raises(UsdfootError, match=r"three.js: is not installed.*pip install 'usdfoot\[report\]'"):
        page_text(crowd_of(walker("One")))


def terrain_of(points, triangles, walkable=(True,)) -> Terrain:
    return Terrain(
        meshes=tuple(f"/World/Terrain_{i}" for i in range(len(walkable))),
        points=np.asarray(points, dtype=float),
        triangles=np.asarray(triangles),
        mesh_indices=np.arange(len(triangles)) % len(walkable),
        walkable=np.array(walkable),
    )


def test_the_ground_is_the_terrain_near_the_crowd():
    square = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    terrain = terrain_of(
        np.concatenate([square, square + (50.0, 7.0, 0.0)]), [[0, 1, 2], [3, 4, 5]], walkable=(False, True)
    )
    ground = picture_ground(terrain, np.array([[0.2, 0.0, 0.2]]))
    assert_array_equal(ground.points[ground.triangles[0]], square)
    assert len(ground.points) == 3 and ground.walkable.tolist() == [False]
    assert picture_ground(terrain, np.array([[49.0, 7.0, 0.2]])).walkable.tolist() == [True]
    for plane in (picture_ground(None, square + 3.0), picture_ground(terrain, np.array([[900.0, 3.0, 0.0]]))):
        assert len(plane.triangles) == 0 and plane.level == 3.0


def test_too_many_triangles_become_heights_on_a_grid():
    count = int(np.sqrt(MOST_TRIANGLES / 2)) + 3
    x, z = np.meshgrid(np.linspace(-3.9, 3.9, count), np.linspace(-3.9, 3.9, count))
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = np.concatenate(
        [
            np.column_stack([corner, corner + count, corner + 1]),
            np.column_stack([corner + 1, corner + count, corner + count + 1]),
        ]
    )
    slope = terrain_of(np.column_stack([x.ravel(), 0.3 * x.ravel(), z.ravel()]), triangles)
    ground = picture_ground(slope, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    used = ground.points[np.unique(ground.triangles)]
    assert 0 < len(ground.triangles) <= MOST_TRIANGLES and ground.sampled > 0.0 and ground.walkable.all()
    assert_allclose(used[:, 1], 0.3 * used[:, 0], atol=1e-6)
    edges = [ground.points[ground.triangles[:, k]] - ground.points[ground.triangles[:, 0]] for k in (1, 2)]
    assert (np.cross(*edges)[:, 1] > 0.0).all()


def test_a_stick_figure_has_legs_head_and_limbs_but_no_fingers():
    paths = ["root", "root/pelvis"]
    offsets = [(0.0, 0.0, 0.0), (0.0, 0.9, 0.0)]
    for side, x in (("L", 0.1), ("R", -0.1)):
        for name, offset in (
            ("hip", (x, 0.0, 0.0)),
            ("knee", (0, -0.45, 0)),
            ("ankle", (0, -0.4, 0)),
            ("ball", (0, -0.03, 0.1)),
        ):
            above = "root/pelvis" if name == "hip" else paths[-1]
            paths.append(f"{above}/{name}{side}")
            offsets.append(offset)
    for above, name, offset in (
        ("root/pelvis/hipL/kneeL/ankleL/ballL", "toe", (0.0, 0.0, 0.05)),
        ("root/pelvis", "spine", (0.0, 0.4, 0.0)),
        ("root/pelvis/spine", "Head", (0.0, 0.1, 0.0)),
        ("root/pelvis/spine/Head", "jaw", (0.0, 0.0, 0.05)),
        ("root/pelvis/spine", "arm", (0.2, 0.0, 0.0)),
        ("root/pelvis/spine/arm", "hand", (0.5, 0.0, 0.0)),
        ("root/pelvis/spine/arm/hand", "thumb", (0.05, 0.0, 0.0)),
        ("root/pelvis/spine/arm/hand/thumb", "tip", (0.05, 0.0, 0.0)),
    ):
        paths.append(f"{above}/{name}")
        offsets.append(offset)
    parents = [paths.index(path.rsplit("/", 1)[0]) if "/" in path else -1 for path in paths]
    order = {name.rsplit("/", 1)[-1]: i for i, name in enumerate(paths)}
    skeleton = Skeleton(
        name="/Hero/Skeleton",
        joints=tuple(paths),
        parents=np.array(parents),
        rest_translations=np.array(offsets, dtype=float),
        rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(paths), 1)),
    )
    pairs = {name + "s": (order[f"{name}L"], order[f"{name}R"]) for name in ("hip", "knee", "ankle", "ball")}
    biped = Biped(
        pelvis=1, **pairs, ball_heights=np.zeros(2), com=np.zeros(3), nominal_leg_length=0.85, maximal_leg_length=0.86
    )
    stick = stick_figure(skeleton, biped)
    names = [paths[joint].rsplit("/", 1)[-1] for joint in stick.joints]
    legs = [f"{name}{side}" for side in "LR" for name in ("hip", "knee", "ankle", "ball")]
    assert sorted(names) == sorted(["pelvis", *legs, "spine", "Head", "arm", "hand"]) and names[0] == "pelvis"
    assert names[stick.head] == "Head"
    assert [names[parent] for parent in stick.parents[1:]] == [
        paths[joint].rsplit("/", 2)[-2] for joint in stick.joints[1:]
    ]
    assert {name for name, side in zip(names, stick.sides, strict=True) if side == 1} == {
        name for name in legs if name[-1] == "R"
    }
    assert stick.foot_length == pytest.approx(np.hypot(0.03, 0.1))
    assert STICK.parents[0] == stick.parents[0] == -1
