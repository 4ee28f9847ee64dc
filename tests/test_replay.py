"""Measured runs: reading them, and replaying their drives through a model."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep import _core
from locosweep.cli import main
from locosweep.errors import DataFileError, InputError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import nominal_of, replay_runs

MODEL = """
[robot]
segments = 4
mass = 0.271
[surface]
mu_coulomb = 0.15
[drive]
gain = 2.0
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.toml").write_text(MODEL)
    return tmp_path


def table(rows=40, **changes):
    """A run of a constant command, as text of a CSV file."""
    columns = {
        "run": ["a"] * rows,
        "t": [f"{0.005 * i:.3f}" for i in range(rows)],
        "drive": ["0"] + ["0.5"] * (rows - 1),
        "x": ["0.001"] * rows,
    } | changes
    lines = [",".join(columns)]
    lines += [",".join(row) for row in zip(*columns.values(), strict=True)]
    return "\n".join(lines) + "\n"


class TestRuns:
    def test_columns_units_and_missing_values(self, folder):
        x = ["1"] * 39 + [""]
        tau = ["0"] * 5 + ["", "nan"] + ["500"] * 33
        text = table(x=x, drive=["9"] * 40, tau=tau, note=["-"] * 40)
        (folder / "r.csv").write_text(text)
        runs, notices = load_runs("r.csv", {"drive": "tau"}, {"x": "mm", "drive": "mN"})
        (run,) = runs
        assert run.label == "a"
        assert run.channels["x"][0] == 1e-3
        assert np.isnan(run.channels["x"][-1])
        assert run.drive.tolist() == [0.0] * 7 + [0.5] * 33
        assert len(notices) == 2
        assert "note" in notices[0]
        assert "held from before" in notices[1]

    def test_parquet_reads_the_same(self, folder):
        (folder / "r.csv").write_text(table(run=["1"] * 20 + ["2"] * 20))
        frame = pl.read_csv("r.csv")
        frame.write_parquet("r.parquet")
        a, b = load_runs("r.csv")[0], load_runs("r.parquet")[0]
        assert [run.label for run in a] == [run.label for run in b] == ["1", "2"]
        for left, right in zip(a, b, strict=True):
            assert (left.t == right.t).all()
            assert (left.drive == right.drive).all()

    def test_start_is_the_mean_before_the_head_moves(self, folder):
        x = ["0.001", "0.003"] + ["0.01"] * 38
        (folder / "r.csv").write_text(table(x=x, drive=["0"] * 2 + ["0.5"] * 38))
        (run,) = load_runs("r.csv")[0]
        assert run.start[0] == pytest.approx(np.mean([0.001, 0.003, 0.01]))

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            (table(t=["0"] * 40), "run a, row 2, column t: 0 s after 0 s"),
            (table(x=["0"] * 6 + ["x"] + ["0"] * 33), "row 7, column x: 'x' is not a number"),
            (table(drive=["inf"] * 40), "row 1, column drive: infinite"),
            (table(drive=["1e400"] * 40), "row 1, column drive: infinite"),
            (table(rows=19), "run a: 19 samples"),
            (table(t=[""] + [f"{i}" for i in range(39)]), "row 1, column t: missing"),
            (table(slope_deg=["1"] * 20 + ["2"] * 20), "one per run"),
            ("", "empty"),
            ("run,t,drive,x\n", "no rows"),
            ("run,t,x\na,0,0\n", "no column drive"),
            ("t,t,drive,x\n0,0,0,0\n", "column t is there twice"),
        ],
    )
    def test_bad_input_is_one_line_that_names_the_place(self, folder, text, words):
        (folder / "r.csv").write_text(text)
        with pytest.raises(DataFileError) as caught:
            load_runs("r.csv")
        assert words in str(caught.value)
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith("r.csv")

    def test_names_that_are_none(self, folder):
        (folder / "r.csv").write_text(table())
        with pytest.raises(InputError, match="unknown column 'drivee': did you mean 'drive'"):
            load_runs("r.csv", {"drivee": "tau"})
        with pytest.raises(InputError, match="unknown unit 'furlongg'"):
            load_runs("r.csv", {}, {"x": "furlongg"})
        with pytest.raises(DataFileError, match="no column tau"):
            load_runs("r.csv", {"drive": "tau"})

    def test_parquet_that_is_none(self, folder):
        (folder / "r.parquet").write_bytes(b"PAR1 and nothing else")
        with pytest.raises(DataFileError, match="not a readable Parquet file"):
            load_runs("r.parquet")


