"""The report in a browser: offline, narrow, dark, on paper; curves that zoom and answer."""

import json

import pytest

from browser import Page, program

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(program() is None, reason="no Chromium on this machine"),
]


@pytest.fixture(scope="module")
def browser():
    with Page() as page:
        yield page


@pytest.fixture
def page(browser, saved):
    return browser.afresh(saved / "report.html")


def changes(page, act):
    """Whether the picture changes with an act."""
    before = page.ink("curves")
    act()
    return page.ink("curves") != before


def readout(page):
    return page.run("document.getElementById('curves-readout').textContent")


def click(page, name):
    page.run(f"document.getElementById('{name}').click()")


def test_opens_without_network_or_fault(page):
    assert page.requests == []
    assert page.faults == []
    assert page.overflow() <= 0
    assert page.run("document.getElementById('curves-run').selectedOptions[0].textContent"
                    ) == "3, kept from the fit"  # fmt: skip


def test_each_line_has_a_switch(page):
    labels = page.run("[...document.querySelectorAll('#curves-switches label')]"
                      ".map(one => one.textContent.trim())")  # fmt: skip
    assert labels == ["measured", "nominal model", "with lubricant buildup"]
    for k in range(3):
        box = f"document.querySelectorAll('#curves-switches input')[{k}].click()"
        assert changes(page, lambda box=box: page.run(box))


def test_the_pointer_reads_values_with_units(page, found):
    box = json.loads(
        page.run("""(() => { const c = document.getElementById('curves');
      c.scrollIntoView({block: 'center'});
      return JSON.stringify(c.getBoundingClientRect()); })()""")
    )
    page.mouse("mouseMoved", box["x"] + box["width"] / 2, box["y"] + box["height"] / 3)
    said = readout(page)
    assert said.startswith("t = 1.")
    for part in ("measured ", "nominal model ", "with lubricant buildup ", "(error ", " m"):
        assert part in said, part
    # Dragging over a part enlarges it.
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 3
    page.mouse("mousePressed", x, y, "left")
    page.mouse("mouseMoved", x + 120, y, "left")
    page.mouse("mouseReleased", x + 120, y, "left")
    page.mouse("mouseMoved", box["x"] + box["width"] - 12, y)
    assert float(readout(page).split()[2]) < float(found.traces[3].t[-1]) - 0.5
    click(page, "curves-all")
    page.mouse("mouseMoved", box["x"] + box["width"] - 10, y)
    assert float(readout(page).split()[2]) > float(found.traces[3].t[-1]) - 0.1


def test_keys_and_buttons_zoom(page):
    page.run("document.getElementById('curves').focus()")
    page.key("ArrowRight")
    first = readout(page)
    page.key("ArrowRight")
    assert readout(page) != first
    assert changes(page, lambda: click(page, "curves-in"))
    assert changes(page, lambda: page.key("0"))
    for _ in range(30):
        click(page, "curves-in")
    assert page.faults == []
    assert changes(page, lambda: click(page, "curves-all"))


def test_runs_and_readings_are_picked(page):
    def pick(name, value):
        page.run(f"""(() => {{ const s = document.getElementById('{name}'); s.value = '{value}';
                 s.dispatchEvent(new Event('change')); }})()""")

    assert changes(page, lambda: pick("curves-run", 0))
    assert changes(page, lambda: pick("curves-channel", "force"))
    assert page.run("document.getElementById('curves-channel').value") == "force"
    pick("curves-run", 1)
    assert page.run("document.getElementById('curves-channel').value") == "force"


@pytest.mark.parametrize("dark", [False, True])
def test_text_stands_out_from_its_ground(page, dark):
    page.medium(dark=dark)
    assert page.contrast() > 4.5


def test_a_phone_does_not_scroll_sideways(page):
    page.resize(420, 900)
    page.run("new Promise(done => setTimeout(done, 100))")
    assert page.overflow() <= 0


def test_paper_is_white_from_a_dark_screen(page, tmp_path):
    page.medium(dark=True)
    page.run("""window.addEventListener('beforeprint', () => { window.paper =
      getComputedStyle(document.documentElement).getPropertyValue('--paper'); })""")
    page.print_to(tmp_path / "page.pdf")
    assert page.run("window.paper").strip() == "#fff"


def test_names_from_files_stay_text(browser, hostile, tmp_path):
    out = tmp_path / "report"
    hostile.save(out)
    browser.open(out / "report.html")
    assert browser.faults == []
    assert browser.run("document.getElementById('curves-run').options[0].textContent").startswith(
        "<script>alert(1)</script>"
    )
