"""The diagnosis of long runs and of plants that fall over, from end to end."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from diagnosis_long import PENDULUM, drives, measured
from locosweep.diagnosis import Diagnosis, diagnose

pytestmark = pytest.mark.whole

DATA = Path(os.environ.get("LOCOSWEEP_DATA", "")) / "realdata" / "dfki_pendulum"
needs_data = pytest.mark.skipif(
    not (os.environ.get("LOCOSWEEP_DATA") and DATA.is_dir()),
    reason="LOCOSWEEP_DATA does not name a folder with measured runs of a pendulum",
)


@pytest.fixture(scope="module")
def fallen() -> Diagnosis:
    """A pendulum with more mass than its model, over the top."""
    return diagnose(
        measured(PENDULUM, {"payload_mass": {"dm": 0.004}}, drives(PENDULUM)), PENDULUM, threads=1
    )


class TestVerdict:
    def test_the_cause_is_found(self, fallen):
        assert (fallen.status, fallen.equivalent) == ("explained", [["payload_mass"]])
        found = fallen.candidates[0]["parameters"]["payload_mass"]["dm"]
        assert found["value"] == pytest.approx(0.004, rel=0.02)
        assert fallen.gap["shrink"] > 0.9
        assert "over 0.447 s from the measured state" in fallen.gap["metric"]

    def test_the_report_speaks_of_the_runs(self, fallen):
        labels = {"0", "1", "2"}
        assert {row["run"] for row in fallen.where["runs"]} == labels
        assert set(fallen.gap["held_out"]) | set(fallen.gap["used_for_fit"]) == labels
        for row in fallen.where["windows"]:
            assert row["run"] in labels
            assert 0.0 <= row["t0"] < row["t1"] <= 8.0
        assert [trace.t.size for trace in fallen.traces] == [1600] * 3
        assert any("windows of 0.447 s" in text for text in fallen.warnings)
        json.dumps(fallen.report, allow_nan=False)

    def test_the_curves_start_anew(self, fallen):
        trace = fallen.traces[0]
        known = np.isfinite(trace.augmented["x"])
        assert known.mean() > 0.95
        assert np.abs(trace.augmented["x"] - trace.measured["x"])[known].max() < 0.1

    @pytest.mark.slow
    def test_what_it_writes(self, fallen, tmp_path):
        fallen.save(tmp_path / "report")
        assert (tmp_path / "report" / "report.html").stat().st_size > 10_000


@pytest.mark.slow
@needs_data
def test_a_real_pendulum() -> None:
    """Its remainder is beyond the noise: the main cause is named, and what it leaves."""
    frame = pl.read_csv(DATA / "runs.csv").filter(pl.col("run").is_in([5, 6, 7]))
    found = diagnose(frame, DATA / "nominal.toml", holdout=["6", "7"], max_effects=2, threads=1)
    assert found.status == "partial"
    # A heavier body and a weaker torque do nearly the same to these runs.
    assert set(found.equivalent[0]) & {"payload_mass", "drive_gain_error"}
    assert not any("viscous_friction" in names for names in found.equivalent)
    assert found.contributions[0]["share"] > 0.1
    assert found.remaining["noise_floors"] > 2.0
    assert found.remaining["shape"]
