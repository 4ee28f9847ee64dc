"""The blind check on a rig: its command, its verdicts judged, its table."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from locosweep.cli import main
from locosweep.diagnosis.report.model_file import write_augmented
from locosweep.errors import DataFileError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import replay_runs
from locosweep.validation import semi_files
from locosweep.validation.case_files import read_truth
from locosweep.validation.semi_check import SemiJudged, first_cause
from locosweep.validation.semi_files import frame_of, rig_of
from locosweep.validation.semi_tables import as_json, as_text, sums

T = np.arange(0.0, 1.2, 0.01)
RAW = Robot(
    {"mass": 0.4, "segments": 1.0, "gain": 1.5},
    {
        "surface.coulomb_force": 1.0, "bench.kind": "linear", "sensor.position_noise": 1e-5,
        "uncertainty.mass": 0.2,
    },
)  # fmt: skip
REAL = replace(
    RAW,
    parameters={**RAW.parameters, "mass": 0.5, "viscous": 0.8},
    effects={"quadratic_drag": {"c2": 0.3}},
)


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Runs of a rig, and the raw file of its model."""
    folder = tmp_path_factory.mktemp("rig")
    drives = [2.4 * np.sin((5.0 + i) * T + 2.0 * T**2) for i in range(3)]
    runs = [Run(f"{i}", T, drive, {"x": np.zeros(T.size)}) for i, drive in enumerate(drives)]
    read = np.split(replay_runs(REAL, runs)["x"].to_numpy(), len(runs))
    noise = np.random.default_rng(2)
    seen = [
        replace(run, channels={"x": x + noise.normal(0.0, 1e-5, T.size)})
        for run, x in zip(runs, read, strict=True)
    ]
    frame_of(seen).write_csv(folder / "runs.csv")
    write_augmented(RAW, folder / "raw.toml")
    return folder


def command(rig: Path, out: Path, *more: str) -> list[str]:
    return [
        "blind-check", "--rig", str(rig / "runs.csv"), "--nominal", str(rig / "raw.toml"),
        "--sizes", "10", "--out", str(out), "--threads", "1", *more,
    ]  # fmt: skip


DRAWN = ["drive_gain_error", "transmission_backlash"]