class TestModel:
    def test_effects_of_a_file(self, folder):
        (folder / "m.toml").write_text(MODEL + "[effects.drive_lag]\nT = 0.02\n")
        assert ls.load_robot("m.toml").effects == {"drive_lag": {"T": 0.02}}

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("[effects.drive_lagg]\nT = 1\n", "did you mean 'drive_lag'"),
            ("[effects.drive_lag]\ntau = 1\n", "unknown key in \\[effects.drive_lag\\] 'tau'"),
            ("[effects.drive_lag]\nT = -1\n", "T is -1.0 s: allowed is"),
            ("[effects.drive_lag]\nT = 'x'\n", "allowed is a number"),
            ("[effects.stribeck_friction]\nF_s = 1.0\n", "has no v_s"),
        ],
    )
    def test_bad_effects(self, folder, text, words):
        (folder / "m.toml").write_text(MODEL + text)
        with pytest.raises(DataFileError, match=words):
            ls.load_robot("m.toml")

    def test_effects_are_those_of_the_contract(self):
        names = {effect.name for effect in ls.effects()}
        assert len(names) == 25
        assert {"lubricant_buildup", "anchor_slip", "sensor_delay", "back_emf"} <= names


class TestReplay:
    def test_a_constant_force_gives_the_closed_form(self, folder):
        (folder / "r.csv").write_text(table(rows=60))
        frame = replay_runs(ls.load_robot("model.toml"), load_runs("r.csv")[0])
        t = frame["t"].to_numpy() - 0.005
        a = 2.0 * 0.5 / 0.271 - 0.15 * 9.81
        start = load_runs("r.csv")[0][0].start[0]
        expected = start + 0.5 * a * np.maximum(t, 0.0) ** 2
        np.testing.assert_allclose(frame["x"].to_numpy(), expected, atol=1e-15)
        assert frame["force"].to_list() == [0.0] + [1.0] * 59
        assert frame["x_rear"].to_list() == [0.0] * 60

    @pytest.mark.parametrize("by", [(), ("mass_share", "x_start")])
    @pytest.mark.parametrize("asked", [["x"], ["force", "v"], ["x_rear", "x"]])
    def test_channels_that_are_asked_for_have_the_bits_of_all(self, by, asked):
        slips = {"mu_static": 0.1, "mu_coulomb": 0.08}
        effects = {"anchor_slip": slips, "viscous_friction": {"c": -300.0}}
        t = 0.005 * np.arange(500)
        runs = [
            Run(label, t, np.where(t < 0.1, 0.0, force), {"x": np.zeros(500)})
            for label, force in (("rests", 0.1), ("leaves all bounds", 2.0), ("back", -2.0))
        ]
        robot = Robot({"segments": 4.0, "mass": 0.271, "mu_coulomb": 0.15}, effects=effects)
        whole = replay_runs(robot, runs, sensitivities=by)
        assert whole["x"].is_nan().any()
        found = replay_runs(robot, runs, channels=asked, sensitivities=by)
        assert found.columns == ["run", "t", *asked, *(f"{c}_by_{n}" for n in by for c in asked)]
        assert found.equals(whole.select(found.columns))

    def test_channels_are_those_of_a_replay(self, folder):
        robot, run = Robot({"mass": 1.0, "mu_coulomb": 0.1}), load_runs(self.rows(folder))[0]
        with pytest.raises(InputError, match=r"channel 'y'.*x, v, x_rear, force"):
            replay_runs(robot, run, channels=["x", "y"])
        with pytest.raises(InputError, match=r"channels is empty: allowed are one or more of x, v"):
            replay_runs(robot, run, channels=[])

    @pytest.mark.parametrize("channels", [[], [4], [0, 0]])
    def test_numbers_of_channels_are_checked(self, channels):
        run = (np.array([0.0, 0.1]), np.zeros(2), 0.0)
        job = _core.Replay(nominal_of(Robot({"mass": 1.0, "mu_coulomb": 0.1})), [run])
        values = np.zeros((1, _core.effect_parameter_count()))
        shares, starts = np.array([[1.0, 1.0, 1.0, 0.0]]), np.zeros((1, 2))
        given = [(0, 0, 2, [])], values, shares, starts
        with pytest.raises(InputError, match=r"channels are .*: allowed are different numbers"):
            job.run(*given, 1, channels=channels)
        with pytest.raises(InputError, match=r"channels are .*: allowed are different numbers"):
            job.run_with_sensitivities(*given, [[0]], 1, channels=channels)

    def rows(self, folder):
        (folder / "r.csv").write_text(table(rows=60))
        return "r.csv"

    def test_command(self, folder):
        (folder / "r.csv").write_text(table(tau=["0"] + ["500"] * 39))
        arguments = ["simulate", "--model", "model.toml", "--runs", "r.csv", "--column",
                     "drive=tau", "--unit", "drive=mN", "--out", "p.parquet"]  # fmt: skip
        assert main(arguments) == 0
        frame = pl.read_parquet("p.parquet")
        assert frame.columns == ["run", "t", "x", "v", "x_rear", "force"]
        assert frame["force"][-1] == 1.0

    def test_bad_run_leaves_nothing(self, folder):
        (folder / "r.csv").write_text(table(rows=5))
        arguments = ["simulate", "--model", "model.toml", "--runs", "r.csv", "--out", "p.csv"]
        assert main(arguments) == 2
        assert not (folder / "p.csv").exists()


