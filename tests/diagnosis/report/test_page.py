"""The page: complete, closed in itself, and safe against what files say."""

import copy
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

import locosweep as ls
from diagnosis_case import EFFECTS, HOSTILE, made
from locosweep.diagnosis.report.figures import FILES, pictures
from locosweep.diagnosis.report.page import (
    _BESIDE,
    HEADLINES,
    _line,
    _model,
    _sure,
    page,
    short,
)
from locosweep.diagnosis.report.written import number, percent
from locosweep.plot.explorer.page import digest_of


class Reader(HTMLParser):
    """Tags, attributes and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data


class TestPage:
    def test_carries_everything_itself(self, saved):
        text = (saved / "report.html").read_text()
        assert len(text) < 1_500_000
        tags = Reader(text).tags
        assert not {tag for tag, _ in tags} & {"link", "iframe", "object", "base", "form"}
        # One script, its own, which the policy names; the others are data.
        scripts = re.findall(r"<script(.*?)>(.*?)</script>", text, re.S)
        assert [kind for kind, _ in scripts] == [
            ' type="application/json" id="curves-data"',
            ' type="text/plain" id="curves-numbers"',
            "",
        ]  # fmt: skip
        assert f"script-src 'sha256-{digest_of(scripts[-1][1])}'" in text
        links = [a.get("src") or a.get("href") for _, a in tags if "src" in a or "href" in a]
        assert all(one.startswith(("data:image/png;base64,", "#")) for one in links)
        assert "url(" not in text
        assert "@import" not in text
        images = [a for tag, a in tags if tag == "img"]
        assert len(images) == len(FILES) - len(_BESIDE)
        assert all(a["alt"] for a in images)
        ids = {a["id"] for _, a in tags if "id" in a}
        assert {one[1:] for one in links if one.startswith("#")} <= ids

    def test_says_it_all(self, found, saved):
        text = " ".join(Reader((saved / "report.html").read_text()).text.split())
        for part in (found.summary, "What to do: give the model", "0.97", "lubricant buildup",
                     "k_b", "N/m",
                     "the head never moves backward", *found.warnings,
                     found.provenance["runs_sha256"], "surface.mu_coulomb"):  # fmt: skip
            assert part in text, part

    def test_says_how_it_was_made(self, found):
        given = found.provenance | {
            "runs_file": "log.csv", "nominal_file": "rig.toml",
            "options": {"holdout": ["2"], "max_effects": 2, "columns": {}, "units": {"x": "mm"}},
            "largest_rest": {"channel": "x", "samples": 256, "deviations": -1.0161692},
            "start_speed_free": [],
        }  # fmt: skip
        one = replace(found, report=found.report | {"provenance": given},
                      details=found.details | {"made": "2026-11-25"})  # fmt: skip
        text = " ".join(Reader(page(one, {}, "locosweep diagnose log.csv")).text.split())
        for part in ("on 2026-11-25", "locosweep diagnose log.csv", "log.csv, SHA-256",
                     "rig.toml, SHA-256", "runs kept from the fit on request",
                     "most effects at once", "units of the file", "x mm",
                     "means over 256 samples of x, −1 standard deviations off"):  # fmt: skip
            assert part in text, part
        assert "start speed free" not in text
        assert "1.0161692" not in text
        # The probability stands once, in the summary.
        assert "Probability that this verdict" not in text

    def test_a_rig_that_turns_has_its_units(self, found):
        bench = ls.Robot({"mass": 0.1473, "gravity": 9.81},
                         {"bench.kind": "rotary", "sensor.position_noise": 0.002,
                          "bench.gravity_torque": 3.0, "surface.coulomb_force": 0.288})  # fmt: skip
        rows = {key: unit for key, _, unit in _model(replace(found, nominal=bench))}
        assert rows == {
            "robot.mass": "kg m²", "robot.gravity": "m/s²", "bench.kind": "",
            "sensor.position_noise": "rad", "bench.gravity_torque": "N m",
            "surface.coulomb_force": "N m",
        }  # fmt: skip

    def test_what_comes_nearest_is_shown_where_nothing_explains(self, found):
        report = copy.deepcopy(found.report)
        report["verdict"] |= {"status": "unexplained", "effects": []}
        text = Reader(page(replace(found, report=report), {})).text
        assert "k_b" in text
        assert "they are no result" in text
        assert "What to do" not in text

    def test_a_phone_scrolls_tables_and_not_the_page(self, saved):
        text = (saved / "report.html").read_text()
        assert re.search(r"table {[^}]*display: block; max-width: 100%; overflow-x: auto", text)

    def test_text_of_files_stays_text(self, hostile):
        text = page(hostile, {})
        read = Reader(text)
        assert [tag for tag, _ in read.tags].count("script") == 3
        assert "<script>alert" not in text
        assert not any("onload" in attributes for _, attributes in read.tags)
        assert HOSTILE[0] in read.text
        assert "\u202e" not in text
        assert "\u0007" not in text

    @pytest.mark.whole
    @pytest.mark.parametrize("status", ["none", "unexplained", "ambiguous"])
    def test_other_verdicts(self, tmp_path, status):
        effects = EFFECTS if status == "ambiguous" else {}
        one = made(tmp_path, effects=effects)
        one.report["verdict"]["status"] = status
        if status == "ambiguous":
            one.report["verdict"]["equivalent"] = [["lubricant_buildup", "quadratic_drag"]]
            one.report["next_experiment"] = {"separates": [["lubricant_buildup", "quadratic_drag"]],
                                             "suggestion": "a slower run"}  # fmt: skip
        else:
            # What an engine may leave open.
            one.report["gap"] |= {"before": None, "after": None, "noise_floor": None,
                                  "shrink": None, "horizons": [], "channel": None}  # fmt: skip
            one.report["where"] |= {"windows": [], "origin": [], "channels": [], "regimes": []}
            one.report["candidates"] = []
        for figure in pictures(one).values():
            figure.draw_without_rendering()
        text = Reader(page(one, {})).text
        words = {"none": "No gap beyond the noise", "unexplained": "no known effect",
                 "ambiguous": "cannot tell it from quadratic drag"}  # fmt: skip
        assert words[status] in text


class TestFilters:
    """How the page writes numbers."""

    @pytest.mark.parametrize(
        ("value", "shown"),
        [(0.97, "97 %"), (0.9995, "100.0 %"), (0.9949, "99.5 %"), (0.0042, "0.4 %"), (1.0, "100 %"),
         (-0.2, "−20 %"), (None, "unknown"), (float("nan"), "unknown")],
    )  # fmt: skip
    def testpercent(self, value, shown):
        assert percent(value) == shown

    def test_numbers(self):
        assert number(-0.012345) == "−0.0123"
        assert number(1234.5, 6) == "1234.5"
        assert number(None) == number(float("inf")) == "unknown"

    @pytest.mark.parametrize(
        ("value", "shown"), [(0.0004, "< 0.001"), (0.25, "0.25"), (0.9994, "> 0.999")]
    )
    def test_probabilities(self, value, shown):
        assert _sure(value) == shown

    def test_provenance_is_one_line(self):
        assert _line({"largest_rest": [1, None], "b": {}}) == "largest rest 1, unknown, b none"


@pytest.mark.whole
def test_a_few_lines_for_notebooks(found, hostile):
    assert short(found).startswith(f"<div><strong>{HEADLINES['explained']}</strong>")
    assert "0.97" in short(found)
    assert all(f"<li>{warning}" in short(found).replace("&#39;", "'") for warning in found.warnings)
    assert "<script" not in short(hostile)
    assert "data:image/png;base64," in short(found)
    assert len(short(found)) < 200_000
