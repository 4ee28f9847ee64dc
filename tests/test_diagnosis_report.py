"""What a diagnosis leaves behind: report.json, the page, pictures, the augmented model."""

import json
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from matplotlib.figure import Figure

import locosweep as ls
from diagnosis_case import EFFECTS, NOMINAL, made
from locosweep.cli import main
from locosweep.diagnosis import Diagnosis
from locosweep.diagnosis.report.figures import (
    FILES,
    channel_over_time,
    pictures,
    residual_over_time,
)
from locosweep.diagnosis.report.figures_localization import _joined
from locosweep.diagnosis.report.figures_style import Channel, label
from locosweep.diagnosis.report.model_file import write_augmented
from locosweep.diagnosis.report.page import page
from locosweep.diagnosis.report.result import report_text
from locosweep.errors import InputError
from locosweep.files import folder
from locosweep.files.robot import Robot

HOSTILE = ("<script>alert(1)</script>", "$x_{", 'a" onload="x', "\u202eevil\u0007 & <b>日本")


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Diagnosis:
    return made(tmp_path_factory.mktemp("case"))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory) -> Diagnosis:
    return made(tmp_path_factory.mktemp("hostile"), labels=HOSTILE)


@pytest.fixture(scope="module")
def saved(found, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("saved") / "new" / "report"
    found.save(out)
    return out


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


class TestSave:
    def test_everything_is_there_and_nothing_else(self, saved):
        names = {"report.json", "report.html", "augmented.toml", *FILES}
        assert {path.name for path in saved.iterdir()} == names
        assert {path.name for path in saved.parent.iterdir()} == {"report"}

    def test_same_bytes_again(self, found, saved, tmp_path):
        found.save(tmp_path / "again")
        for path in saved.iterdir():
            assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name

    def test_report_is_the_one_given(self, found, saved):
        assert json.loads((saved / "report.json").read_text()) == found.report

    def test_full_folder_is_refused_and_kept(self, found, tmp_path):
        (tmp_path / "mine.txt").write_text("mine")
        with pytest.raises(InputError, match="is not empty"):
            found.save(tmp_path)
        assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]

    def test_force_replaces_own_files_only(self, tmp_path):
        none = made(tmp_path, effects={})
        (tmp_path / "out").mkdir()
        for name in ("mine.txt", "parameters.png", "report.json"):
            (tmp_path / "out" / name).write_text("old")
        none.save(tmp_path / "out", force=True)
        # Without effects there are no parameters: the old picture must not stay.
        there = {path.name for path in (tmp_path / "out").iterdir()}
        assert "parameters.png" not in there
        assert (tmp_path / "out" / "mine.txt").read_text() == "old"
        assert json.loads((tmp_path / "out" / "report.json").read_text())

    @pytest.mark.parametrize("force", [False, True])
    def test_a_fault_on_the_way_leaves_nothing(self, found, tmp_path, monkeypatch, force):
        def broken(*_):
            raise RuntimeError("in between")

        out = tmp_path / "out"
        if force:
            out.mkdir()
            (out / "report.json").write_text("old")
        monkeypatch.setattr("locosweep.diagnosis.report.figures.pictures", broken)
        with pytest.raises(RuntimeError, match="in between"):
            found.save(out, force=force)
        left = [path.name for path in tmp_path.rglob("*")]
        assert left == (["out", "report.json"] if force else [])

    def test_places_that_cannot_be(self, tmp_path):
        (tmp_path / "file").write_text("")
        for place in (tmp_path / "file", tmp_path / "file" / "below"):
            with pytest.raises(InputError, match=re.escape(str(place))):
                folder.check_folder(place)
        with pytest.raises(InputError, match="NUL"):
            folder.check_folder("a\0b")


