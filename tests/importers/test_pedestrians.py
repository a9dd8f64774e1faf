"""Pedestrian data: every layout says the same, malformed lines are named, units and rates are never guessed."""

import re
import sqlite3

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.errors import TrackError
from usdfoot.importers.pedestrians import import_pedestrians

RATE = 10.0
FRAMES = np.arange(20, 60, 2)
PEOPLE = {3: (1.0, 0.4), 12: (-2.0, 1.1), 5: (6.0, -0.7)}


def walk(person):
    """Map x, y [m] of a person at FRAMES: straight, north by their speed."""
    x, speed = PEOPLE[person]
    return np.stack([np.full(len(FRAMES), x), speed * FRAMES / RATE], axis=1)


def rows(order, scale=1.0, by="frame"):
    """Numbers of all samples in columns `order`, sorted by frame or by person."""
    samples = [(frame, person, *(scale * walk(person)[i])) for i, frame in enumerate(FRAMES) for person in PEOPLE]
    if by == "person":
        samples.sort(key=lambda sample: sample[1])
    named = [dict(zip(("frame", "id", "x", "y"), sample, strict=True)) for sample in samples]
    return [[row.get(name, 0.0) for name in order] for row in named]


def text(order, separator="\t", head="", **options):
    return head + "\n".join(separator.join(f"{value:.9g}" for value in row) for row in rows(order, **options)) + "\n"


FILES = {
    "eth": (text(("frame", "id", "x", "y")), {"unit": "m", "rate": RATE}),
    "obsmat": (text(("frame", "id", "x", "z", "y", "vx", "vz", "vy"), "  "), {"unit": "m", "rate": RATE}),
    "juelich": (text(("id", "frame", "x", "y", "z"), " ", scale=100.0, by="person"), {"unit": "cm", "rate": RATE}),
    "petrack": (
        text(("id", "frame", "x", "y", "z"), " ", "# framerate: 10.00 fps\n# id frame x/cm y/cm z/cm\n", scale=100.0),
        {},
    ),
    "csv": (
        text(("x", "y", "frame", "id"), ",", "x,y,frame,pedestrian\n", by="person"),
        {"unit": "1", "rate": RATE},
    ),
    "jupedsim": (text(("id", "frame", "x", "y"), "\t", "#framerate: 10\n#ID\tFR\tX/m\tY/m\n"), {}),
}


@pytest.mark.parametrize("kind", FILES)
def test_every_layout_says_the_same(tmp_path, kind):
    content, options = FILES[kind]
    (tmp_path / "tracks.txt").write_text(content)
    found, problems = import_pedestrians(tmp_path / "tracks.txt", **options)
    assert not problems
    assert [trajectory.name for trajectory in found] == [f"tracks.txt {person}" for person in sorted(PEOPLE)]
    for person, trajectory in zip(sorted(PEOPLE), found, strict=True):
        assert_allclose(trajectory.times, FRAMES / RATE)
        assert_allclose(trajectory.positions[:, [0, 2]], walk(person) * (1.0, -1.0), atol=1e-6)  # north is -z


def test_times_in_seconds_need_no_rate(tmp_path):
    lines = ["time;id;x;y", *(f"{0.5 * i};7;{0.1 * i};0" for i in range(5))]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    (found,), _ = import_pedestrians(tmp_path / "a.csv", unit="ft")
    assert_allclose(found.times, 0.5 * np.arange(5))
    assert_allclose(found.positions[:, 0], 0.03048 * np.arange(5))


@pytest.mark.parametrize(
    ("header", "scale", "options"),
    [
        ('"track_id", "time [s]", "x [m]", "y [m]"', 1.0, {}),
        ("# id | t / ms | x / m | y / m", 1000.0, {}),
        ("id,timestamp,x,y", 1000.0, {"unit": "m", "rate": 1000.0}),
    ],
)
def test_headers_may_space_and_quote_their_units_and_have_times_in_other_ones(tmp_path, header, scale, options):
    rows = [f'"3",{scale * 0.5 * i:g},{0.4 * i:g},"1"' for i in range(6)]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]))
    (found,), _ = import_pedestrians(tmp_path / "a.csv", **options)
    assert_allclose(found.times, 0.5 * np.arange(6))
    assert_allclose(found.positions[:, 0], 0.4 * np.arange(6))


