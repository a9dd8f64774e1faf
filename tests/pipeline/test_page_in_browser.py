"""The page in a real browser: it loads without a complaint or a request, plays, filters, and bears 1,000 agents."""

from dataclasses import replace

import numpy as np
import pytest

from tests.browser import Browser, find_program
from tests.writers.pages import crowd_of, walker
from usdfoot.pipeline.page import picture_crowd
from usdfoot.writers.page.document import write_document

pytestmark = pytest.mark.skipif(
    find_program() is None, reason="needs Chromium or Chrome; Debian: apt-get install chromium"
)

MANY = 1000
FRAMES = 120


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with Browser(tmp_path_factory.mktemp("browser"), size=(1000, 700)) as opened:
        yield opened


@pytest.fixture(scope="module")
def picture(stones):
    return picture_crowd(stones.crowd_file)[0]


@pytest.fixture(scope="module")
def page(picture, tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "report.html"
    write_document(file, picture)
    return file


@pytest.fixture
def opened(browser, page):
    """The stepping stones' page, just loaded; whatever a test does, nobody complains."""
    browser.open(page)
    yield browser
    assert browser.complaints == [] and browser.requests == []


def click(browser, selector, number=0):
    browser.run(f"document.querySelectorAll({selector!r})[{number}].click()")


def rows(browser, table):
    """Texts of the rows in sight."""
    return browser.run(f"[...document.querySelectorAll('#{table} .inner .row')].map((row) => row.innerText)")


def test_it_shows_the_crowd(opened, picture):
    assert opened.run("document.title") == f"{picture.title} - usdfoot"
    assert "figures" in opened.run("document.getElementById('verdict').textContent")
    assert opened.run("document.querySelectorAll('#view canvas').length") == 1
    assert len(rows(opened, "agents")) == 1 and len(rows(opened, "steps")) > 10
    canvases = opened.run(
        "[...document.querySelectorAll('#plan canvas, #lines canvas, .histogram:not([hidden]) canvas')]"
        ".map((canvas) => { const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);"
        "return new Set(new Uint32Array(data.buffer)).size; })"
    )
    assert len(canvases) > 15 and min(canvases) > 3  # colors in each drawing


def test_stick_figures_are_where_the_picture_has_them(opened, picture):
    agent = picture.agents[0]
    frame = len(agent.times) // 2
    joints = opened.run(
        f"""(() => {{
          const {{ crowd }} = usdfoot, agent = crowd.agents[0], out = [];
          const place = page.crowd.frameAt(crowd, agent, {agent.times[frame] - agent.times[0]} + 1e-9);
          page.crowd.jointsAt(crowd, agent, place, page.crowd.rootAt(crowd, agent, place, []), out, 0);
          return out.map((value, i) => value + crowd.header.origin[i % 3]);
        }})()"""
    )
    np.testing.assert_allclose(np.reshape(joints, (-1, 3)), agent.joints[frame], atol=0.0011)


def test_it_plays_stops_and_goes_round(opened):
    click(opened, "#player button.main")
    opened.wait("usdfoot.state.time > 0.2 && usdfoot.view.frames > 3")
    assert opened.run("Number(document.querySelector('#player input[type=range]').value)") > 0.0
    opened.run("usdfoot.state.set({ time: usdfoot.crowd.duration - 0.01 })")
    opened.wait("usdfoot.state.time < usdfoot.crowd.duration - 0.02")
    click(opened, "#player button.main")
    still = opened.run("new Promise((done) => setTimeout(() => done(usdfoot.state.time), 100))")
    assert opened.run("usdfoot.state.time") == still


def test_the_worst_step_is_first_and_a_click_goes_there(opened, picture):
    severity = opened.run("[...usdfoot.crowd.stepSeverity]")
    worst = int(np.argmax(severity))
    click(opened, "#steps .inner .row")
    plan = picture.agents[0].plan
    middle = 0.5 * (plan.strike_times[worst] + plan.liftoff_times[worst]) - picture.agents[0].times[0]
    assert opened.run("usdfoot.state.step") == worst
    assert opened.run("usdfoot.state.time") == pytest.approx(middle, abs=1e-4)
    assert f"footstep {worst}" in opened.run("document.getElementById('agentHead').innerText")


def test_a_heading_sorts(opened):
    titles = opened.run("[...document.querySelectorAll('#steps .head button')].map((button) => button.innerText)")
    strike = next(i for i, title in enumerate(titles) if "strike" in title)
    for descending in (True, False):
        click(opened, "#steps .head button", strike)
        times = [float(text.split("\n")[strike]) for text in rows(opened, "steps")]
        assert times == sorted(times, reverse=descending) and len(set(times)) > 10


def test_light_and_dark(opened):
    colors = set()
    for _ in range(2):
        click(opened, "#theme")
        colors.add(opened.run("getComputedStyle(document.body).backgroundColor"))
    assert len(colors) == 2


def test_a_thousand_agents_stay_usable(browser, picture, tmp_path):
    """Page size, rows that exist, drawing and filtering; copies of one agent, ten metres apart."""
    model = picture.agents[0]
    frames = np.resize(np.arange(len(model.times)), FRAMES)

    def copy(number):
        shift = np.array([number % 40, 0.0, number // 40]) * 10.0
        return replace(
            model,
            name=f"Agent_{number}",
            plan=replace(model.plan, positions=model.plan.positions + shift),
            stood=model.stood + shift,
            times=model.times[0] + picture.frame_time * np.arange(FRAMES),
            roots=model.roots[frames] + shift,
            joints=model.joints[frames] + shift,
            sole_heights=model.sole_heights[frames],
        )

    file = tmp_path / "many.html"
    write_document(file, replace(picture, agents=tuple(copy(number) for number in range(MANY))))
    assert file.stat().st_size < 20e6
    browser.open(file)
    assert browser.run("usdfoot.crowd.agents.length") == MANY
    assert len(rows(browser, "agents")) < 100 and len(rows(browser, "steps")) < 100
    click(browser, "#player button.main")
    browser.wait("usdfoot.view.frames > 2 && usdfoot.state.time > 0")
    click(browser, "#player button.main")
    browser.run(
        "{ const box = document.querySelector('#agents input'); box.value = 'agent_99?';"
        "box.dispatchEvent(new Event('input')); }"
    )
    assert {row.split("\n")[0] for row in rows(browser, "agents")} == {f"Agent_99{i}" for i in range(10)}
    assert browser.run("usdfoot.state.shown.reduce((sum, value) => sum + value)") == 10
    steps = len(model.plan)
    assert browser.run("document.querySelector('#steps h2 .hint').textContent") == f"{10 * steps} of {MANY * steps}"
    click(browser, "#agents .inner .row", 3)
    assert browser.run("usdfoot.crowd.agents[usdfoot.state.agent].name") in {f"Agent_99{i}" for i in range(10)}
    assert browser.complaints == [] and browser.requests == []


def test_a_click_in_the_view_chooses_who_is_there(browser, tmp_path):
    file = tmp_path / "three.html"
    write_document(file, crowd_of(*(walker(f"Agent_{i}", x=3.0 * i) for i in range(3))))
    browser.open(file)
    for number in (2, 0, 1):
        x, y = browser.run(
            f"""(async () => {{
              const {{ crowd, state, view }} = usdfoot, frames = view.frames;
              while (view.frames === frames) {{ view.draw(); await new Promise(requestAnimationFrame); }}
              const box = document.querySelector("#view canvas").getBoundingClientRect();
              const [x, y] = view.pixel(page.view.pelvis(crowd, crowd.agents[{number}], state.time));
              return [box.left + x, box.top + y];
            }})()"""
        )
        for kind in ("mousePressed", "mouseReleased"):
            browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        assert browser.run("usdfoot.state.agent") == number
    assert browser.complaints == [] and browser.requests == []


def test_states_filter_and_nothing_of_the_scene_runs(browser, tmp_path):
    evil = "</script><img src=x onerror='window.hacked=1'><script>window.hacked=1</script>"
    agents = [walker("Good", x=3.0), walker(evil, status=("ok", "ikLimited", "ok", evil))]
    crowd = crowd_of(*agents, title=evil, problems=(evil,), notes=(evil,), facts={evil: evil})
    file = tmp_path / "evil.html"
    write_document(file, crowd)
    browser.open(file)
    for step in range(4):
        browser.run(f"usdfoot.state.chooseStep(4 + {step})")
    assert browser.run("typeof window.hacked") == "undefined"
    assert browser.run("document.querySelectorAll('img').length") == 0
    assert evil in browser.run("document.getElementById('agents').innerText")
    options = browser.run("[...document.querySelectorAll('#agents option')].map((option) => option.value)")
    shown = {}
    for option in options:
        browser.run(
            f"{{ const choice = document.querySelector('#agents select'); choice.value = {option!r};"
            "choice.dispatchEvent(new Event('change')); }"
        )
        shown[option] = browser.run("[...usdfoot.state.shown]")
    # ok, ikLimited and the evil status occur; both agents have a step over its target.
    assert shown == {
        "all": [1, 1],
        "over": [1, 1],
        "unpromised": [0, 1],
        "status 0": [1, 1],
        "status 3": [0, 1],
        "status 6": [0, 1],
    }
    assert browser.complaints == [] and browser.requests == []