class TestReport:
    def test_numbers_that_json_has_not_become_null(self):
        text = report_text(
            {"a": np.float64("nan"), "b": [np.inf, np.int64(3)], "c": np.arange(2.0)}
        )
        assert json.loads(text) == {"a": None, "b": [None, 3], "c": [0.0, 1.0]}

    def test_attributes_are_the_report(self, found):
        verdict = found.report["verdict"]
        assert found.status == verdict["status"] == "explained"
        assert found.effects == list(EFFECTS)
        for name in ("gap", "where", "candidates", "not_visible", "next_experiment", "warnings",
                     "provenance"):  # fmt: skip
            assert getattr(found, name) == found.report[name]
        for name in ("probability", "equivalent", "alternatives", "law_mismatch", "summary"):
            assert getattr(found, name) == verdict[name]

    def test_in_short(self, found, hostile):
        assert "explained" in repr(found)
        assert found.summary in repr(found)
        assert "<script>" not in hostile._repr_html_()

    @pytest.mark.skipif("LOCOSWEEP_DATA" not in os.environ, reason="LOCOSWEEP_DATA is not set")
    def test_the_case_of_these_tests_has_the_form_of_reports(self, found, hostile, tmp_path):
        file = Path(os.environ["LOCOSWEEP_DATA"]) / "contracts" / "report.schema.json"
        schema = json.loads(file.read_text())
        for one in (found, hostile, made(tmp_path, effects={})):
            jsonschema.validate(json.loads(report_text(one.report)), schema)


class TestPage:
    def test_carries_everything_itself(self, saved):
        text = (saved / "report.html").read_text()
        assert len(text) < 5_000_000
        tags = Reader(text).tags
        assert not {tag for tag, _ in tags} & {"script", "link", "iframe", "object", "base", "form"}
        links = [a.get("src") or a.get("href") for _, a in tags if "src" in a or "href" in a]
        assert all(one.startswith(("data:image/png;base64,", "#")) for one in links)
        assert "url(" not in text
        assert "@import" not in text
        images = [a for tag, a in tags if tag == "img"]
        assert len(images) == len(FILES)
        assert all(a["alt"] for a in images)
        ids = {a["id"] for _, a in tags if "id" in a}
        assert {one[1:] for one in links if one.startswith("#")} <= ids

    def test_says_it_all(self, found, saved):
        text = " ".join(Reader((saved / "report.html").read_text()).text.split())
        for part in (found.summary, "97 %", "lubricant buildup", "k_b", "N/m",
                     "the head never moves backward", *found.warnings,
                     found.provenance["runs_sha256"], "surface.mu_coulomb"):  # fmt: skip
            assert part in text, part

    def test_text_of_files_stays_text(self, hostile):
        text = page(hostile, {})
        read = Reader(text)
        assert "script" not in {tag for tag, _ in read.tags}
        assert not any("onload" in attributes for _, attributes in read.tags)
        assert HOSTILE[0] in read.text
        assert "\u202e" not in text
        assert "\u0007" not in text

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