DATA = os.environ.get("LOCOSWEEP_DATA")


@pytest.mark.skipif(DATA is None, reason="LOCOSWEEP_DATA is not set: no labelled runs to compare")
def test_true_effects_bring_labelled_runs_of_another_simulator_to_their_noise():
    folder = Path(str(DATA)) / "practice"
    cases = json.loads((folder / "truth.json").read_text())["cases"]
    seen = set()
    for name, truth in cases.items():
        if truth["family"] == "F":
            continue  # a cause that is in no list
        robot = ls.load_robot(folder / name / "nominal.toml")
        robot.effects.update(truth["parameters"])
        runs, _ = load_runs(folder / name / "check.csv")
        frame = replay_runs(robot, runs)
        for channel, expected in truth["truth_rmse_check"].items():
            misses = []
            for run in runs:
                predicted = frame.filter(pl.col("run") == run.label)[channel].to_numpy()
                miss = run.channels[channel] - predicted
                # The first sample carries noise: a start offset is allowed.
                misses.append(miss - (np.nanmean(miss) if channel == "x" else 0.0))
            found = float(np.sqrt(np.nanmean(np.concatenate(misses) ** 2)))
            assert found < 1.02 * expected, (name, channel)
        seen |= set(truth["effects"])
    assert len(seen) >= 15


class TestSensitivities:
    def runs(self, count=3):
        t = np.linspace(0.0, 2.0, 401)
        drive = np.round(0.9 * np.sin(3.1 * t), 2)
        return [
            Run(f"r{i}", t[: 401 - i], drive[: 401 - i], {"x": np.zeros(401 - i)})
            for i in range(count)
        ]

    def robot(self, folder, tau=0.02):
        text = MODEL + f"[effects.drive_lag]\nT = {tau}\n"
        (folder / "lagged.toml").write_text(text)
        return load_robot("lagged.toml")

    def test_they_are_those_of_differences(self, folder):
        runs = self.runs()
        read = replay_runs(self.robot(folder), runs, sensitivities=["v_start", "drive_lag.T"])
        plain = replay_runs(self.robot(folder), runs)
        assert read.select(plain.columns).equals(plain)
        h = 2e-7
        up, down = (replay_runs(self.robot(folder, 0.02 + s * h), runs) for s in (1, -1))
        for channel in ("x", "v", "force"):
            differences = (up[channel] - down[channel]).to_numpy() / (2 * h)
            found = read[f"{channel}_by_drive_lag.T"].to_numpy()
            # A sample beside a stop sees it on one side of the difference only.
            near = np.abs(found - differences) < 1e-3 * np.abs(differences).max()
            assert near.mean() > 0.98
        assert read["x_by_v_start"].to_numpy()[0] == 0.0

    def test_unknown_names_list_what_there_is(self, folder):
        with pytest.raises(InputError, match=r"sensitivity 'drive_lag\.t'.*drive_lag\.T.*x_start"):
            replay_runs(self.robot(folder), self.runs(1), sensitivities=["drive_lag.t"])

    def test_parameters_that_an_effect_has_not_are_refused(self):
        robot = Robot({"mass": 0.271, "mu_coulomb": 0.15}, effects={"drive_delay": {"tau": 0.03}})
        with pytest.raises(InputError, match=r"parameter of drive_delay.*tau.*T"):
            replay_runs(robot, self.runs(1))

    def test_threads_do_not_change_a_bit(self, folder):
        names = ["mass_share", "coulomb_share", "gain_share", "clock_offset", "x_start"]
        one, two = (
            replay_runs(self.robot(folder), self.runs(5), sensitivities=names, threads=n)
            for n in (1, 2)
        )
        assert one.equals(two)
