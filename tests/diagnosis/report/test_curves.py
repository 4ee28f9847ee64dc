"""Runs on the page: few enough samples, no peak lost, a line for each cause."""

import base64
import copy
from dataclasses import replace

import numpy as np
import pytest

from diagnosis_case import made
from locosweep.diagnosis.report.curves import ROOM, curves


def arrays(data, text):
    """By run: times, and by channel the lines."""
    numbers = np.frombuffer(base64.b64decode(text), "<f4")
    at, found = 0, []
    for run in data["runs"]:
        count = 1 + len(data["lines"])
        parts = numbers[at:][: run["count"] * (1 + len(run["channels"]) * count)].astype(float)
        at += parts.size
        t, *lines = parts.reshape(-1, run["count"])
        fields = {c: [lines[k * count] + line for line in lines[k * count + 1 :][: count - 1]]
                  for k, c in enumerate(run["channels"])}  # fmt: skip
        found.append((t, fields))
    assert at == numbers.size
    return found


def test_all_samples_are_there_where_they_fit(found):
    data, text = curves(found)
    assert [line["words"] for line in data["lines"]] == [
        "measured", "nominal model", "with lubricant buildup"
    ]  # fmt: skip
    for (t, fields), trace in zip(arrays(data, text), found.traces, strict=True):
        assert np.allclose(t, trace.t - trace.t[0], atol=1e-6)
        for k, source in enumerate((trace.measured, trace.nominal, trace.augmented)):
            assert np.allclose(fields["x"][k], source["x"], rtol=1e-6, atol=1e-7)
    assert all(run["note"] == "" for run in data["runs"])
    # The page begins with the worst of the runs that no fit has seen.
    assert found.traces[data["first"]].held_out


def test_thinned_runs_keep_their_peaks_and_say_so(found):
    data, text = curves(found, room=70_000)
    assert len(text) <= 70_000
    for run, (t, fields), trace in zip(data["runs"], arrays(data, text), found.traces, strict=True):
        assert len(t) < trace.t.size
        assert f"{len(t)} of {trace.t.size} samples" in run["note"]
        assert (t[0], t[-1]) == pytest.approx((0.0, trace.t[-1] - trace.t[0]))
        gap = trace.measured["x"] - trace.nominal["x"]
        # Errors keep their digits, however far the head has come.
        shown = fields["x"][0] - fields["x"][1]
        assert shown.max() == pytest.approx(gap.max(), rel=1e-5)
        assert shown.min() == pytest.approx(gap.min(), rel=1e-5)


def test_more_runs_than_fit_are_those_with_the_largest_gaps(found):
    data, text = curves(found, room=2 * 300 * 9 * 16 // 3 + 10)
    assert len(text) < 2 * 300 * 9 * 6
    assert len(data["runs"]) == 2
    rows = sorted(found.where["runs"], key=lambda row: -row["before"])[:2]
    shown = {run["words"].partition(",")[0] for run in data["runs"]}
    assert shown == {row["run"] for row in rows}
    assert "The 2 runs with the largest gaps are here." in data["runs"][0]["note"]


def test_each_cause_has_its_line(found):
    report = copy.deepcopy(found.report)
    report["verdict"]["effects"] = ["drive_lag", "lubricant_buildup"]
    stage = {"x": [trace.nominal["x"] + 1.0 for trace in found.traces]}
    details = found.details | {"stages": {"drive_lag": stage}}
    data, text = curves(replace(found, report=report, details=details))
    assert [line["words"] for line in data["lines"][2:]] == [
        "with drive lag", "with drive lag and lubricant buildup"
    ]  # fmt: skip
    (_, fields), *_ = arrays(data, text)
    assert np.allclose(fields["x"][2], found.traces[0].nominal["x"] + 1.0, rtol=1e-6)
    assert np.isnan(fields["force"][2]).all()


def test_nothing_named_and_missing_readings(tmp_path):
    one = made(tmp_path, effects={})
    one.traces[0].measured["x"][:] = np.nan
    data, text = curves(one)
    assert [line["words"] for line in data["lines"]] == ["measured", "nominal model"]
    assert np.isnan(arrays(data, text)[0][1]["x"][0]).all()


def test_names_from_files_are_shown_without_tricks(hostile):
    data, _ = curves(hostile)
    words = " ".join(run["words"] for run in data["runs"])
    assert "<script>" in words
    assert "\u202e" not in words


def test_room_is_for_a_page_of_its_size():
    assert ROOM < 1_500_000
