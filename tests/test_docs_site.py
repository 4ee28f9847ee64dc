"""The site of the documentation: built without a warning, and complete without a network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from html.parser import HTMLParser
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest

import locosweep as ls
from browser import Page, program

pytestmark = [pytest.mark.slow, pytest.mark.whole]

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "docs" / "site" / "build.py"
# Every kind of page there is.
PAGES = (
    "index",
    "size-a-robot",
    "diagnosis",
    "reading-a-report",
    "laws",
    "parameters",
    "gallery/index",
    "gallery/diagnose/paper_gap",
    "api/index",
    "api/locosweep.sweep",
    "api/locosweep.Result",
    "search",
)
_QUIET = 0.15
"""Seconds in which a page asks for what its scripts add."""
browser_needed = pytest.mark.skipif(program() is None, reason="no Chromium on this machine")


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the site that `make docs` has built, or build it."""
    if built := os.environ.get("LOCOSWEEP_SITE"):
        return Path(built)
    out = tmp_path_factory.mktemp("docs") / "site"
    done = subprocess.run(
        [sys.executable, BUILD, "--out", out], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return out


@pytest.fixture(scope="module")
def browser():
    with Page() as page:
        yield page


class Links(HTMLParser):
    """What a page links to, loads, and can be linked by."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.targets: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attributes}
        self.anchors |= {given[key] for key in ("id", "name") if key in given}
        if tag == "a" and "href" in given:
            self.targets.append(given["href"])
        elif tag in {"script", "img", "iframe", "source"} and "src" in given:
            self.loads.append(given["src"])
        elif tag == "link" and given.get("rel") in {"stylesheet", "icon", "preload"}:
            self.loads.append(given["href"])


def dead(site: Path) -> list[str]:
    """Return links and loaded files of all pages that are not there."""
    # Of the theme, _static holds a template.
    files = [page for page in site.rglob("*.html") if "_static" not in page.parts]
    pages = {page: Links(page.read_text("utf-8")) for page in files}
    found = []
    for page, links in pages.items():
        for link in {*links.targets, *links.loads}:
            url = urlparse(link)
            if url.scheme or link in {"", "#"}:
                continue
            target = (page.parent / unquote(url.path)).resolve() if url.path else page
            anchors = pages[target].anchors if target in pages else set()
            # Parts of the search page are those of what is searched for.
            if not target.exists() or (url.fragment and unquote(url.fragment) not in anchors):
                found.append(f"{page.relative_to(site)}: {link}")
    return sorted(found)


def test_every_link_leads_somewhere(site: Path) -> None:
    assert dead(site) == []


def test_planted_dead_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "b.html").write_text('<h1 id="here">b</h1>')
    text = '<a href="b.html#here">1</a><a href="b.html#there">2</a><img src="no.png"><a href="#x">'
    (tmp_path / "a.html").write_text(text)
    assert dead(tmp_path) == ["a.html: #x", "a.html: b.html#there", "a.html: no.png"]


def test_every_public_name_has_a_page(site: Path) -> None:
    for name in set(ls.__all__) - {"__version__"}:
        text = (site / "api" / f"locosweep.{name}.html").read_text("utf-8")
        assert f'id="locosweep.{name}"' in text, name


def test_formulas_are_drawn_by_the_browser_itself(site: Path) -> None:
    for page in ("laws", "effects", "quantities", "parameters"):
        text = (site / f"{page}.html").read_text("utf-8")
        assert text.count("<math") > 20
        assert "\\frac" not in re.sub(r"<code.*?</code>", "", text)


def test_scripts_can_be_taken_along(site: Path) -> None:
    names = [script.stem for script in (ROOT / "examples" / "gallery").glob("*/*.py")]
    files = {file.name: file for file in (site / "_downloads").rglob("*.*")}
    for name in names:
        assert f"{name}.py" in files
        notebook = json.loads(files[f"{name}.ipynb"].read_text("utf-8"))
        assert any(cell["cell_type"] == "code" for cell in notebook["cells"])
    packed = zipfile.ZipFile(files["gallery_jupyter.zip"]).namelist()
    assert {Path(name).stem for name in packed} >= set(names)


def test_every_script_shows_its_picture(site: Path) -> None:
    for page in (site / "gallery").glob("*/*.html"):
        if page.stem not in {"index", "sg_execution_times"}:
            assert "sphx-glr-single-img" in page.read_text("utf-8"), page.name


@browser_needed
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1200, 420])
@pytest.mark.parametrize("page", PAGES)
def test_a_page_needs_nothing_from_elsewhere(
    site: Path, browser: Page, page: str, width: int, dark: bool
) -> None:
    browser.resize(width, 900)
    browser.medium(dark=dark)
    browser.open(site / f"{page}.html")
    browser.wait(_QUIET)
    assert browser.requests
    assert [url for url in browser.requests if not url.startswith(("file:", "data:"))] == []
    assert browser.faults == []
    assert browser.overflow() <= 0


@browser_needed
def test_the_first_page_has_a_live_figure(site: Path, browser: Page) -> None:
    assert "figure-2.html" in Links((site / "index.html").read_text("utf-8")).loads
    browser.open(site / "figure-2.html")
    assert browser.requests == browser.faults == []
    shown = "document.getElementById('sliders').innerText"
    assert "0.5" in browser.run(shown)
    assert "0.3" in browser.run(shown)
    picture = "document.querySelector('canvas').toDataURL()"
    before = browser.run(picture)
    browser.run("""(() => { const s = document.querySelector('#sliders input'); s.value = 2;
                s.dispatchEvent(new Event('input')); })()""")
    browser.wait(_QUIET)
    assert browser.run(picture) != before


@browser_needed
def test_the_search_finds_without_a_network(site: Path, browser: Page) -> None:
    browser.open(site / "search.html", "?q=heatmap")
    browser.wait(1.5)
    assert browser.run("document.querySelectorAll('#search-results li').length") > 2
    assert browser.faults == []


@browser_needed
def test_planted_requests_and_faults_are_seen(tmp_path: Path, browser: Page) -> None:
    page = tmp_path / "page.html"
    wide = "<div style='width:2000px'>x</div>"
    page.write_text(f"<img src='https://example.org/a.png'><script>no()</script>{wide}")
    browser.resize(420, 900)
    browser.open(page)
    browser.wait(_QUIET)
    assert "https://example.org/a.png" in browser.requests
    assert any("no is not defined" in fault for fault in browser.faults)
    assert browser.overflow() > 1000


@browser_needed
@pytest.mark.skipif(find_spec("axe_core_python") is None, reason="axe-core-python is not installed")
@pytest.mark.parametrize("page", [*PAGES, "figure-2"])
def test_a_page_is_accessible(site: Path, browser: Page, page: str) -> None:
    assert serious(browser, site / f"{page}.html") == []


@browser_needed
@pytest.mark.skipif(find_spec("axe_core_python") is None, reason="axe-core-python is not installed")
@pytest.mark.parametrize("page", ["index", "diagnosis", "gallery/index", "api/locosweep.sweep"])
def test_a_page_can_be_read_in_the_dark(site: Path, browser: Page, page: str) -> None:
    assert serious(browser, site / f"{page}.html", dark=True, only="color-contrast") == []


@browser_needed
@pytest.mark.skipif(find_spec("axe_core_python") is None, reason="axe-core-python is not installed")
def test_planted_barriers_are_found(tmp_path: Path, browser: Page) -> None:
    page = tmp_path / "page.html"
    page.write_text(
        "<html><body><img src='data:,'><p style='color:#eee;background:#fff'>pale words</p>"
    )
    found = {name for name, _ in serious(browser, page)}
    assert found >= {"image-alt", "color-contrast"}


def serious(
    browser: Page, page: Path, *, dark: bool = False, only: str | None = None
) -> list[tuple[str, str]]:
    """Return what axe-core finds that keeps readers from a page: rule and first element."""
    axe = (resources.files("axe_core_python") / "axe.min.js").read_text("utf-8")
    browser.resize(1200, 900)
    browser.medium(dark=dark)
    browser.open(page)
    # Colours glide from those of the theme before.
    browser.wait(0.6)
    browser.run(f"{axe};0")
    # A page opened from a disk may not look into a frame; what is shown there is a page of its own.
    rules = json.dumps({"iframes": False} | ({"runOnly": [only]} if only else {}))
    found = browser.run(f"axe.run({rules}).then(r => r.violations.map(v => "
                        "[v.impact, v.id, v.nodes[0].html]))")  # fmt: skip
    return [(rule, html) for impact, rule, html in found if impact in {"serious", "critical"}]