class TestPictures:
    def test_axes_have_words_and_units(self, found):
        for name, figure in pictures(found).items():
            for ax in figure.axes:
                if not ax.get_visible() or not ax.xaxis.get_visible():
                    continue
                text = ax.get_xlabel() + ax.get_ylabel()
                assert text, name
            labels = " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in figure.axes)
            assert "[" in labels, name

    def test_labels_of_files_are_drawn_as_they_are(self, hostile):
        for figure in pictures(hostile).values():
            figure.draw_without_rendering()

    def test_curves_are_the_data(self, found):
        trace = found.traces[0]
        ax = channel_over_time(found, trace, "x", Figure().subplots())
        assert [line.get_label() for line in ax.lines] == ["measured", "nominal model",
                                                           "augmented model"]  # fmt: skip
        unit = 1e3 if "[mm]" in ax.get_ylabel() else 1.0
        np.testing.assert_allclose(ax.lines[0].get_ydata(), unit * trace.measured["x"])
        np.testing.assert_allclose(ax.lines[1].get_ydata(), unit * trace.nominal["x"])
        after = residual_over_time(found, trace, Figure().subplots(), after=True)
        assert "[µm]" in after.get_ylabel()
        left = 1e6 * (trace.measured["x"] - trace.augmented["x"])
        np.testing.assert_allclose(after.lines[0].get_ydata(), left)

    def test_without_effects_no_augmented_model_is_shown(self, tmp_path):
        one = made(tmp_path, effects={})
        ax = channel_over_time(one, one.traces[0], "x", Figure().subplots())
        assert "augmented model" not in [line.get_label() for line in ax.lines]
        assert "parameters.png" not in pictures(one)

    def test_only_what_is_measured(self, tmp_path):
        one = made(tmp_path, channels=("x",))
        labels = [ax.get_ylabel() for ax in pictures(one)["runs_large.png"].axes]
        assert not any("drive force" in text for text in labels)

    def test_missing_samples_leave_gaps(self, tmp_path):
        one = made(tmp_path)
        for trace in one.traces:
            trace.measured["x"][::3] = np.nan
        for figure in pictures(one).values():
            figure.draw_without_rendering()

    def test_windows_that_touch_are_one(self):
        windows = [{"run": "a", "t0": 1.0, "t1": 2.0, "share": 0.2},
                   {"run": "b", "t0": 2.0, "t1": 3.0, "share": 0.1},
                   {"run": "a", "t0": 2.0, "t1": 3.0, "share": 0.3},
                   {"run": "a", "t0": 4.0, "t1": 5.0, "share": 0.1}]  # fmt: skip
        assert _joined(windows) == [("a", 1.0, 3.0, 0.5), ("a", 4.0, 5.0, 0.1),
                                    ("b", 2.0, 3.0, 0.1)]  # fmt: skip

    @pytest.mark.parametrize(
        ("largest", "unit"), [(0.4, "m"), (0.04, "mm"), (5e-6, "µm"), (0.0, "m"), (np.nan, "m")]
    )
    def test_units_read_well(self, largest, unit):
        factor, found_unit = Channel("x", "m").scale(largest)
        assert found_unit == unit
        assert {"m": 1.0, "mm": 1e3, "µm": 1e6}[unit] == pytest.approx(factor)

    def test_a_rotary_bench_turns(self, tmp_path):
        one = made(tmp_path)
        one.nominal.other["bench.kind"] = "rotary"
        labels = [ax.get_ylabel() for ax in pictures(one)["runs_large.png"].axes]
        assert any(text.endswith("rad]") for text in labels)
        assert any(text.endswith("rad/s]") for text in labels)
        assert any(text.endswith("N m]") for text in labels)

    def test_labels(self):
        assert label("$5") == r"\$5"
        assert label("a\nb\u202e") == "a□b□"
        assert len(label("x" * 100)) == 24


class TestAugmented:
    def text(self, path, augmented, nominal=None):
        write_augmented(augmented, path, nominal)
        return path.read_text(encoding="utf-8")

    def test_the_users_file_is_kept(self, found, saved):
        text = (saved / "augmented.toml").read_text()
        assert text.startswith(NOMINAL)
        assert ls.load_robot(saved / "augmented.toml") == found.augmented

    @pytest.mark.parametrize(
        "effects",
        [
            {},
            {"drive_saturation": {"F_max": 0.1 + 0.2}, "sensor_drift": {"b": -1e-300}},
            {"coulomb_error": {"d_mu": -0.02}},
            {"transmission_compliance": {"k": float("inf"), "d": 0.0, "m_d": 0.1}},
            {e.name: {p.name: 0.5 for p in e.parameters} for e in ls.effects()},
        ],
    )
    def test_every_effect_comes_back_bit_for_bit(self, tmp_path, found, effects):
        augmented = Robot(found.nominal.parameters, found.nominal.other, effects)
        for given in (NOMINAL, None):
            self.text(tmp_path / "a.toml", augmented, given)
            assert ls.load_robot(tmp_path / "a.toml") == augmented

    def test_a_file_with_effects_of_its_own(self, tmp_path, found):
        augmented = Robot(found.nominal.parameters, found.nominal.other,
                          {"drive_lag": {"T": 0.02}, **EFFECTS})  # fmt: skip
        forms = ("\n[effects.drive_lag]\nT = 0.02\n", "\neffects.drive_lag.T = 0.02\n")
        table = NOMINAL + forms[0]
        assert self.text(tmp_path / "a.toml", augmented, table).startswith(table)
        assert ls.load_robot(tmp_path / "a.toml") == augmented
        dotted = "effects.drive_lag.T = 0.02\n" + NOMINAL
        self.text(tmp_path / "a.toml", augmented, dotted)
        assert ls.load_robot(tmp_path / "a.toml") == augmented

    def test_values_that_were_refitted_win_over_the_text(self, tmp_path, found):
        changed = Robot({**found.nominal.parameters, "mass": 0.3}, found.nominal.other, EFFECTS)
        self.text(tmp_path / "a.toml", changed, NOMINAL)
        assert ls.load_robot(tmp_path / "a.toml") == changed

    def test_a_bench(self, tmp_path):
        (tmp_path / "n.toml").write_text(
            "[robot]\nmass = 0.05\n[bench]\nkind = 'rotary'\ngravity_torque = 3.0\n"
            "[surface]\ncoulomb_force = 0.1"
        )
        robot = ls.load_robot(tmp_path / "n.toml")
        augmented = Robot(robot.parameters, robot.other, {"coulomb_error": {"d_force": 0.01}})
        for given in (None, (tmp_path / "n.toml").read_text()):
            self.text(tmp_path / "a.toml", augmented, given)
            assert ls.load_robot(tmp_path / "a.toml") == augmented