def test_times_of_unknown_unit_are_taken_for_seconds_with_a_warning(tmp_path, caplog):
    (tmp_path / "a.csv").write_text("id,t,x,y\n" + "".join(f"1,{i},{i},0\n" for i in range(3)))
    (found,), _ = import_pedestrians(tmp_path / "a.csv", unit="m")
    assert_allclose(found.times, np.arange(3))
    assert "times are taken for seconds" in caplog.text


def test_commas_beside_semicolons_are_decimal_ones(tmp_path):
    (tmp_path / "a.csv").write_text("id;frame;x;y\n" + "".join(f"1;{i};{i},25;-2,5\n" for i in range(3)))
    (found,), _ = import_pedestrians(tmp_path / "a.csv", unit="m", rate=1.0)
    assert_allclose(found.positions, [[i + 0.25, 0.0, 2.5] for i in range(3)])


@pytest.mark.parametrize("separator", ["\t", " ", " | "])
def test_commas_within_what_blanks_part_are_decimal_ones(tmp_path, separator):
    rows = [f"1{separator}{i}{separator}{i},25{separator}-2,5" for i in range(3)]
    (tmp_path / "a.txt").write_text("\r\n".join([separator.join(["id", "frame", "x", "y"]), *rows]))
    (found,), _ = import_pedestrians(tmp_path / "a.txt", unit="m", rate=1.0)
    assert_allclose(found.positions, [[i + 0.25, 0.0, 2.5] for i in range(3)])


@pytest.mark.parametrize(
    "header",
    [
        "id,frame,kind,x,y,speed,",
        "# id, frame, kind, x, y, speed",
        "# id frame x y\nid;frame;kind;x;y;v",
    ],
)
def test_people_may_be_words_and_columns_that_nobody_needs_empty_or_words(tmp_path, header):
    kinds = ("on foot", "", "nan", "7")
    rows = [f'"{who}",{i},{kinds[i]},{0.5 * i},{y},,' for i in range(4) for y, who in enumerate(("1_1", "Ada", "11"))]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]), encoding="utf-8-sig")
    found, _ = import_pedestrians(tmp_path / "a.csv", unit="m", rate=1.0)
    assert [trajectory.name for trajectory in found] == ["a.csv 1_1", "a.csv Ada", "a.csv 11"]
    for y, trajectory in enumerate(found):
        assert_allclose(trajectory.positions, [[0.5 * i, 0.0, -y] for i in range(4)])


def test_people_with_long_numbers_stay_apart(tmp_path):
    people = [9071300, 9071301, 12345678901, -7]
    lines = [f"{frame} {person} {0.1 * frame + k} 0" for k, person in enumerate(people) for frame in range(3)]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    found, _ = import_pedestrians(tmp_path / "a.txt", unit="m", rate=10.0, layout="eth")
    assert [trajectory.name for trajectory in found] == [f"a.txt {person}" for person in sorted(people)]


def test_jupedsims_database(tmp_path):
    connection = sqlite3.connect(tmp_path / "out.sqlite")
    connection.execute("CREATE TABLE trajectory_data (frame, id, pos_x, pos_y, ori_x, ori_y)")
    connection.execute("CREATE TABLE metadata (key, value)")
    connection.execute("INSERT INTO metadata VALUES ('fps', '10')")
    samples = [tuple(map(float, row)) for row in rows(("frame", "id", "x", "y"))]
    connection.executemany("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, 1, 0)", samples)
    connection.commit()
    connection.close()
    found, _ = import_pedestrians(tmp_path / "out.sqlite")
    assert len(found) == 3
    assert_allclose(found[0].positions[:, [0, 2]], walk(3) * (1.0, -1.0))
    with pytest.raises(TrackError, match="10 frames a second, not 25"):
        import_pedestrians(tmp_path / "out.sqlite", rate=25.0)