@pytest.fixture(scope="module")
def out(rig: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A check of two effects, of which one cannot be planted."""
    out = tmp_path_factory.mktemp("semi") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(semi_files, "names_of", lambda _: DRAWN)
        assert main(command(rig, out, "--calibrate", "--quiet")) == 0
    return out


@pytest.mark.slow
class TestCommand:
    def test_it_writes_cases_truths_and_figures(self, out: Path) -> None:
        found = json.loads((out / "metrics.json").read_text())
        cases = {case["case"]: case for case in found["cases"]}
        assert "drive_gain_error_10" in cases
        assert sum(name.startswith("control_") for name in cases) >= 3
        assert found["skipped"].keys() == {"transmission_backlash_10"}
        planted = cases["drive_gain_error_10"]
        assert planted["reached"] == pytest.approx(10.0, rel=0.05)
        assert planted["baseline_right"]
        assert not any(case["error"] for case in cases.values())
        table = (out / "table.txt").read_text()
        assert "10 times: right first in" in table
        assert "transmission_backlash_10" in table

    def test_the_calibrated_model_is_that_of_the_rig(self, out: Path) -> None:
        robot = load_robot(out / "calibrated.toml")
        assert robot.other.keys() == RAW.other.keys() - {"uncertainty.mass"}
        gain = robot.parameters["gain"] / 1.5
        assert robot.parameters["mass"] / gain == pytest.approx(0.5, rel=0.05)

    def test_a_case_is_what_a_user_brings_and_a_sealed_truth(self, out: Path) -> None:
        runs, _ = load_runs(out / "drive_gain_error_10" / "runs.parquet")
        original, _ = load_runs(out / "control_0" / "runs.parquet")
        truth = read_truth(out, "drive_gain_error_10")
        share = 1.0 + truth["parameters"]["e"]
        for new, old in zip(runs, original, strict=True):
            assert new.drive * share == pytest.approx(old.drive, rel=1e-6)

    def test_an_altered_truth_is_refused(self, out: Path) -> None:
        path = out / "sealed" / "control_0" / "truth.json"
        before = path.read_text()
        path.write_text("{}")
        with pytest.raises(DataFileError, match="altered"):
            read_truth(out, "control_0")
        path.write_text(before)

    def test_cases_and_diagnoses_of_the_same_code_are_kept(
        self, rig: Path, out: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(semi_files, "names_of", lambda _: DRAWN)
        given = command(rig, out, "--calibrate", "--quiet")
        kept = [*out.rglob("outcome.json"), *out.glob("sealed/drive*/truth.json")]
        times = [path.stat().st_mtime_ns for path in kept]
        assert main(given) == 0
        assert len(kept) >= 5
        assert [path.stat().st_mtime_ns for path in kept] == times


@pytest.mark.whole
def test_cases_of_a_rig_are_drawn_and_sealed(
    rig: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(semi_files, "names_of", lambda _: DRAWN)
    given = command(rig, tmp_path / "out", "--calibrate", "--draw-only", "--json", "--runs", "0,2")
    assert main(given) == 0
    said = capsys.readouterr()
    assert "calibrated: mass" in said.err
    found = json.loads(said.out)
    assert found["skipped"].keys() == {"transmission_backlash_10"}
    truths = [read_truth(tmp_path / "out", name) for name in ("drive_gain_error_10", "control_0")]
    assert [truth["effect"] for truth in truths] == ["drive_gain_error", None]
    labels = {run.label for run in load_runs(tmp_path / "out" / "control_0" / "runs.parquet")[0]}
    assert labels == {"0", "2"}
    assert not (tmp_path / "out" / "diagnoses").exists()


@pytest.mark.whole
@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--cases", "3"], "--cases: allowed not beside --rig"),
        (["--gap-free", "3"], "--gap-free: allowed not beside --rig"),
        (["--runs", "0,7"], "no run 7: there are 0, 1, 2"),
        (["--sizes", "1"], "allowed are numbers above 1"),
        (["--sizes", "3,x"], "x"),
    ],
)
def test_what_does_not_go_together_is_refused(
    rig: Path, tmp_path: Path, more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(rig, tmp_path / "out", *more)) == 2
    message = capsys.readouterr().err
    assert said in message
    assert message.count("\n") == 1


def test_options_of_a_rig_need_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["blind-check", "--calibrate", "--out", str(tmp_path / "out")]) == 2
    assert "--calibrate: allowed only beside --rig" in capsys.readouterr().err
    runs = tmp_path / "runs.csv"
    runs.write_text("t,drive,x\n0,0,0\n")
    assert main(["blind-check", "--rig", str(runs), "--out", str(tmp_path / "out")]) == 2
    assert "--nominal is missing" in capsys.readouterr().err


@pytest.mark.whole
def test_a_model_with_effects_is_refused_before_anything_is_drawn(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_augmented(replace(RAW, effects={"drive_lag": {"T": 0.02}}), tmp_path / "nominal.toml")
    given = command(rig, tmp_path / "out")
    given[given.index("--nominal") + 1] = str(tmp_path / "nominal.toml")
    assert main(given) == 2
    assert "the nominal model has effects (drive_lag)" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_runs_of_a_rig_may_be_chosen(rig: Path) -> None:
    chosen = rig_of(rig / "runs.csv", rig / "raw.toml", ["2", "0"])
    assert [run.label for run in chosen.runs] == ["0", "2"]
    assert len(rig_of(rig / "runs.csv", rig / "raw.toml", []).runs) == 3


def test_runs_go_through_files_unchanged(tmp_path: Path) -> None:
    x = np.where(T > 1.0, np.nan, T)
    runs = [Run("a", T, T, {"x": x}, 3.0), Run("b", T[:30], T[:30], {"x": T[:30], "v": T[:30]})]
    frame_of(runs).write_parquet(tmp_path / "runs.parquet")
    for new, old in zip(load_runs(tmp_path / "runs.parquet")[0], runs, strict=True):
        assert (new.label, new.slope_deg) == (old.label, old.slope_deg)
        np.testing.assert_array_equal(new.drive, old.drive)
        np.testing.assert_array_equal(new.channels["x"], old.channels["x"])


@pytest.mark.parametrize(
    ("verdict", "first"),
    [
        ({"effects": [], "equivalent": []}, ((), None, None)),
        ({"effects": ["a"], "equivalent": [["a", "b"]]}, (("a", "b"), None, None)),
        ({"effects": ["a"], "equivalent": [[]]}, (("a",), None, None)),
        (
            {
                "effects": ["a", "c"], "equivalent": [["a"], ["c"]],
                "contributions": [
                    {"effects": ["c", "d"], "share": 0.7, "alone": 0.6},
                    {"effects": ["a"], "share": 0.1, "alone": 0.2},
                ],
            },
            (("c", "d"), 0.7, 0.6),
        ),
    ],
)  # fmt: skip
def test_the_first_cause_is_that_of_the_contributions_if_there_are_any(
    verdict: dict[str, Any], first: tuple[Any, ...]
) -> None:
    assert first_cause(verdict) == first


def judged(size: float, *, right: bool, baseline_right: bool) -> SemiJudged:
    planted = "drive_lag" if size else ""
    return SemiJudged(
        case=planted or "control_0", planted=planted, size=size, reached=size, accepted=(),
        status="partial", first=("drive_lag",), share=0.5, alone=0.5, right=right,
        baseline="drive_lag", baseline_share=0.4, baseline_right=baseline_right,
        baseline_holds=True, baseline_alike=2, decidable=right, seconds=3.0,
    )  # fmt: skip


def test_sums_are_those_of_each_size() -> None:
    cases = [
        judged(3.0, right=True, baseline_right=False),
        judged(3.0, right=False, baseline_right=False),
        judged(10.0, right=True, baseline_right=True),
        judged(0.0, right=False, baseline_right=True),
    ]
    rows = {row["size"]: row for row in sums(cases)}
    assert rows[3.0]["right"]["share"] == 0.5
    assert rows[3.0]["baseline_right"]["hits"] == 0
    assert rows[10.0]["right"]["interval"][0] < 1.0 == rows[10.0]["right"]["share"]
    text = as_text(cases, {"friction_drift_30": "too weak"})
    assert "controls: a cause with a share above 0.2 in 1 of 1 (baseline 0)" in text
    assert "3 times: right first in 1 of 2" in text
    assert "alone fits as well as any: 1 of 1, baseline 0" in text
    assert "friction_drift_30: too weak" in text
    found = as_json(cases, {}, {"seed": 3})
    assert (found["seed"], len(found["cases"]), len(found["sums"])) == (3, 4, 3)