class TestCommand:
    @pytest.fixture
    def call(self, tmp_path, monkeypatch, capsys, found):
        """Run the command with an engine that returns the case of these tests."""
        asked = []

        def engine(*arguments, **options):
            asked.append((arguments, options))
            return found

        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("locosweep.diagnosis.pipeline.diagnose", engine)
        # Pictures have tests of their own.
        monkeypatch.setattr("locosweep.diagnosis.report.figures.FILES", {})

        def run(*arguments):
            code = main(["diagnose", *arguments])
            done = capsys.readouterr()
            return code, done.out, done.err, asked

        return run

    def test_verdict_goes_out_and_notes_beside_it(self, call, tmp_path, found):
        code, out, err, asked = call(
            "r.csv", "--nominal", "n.toml", "--out", "d", "--holdout", "2,3", "--holdout", "4",
            "--seed", "5", "--max-effects", "2", "--column", "drive=tau", "--unit", "x=mm",
            "--threads", "1",
        )  # fmt: skip
        assert code == 0
        assert out.splitlines() == [
            "explained: lubricant_buildup (probability 0.97)", found.summary, "d/report.html"
        ]  # fmt: skip
        assert err == f"locosweep: note: {found.warnings[0]}\n"
        ((arguments, options),) = asked
        assert arguments == (Path("r.csv"), Path("n.toml"))
        assert options == {"holdout": ["2", "3", "4"], "max_effects": 2, "seed": 5,
                           "columns": {"drive": "tau"}, "units": {"x": "mm"}, "threads": 1,
                           "progress": None}  # fmt: skip
        assert (tmp_path / "d" / "report.html").is_file()

    def test_quiet_and_json(self, call, found):
        code, out, err, _ = call("r", "--nominal", "n", "--out", "d", "--quiet")
        assert (code, err, len(out.splitlines())) == (0, "", 2)
        code, out, _, _ = call("r", "--nominal", "n", "--out", "e", "--json")
        assert json.loads(out) == {"verdict": found.report["verdict"], "out": "e"}

    def test_a_full_folder_is_refused_before_the_work(self, call, tmp_path):
        (tmp_path / "d").mkdir()
        (tmp_path / "d" / "x").write_text("")
        code, out, err, asked = call("r", "--nominal", "n", "--out", "d")
        assert (code, out, asked) == (2, "", [])
        assert err.startswith("locosweep: d is not empty")
        assert call("r", "--nominal", "n", "--out", "d", "--force")[0] == 0

    @pytest.mark.parametrize(
        "options",
        [("--max-effects", "0"), ("--seed", "-1"), ("--column", "drive"), ("--unit", "x="), ()],
    )
    def test_bad_options_cost_one_line(self, call, tmp_path, options):
        given = ("--nominal", "n", "--out", "d") if options else ("--out", "d")
        code, out, err, asked = call("r", *given, *options)
        assert (code, out, asked) == (2, "", [])
        assert err.count("\n") == 1
        assert not (tmp_path / "d").exists()
