"""The explorer in a browser: offline, quick, narrow, dark, on paper, by keys and by pointer."""

import json

import numpy as np
import pytest

import locosweep as ls
from browser import Page, program

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(program() is None, reason="no Chromium on this machine"),
]
_SLIDER_MS = 50
"""From a slider to the picture, as asked for; measured: 10 to 17."""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    r = ls.sweep(["mean_velocity", "best_segments"], mu_static=np.linspace(0.1, 1, 60),
                 slope_deg=np.linspace(0, 25, 50), segments=range(2, 9), mu_coulomb=0.3,
                 drive_limit=[0.5, 1.0, float("inf")])  # fmt: skip
    file = tmp_path_factory.mktemp("page") / "page.html"
    r.explore().save(file)
    return file


@pytest.fixture(scope="module")
def browser():
    with Page() as page:
        yield page


@pytest.fixture
def page(browser, file):
    return browser.afresh(file)


def text(page, name):
    return page.run(f"document.getElementById('{name}').textContent")


def value(page, name):
    return page.run(f"document.getElementById('{name}').value")


def pick(page, name, chosen):
    page.run(f"""(() => {{ const s = document.getElementById('{name}'); s.value = '{chosen}';
             s.dispatchEvent(new Event('change')); }})()""")


def test_opens_from_a_file_without_network_or_fault(page):
    assert page.requests == []
    assert page.faults == []
    assert page.overflow() <= 0
    assert page.run("document.querySelectorAll('#sliders input').length") == 2


def test_a_slider_moves_the_picture_at_once(page):
    before = page.ink("map")
    times = page.run("""(() => { const s = document.querySelector('#sliders input'); const out = [];
      for (let i = 0; i < 20; i++) { s.value = i % (Number(s.max) + 1); const t = performance.now();
        s.dispatchEvent(new Event('input'));
        document.getElementById('map').getContext('2d').getImageData(0, 0, 1, 1);
        out.push(performance.now() - t); } return out; })()""")
    assert sorted(times)[len(times) // 2] < _SLIDER_MS
    assert page.ink("map") != before


def test_the_pointer_reads_values_and_reasons(page):
    steep = ls.sweep("mean_velocity", mu_static=0.1, slope_deg=25.0, segments=4, mu_coulomb=0.3)
    page.run("""(() => { const s = document.querySelectorAll('#sliders input');
      s[0].value = 2; s[1].value = 2;
      s.forEach(one => one.dispatchEvent(new Event('input'))); })()""")
    box = json.loads(
        page.run("JSON.stringify(document.getElementById('map').getBoundingClientRect())")
    )
    low = box["y"] + box["height"] - 50
    page.mouse("mouseMoved", box["x"] + box["width"] - 100, low)
    said = text(page, "readout")
    assert "slope of the ground 25 deg, static friction coefficient of the anchors 0.1" in said
    assert f"no value: {ls.Status(int(steep.status)).sentence}" in said
    page.click(box["x"] + 70, box["y"] + 15)
    shown = text(page, "readout")
    assert "slope of the ground 0 deg, static friction coefficient of the anchors 1:" in shown
    cell = value(page, "cell")
    assert cell.startswith('import numpy as np, locosweep as ls\nls.sweep("mean_velocity", ')
    found = eval(cell.partition("\n")[2], {"ls": ls, "np": np})  # noqa: S307
    assert f"mean velocity {float(found.values):.4g} m/s" in shown
    page.mouse("mouseMoved", 5, 5)
    assert text(page, "readout") == shown


def test_keys_alone_reach_all(page):
    page.run("document.getElementById('map').focus()")
    for name in ("ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown"):
        before = text(page, "readout")
        page.key(name)
        assert text(page, "readout") != before
    page.key("Enter")
    assert value(page, "cell")
    page.key("Escape")
    assert page.run("document.getElementById('cell').parentElement.hidden")


def test_axes_change_places_and_the_commands_follow(page):
    x, y = value(page, "x"), value(page, "y")
    shell = value(page, "shell")
    pick(page, "x", y)
    assert (value(page, "x"), value(page, "y")) == (y, x)
    assert value(page, "shell") != shell
    pick(page, "output", "1")
    assert value(page, "shell").startswith("locosweep heatmap best_segments ")
    assert page.run("document.getElementById('best').hidden")
    assert "drive_limit=" in value(page, "python")


@pytest.mark.parametrize("dark", [False, True])
def test_text_stands_out_from_its_ground(page, dark):
    page.medium(dark=dark)
    assert page.contrast() > 4.5


def test_every_control_has_a_name(page):
    assert page.run("""[...document.querySelectorAll('input, select, textarea')]
      .filter(e => !e.closest('[hidden]'))
      .every(e => e.labels.length && e.labels[0].textContent.trim())""")
    assert page.run("document.getElementById('map').getAttribute('aria-label')")


def test_a_phone_does_not_scroll_sideways(page):
    page.resize(420, 900)
    page.run("new Promise(done => setTimeout(done, 100))")
    assert page.overflow() <= 0
    assert page.run("document.getElementById('map').clientWidth") <= 420


def test_paper_is_white_and_ink_dark_from_a_dark_screen(page, tmp_path):
    page.medium(dark=True)
    page.run("""window.addEventListener('beforeprint', () => { window.paper =
      getComputedStyle(document.documentElement).getPropertyValue('--text'); })""")
    page.print_to(tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
    assert page.run("window.paper").strip() == "#1a1a1a"
    assert page.run("document.documentElement.className") == ""


def test_a_sweep_of_one_axis_is_a_strip(browser, tmp_path):
    r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3, segments=range(2, 9))
    r.explore().save(tmp_path / "one.html")
    browser.open(tmp_path / "one.html")
    assert browser.faults == []
    assert "0.08735 m/s at number of segments of the robot 3" in text(browser, "highest")
    assert value(browser, "python").endswith('.plot.curves("segments")')
