"""Diagnosis as an object, report.json, and the folder that is written."""

import json
import os
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from diagnosis_case import EFFECTS, made
from locosweep.diagnosis.report.figures import FILES
from locosweep.diagnosis.report.result import report_text
from locosweep.errors import InputError
from locosweep.files import folder


@pytest.mark.whole
class TestSave:
    def test_everything_is_there_and_nothing_else(self, saved):
        names = {"report.json", "report.html", "report.md", "augmented.toml", *FILES}
        assert {path.name for path in saved.iterdir()} == names
        assert {path.name for path in saved.parent.iterdir()} == {"report"}

    @pytest.mark.slow
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

    def test_force_replaces_own_files_only(self, tmp_path, monkeypatch):
        none = made(tmp_path, effects={})
        few = {name: FILES[name] for name in ("parameters.png", "horizons.png")}
        monkeypatch.setattr("locosweep.diagnosis.report.figures.FILES", few)
        (tmp_path / "out").mkdir()
        for name in ("mine.txt", "parameters.png", "report.json"):
            (tmp_path / "out" / name).write_text("old")
        none.save(tmp_path / "out", force=True)
        # Without effects there are no parameters: the old picture must not stay.
        there = {path.name for path in (tmp_path / "out").iterdir()}
        assert "parameters.png" not in there
        assert "horizons.png" in there
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