def test_ucys_splines(tmp_path):
    content = "2 - the number of splines\n2 - Num of control points\n0 0 0 0.0 - (2D point, m_id)\n10.0 20.0 50 1.5\n"
    content += "3 - Num of control points\n5 5 10 0\n6 5 20 0\n7 5 30 0\n"
    (tmp_path / "a.vsp").write_text(content)
    found, _ = import_pedestrians(tmp_path / "a.vsp", unit="0.05", rate=25.0)
    assert [len(trajectory.times) for trajectory in found] == [2, 3]
    assert_allclose(found[0].positions, [(0.0, 0.0, 0.0), (0.5, 0.0, -1.0)], atol=1e-12)
    (tmp_path / "a.vsp").write_text(content.rsplit("\n", 2)[0])
    with pytest.raises(TrackError, match=r"a\.vsp:7: ends 1 control points early"):
        import_pedestrians(tmp_path / "a.vsp", unit="0.05", rate=25.0)


@pytest.mark.parametrize(
    ("content", "options", "message"),
    [
        ("1 2 3 4\n2 2 3\n", {}, r"t\.txt:2: has 3 numbers"),
        ("1 2 3 4\n2 2 x 4\n", {}, r"t\.txt:2: 'x' is no number"),
        ("1 2 3 4\n2 2 nan 4\n", {}, r"t\.txt:2: .*not finite"),
        ("id,frame,x,y\nA,1,2,3\nA,2,,3\n", {}, r"t\.txt:3: lacks a number\. add it"),
        ("id,frame,x,y\nA,1,2,3\n,2,2,3\n", {}, r"t\.txt:3: names nobody"),
        ("id,frame,x,y\nA,1,2,3\nA,2,2,3\nA,2,9,9", {}, r"t\.txt:4: person A is in frame 2 twice"),
        ("1 2 3 4\n1 2 3 4e\n", {}, r"people too, unless a header names the columns"),
        ("# nothing\n", {}, "no line of numbers"),
        ("1 2 3\n", {}, r"t\.txt:1: has 3 numbers"),
        ("1 2 0 0\n2 2 1 0\n1 2 5 5\n", {"layout": "eth"}, r"t\.txt:3: person 2 is in frame 1 twice, first in line 1"),
        ("0 1 0 0\n10 1 1 0\n", {"unit": "", "layout": "eth"}, "in which unit"),
        ("0 1 0 0\n10 1 1 0\n", {"rate": 0.0, "layout": "eth"}, "how many frames a second"),
        ("0 1 0 0\n10 1 1 0\n", {"unit": "px", "layout": "eth"}, "'px' is no known unit"),
        ("# id frame x/cm y/cm\n1 0 0 0\n1 10 1 0\n", {"unit": "m"}, "in cm, not m"),
        ("id,frame,x,y\n1,1,0,0,0\n", {}, r"t\.txt:2: has 5 numbers, the header names 4 columns"),
        (
            "0 1 0 0\n1 1 9 0\n2 1 18 0\n",
            {"layout": "eth"},
            r"t\.txt:2: with columns as eth person 1 goes 9 m",
        ),
        ("# framerate: 16\n# id frame x y\n1 0 0 0\n1 10 1 0\n", {"rate": 25.0}, "16 frames a second, not 25"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path, content, options, message):
    (tmp_path / "t.txt").write_text(content)
    with pytest.raises(TrackError, match=message):
        import_pedestrians(tmp_path / "t.txt", **{"unit": "m", "rate": 25.0, **options})
    with pytest.raises(TrackError, match="cannot be read"):
        import_pedestrians(tmp_path / "none.txt", unit="m", rate=25.0)
    (tmp_path / "latin.txt").write_bytes("1 2 3 4\n# Jülich\n2 2 3 4\n".encode("latin-1"))
    with pytest.raises(TrackError, match=r"latin\.txt: is not UTF-8: line 2"):
        import_pedestrians(tmp_path / "latin.txt", unit="m", rate=25.0)


def test_lines_that_say_the_same_again_are_left_out_with_a_warning(tmp_path):
    lines = ["0 1 0 0", "0 2 5 5", "10 1 1 0", "10 2 5 6", "10 1 1 0", "20 1 2 0", "20 2 5 7", "10 1 1 0"]
    (tmp_path / "t.txt").write_text("\n".join(lines))
    found, (problem,) = import_pedestrians(tmp_path / "t.txt", unit="m", rate=10.0, layout="eth")
    assert problem.severity == "warning"
    assert "2 line(s) say again where somebody is, first line 5. they are left out" in problem.message
    assert_allclose([trajectory.times for trajectory in found], [(0.0, 1.0, 2.0)] * 2)
    assert_allclose(found[0].positions[:, 0], [0.0, 1.0, 2.0])


def test_columns_that_could_be_either_are_the_usual_ones_with_a_warning(tmp_path, caplog):
    (tmp_path / "t.txt").write_text("1 1 0 0\n2 1 1 0\n3 1 2 0\n1 2 1 0\n2 2 2 0\n3 2 3 0\n")
    found, _ = import_pedestrians(tmp_path / "t.txt", unit="m", rate=1.0)
    assert [len(trajectory.times) for trajectory in found] == [3, 3]
    assert "name the layout if that is wrong" in caplog.text


def test_people_seen_once_are_reported_and_those_gone_for_long_are_others(tmp_path):
    lines = ["0 1 0 0", "10 1 1 0", "0 2 5 5", "1000 1 9 9", "1010 1 9 8"]
    (tmp_path / "t.txt").write_text("\n".join(lines))
    found, (problem,) = import_pedestrians(tmp_path / "t.txt", unit="m", rate=10.0, layout="eth")
    assert [trajectory.name for trajectory in found] == ["t.txt 1", "t.txt 1 2"]
    assert "t.txt:3: person 2 is seen only once" in problem.message


@pytest.mark.parametrize(
    ("file", "options", "people", "speed"),
    [
        ("crowds_zara01.txt", {"unit": "m", "rate": 25.0}, 148, 1.15),
        ("students001.txt", {"unit": "m", "rate": 25.0}, 415, 0.65),
        ("biwi_hotel.txt", {"unit": "m", "rate": 25.0}, 389, 1.35),
        ("traj_UNI_CORR_500_01.txt", {"unit": "m"}, 148, 1.4),
        ("uo-100-180-180.txt", {"unit": "cm", "rate": 16.0}, 121, 1.2),
    ],
)
def test_real_data_walks_at_human_speed(shared_data, file, options, people, speed):
    found, _ = import_pedestrians(shared_data / "people" / file, **options)
    assert len(found) == people
    speeds = [np.linalg.norm(np.diff(t.positions, axis=0), axis=1).sum() / (t.end - t.start) for t in found]
    assert np.median(speeds) == pytest.approx(speed, rel=0.25)


@pytest.mark.parametrize(
    ("file", "wrong", "options"),
    [
        ("students001.txt", "from line 1 in", {"unit": "m", "rate": 25.0, "layout": "juelich"}),
        ("uo-100-180-180.txt", "columns as eth", {"unit": "cm", "rate": 16.0, "layout": "eth"}),
        ("biwi_hotel.txt", "correct the unit", {"unit": "m", "rate": 2500.0, "layout": "eth"}),
    ],
)
def test_layouts_and_rates_by_which_most_people_outrun_sprinters_are_refused(shared_data, file, wrong, options):
    with pytest.raises(
        TrackError, match=r"faster than people run.*correct the unit, the rate, or the layout"
    ) as raised:
        import_pedestrians(shared_data / "people" / file, **options)
    assert wrong in str(raised.value)
    assert re.search(rf"{file}:\d+: ", str(raised.value))


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_a_unit_that_puts_everybody_into_one_place_is_doubted(shared_data, unit):
    _, problems = import_pedestrians(shared_data / "people/crowds_zara01.txt", unit=unit, rate=25.0)
    assert any("is the unit right?" in problem.message for problem in problems) == (unit == "mm")


def test_who_jumps_is_two_tracks(tmp_path):
    file = tmp_path / "tracks.txt"
    file.write_text("".join(f"{frame} 7 {0.1 * frame + 500.0 * (frame > 4)} 0\n" for frame in range(10)))
    trajectories, problems = import_pedestrians(file, unit="m", rate=10.0, layout="eth")
    assert [(track.name, len(track.times)) for track in trajectories] == [("tracks.txt 7", 5), ("tracks.txt 7 2", 5)]
    (problem,) = problems
    assert "tracks.txt:6: person 7 jumps here, faster than 40 m/s; the track was cut in two" in problem.message
