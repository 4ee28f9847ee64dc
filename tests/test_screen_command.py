"""The command `screen`: which effects could explain a gap, before any replay."""

import json
import re
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from diagnosis_small import ROBOT, driven, measured
from locosweep.cli import main
from locosweep.diagnosis import screen
from locosweep.diagnosis.data.inputs import nominal_model, read_runs
from locosweep.diagnosis.screening import Screen
from locosweep.errors import InputError, SolveError
from locosweep.files.robot import Robot

NOMINAL = """
[robot]
mass = 0.25
segments = 4
gravity = 9.81
[surface]
mu_coulomb = 0.3
[sensor]
position_noise = 1e-5
force_noise = 0.01
"""


def table(runs) -> pl.DataFrame:
    return pl.concat(
        pl.DataFrame({"run": run.label, "t": run.t, "drive": run.drive, **run.channels})
        for run in runs
    )


def screened(effects, robot=ROBOT, **options) -> Screen:
    # Samples of 5 ms: coarser ones do not resolve the sines, which adds to the noise.
    return screen(table(measured(effects, driven(step=0.005))), robot, **options)


class TestFunction:
    @pytest.mark.parametrize(
        ("name", "parameter", "value"),
        [("viscous_friction", "c", 0.05), ("drive_lag", "T", 0.02), ("sensor_scale", "e", 0.02)],
    )
    def test_a_true_cause_comes_first_with_its_value(self, name, parameter, value):
        found = screened({name: {parameter: value}}, pairs=0)
        # What pushes or holds in the same way, as back-EMF does, leaves the same.
        best = found.table["mean_square"].min()
        row = next(row for row in found.table.to_dicts() if row["effects"] == [name])
        assert row["mean_square"] == pytest.approx(best, rel=1e-6)
        assert [p["name"] for p in row["parameters"]] == [parameter]
        assert row["parameters"][0]["value"] == pytest.approx(value, rel=0.02)
        assert row["share"] == pytest.approx(1.0 - best / found.mean_square)
        assert found.ranks
        assert found.mean_square > 30.0
        assert (found.runs, found.of_runs) == (3, 3)
        assert found.slides > 3

    def test_two_causes_are_the_best_pair(self):
        truth = {"viscous_friction": {"c": 0.05}, "sensor_scale": {"e": 0.02}}
        found = screened(truth, pairs=3).table
        count = found["effects"].list.len()
        assert count.is_sorted()
        assert (count == 2).sum() == 3
        for part in (found.filter(count == 1), found.filter(count == 2)):
            assert part["mean_square"].is_sorted()
        pairs = found.filter(count == 2).to_dicts()
        row = next(row for row in pairs if set(row["effects"]) == set(truth))
        assert row["mean_square"] == pytest.approx(pairs[0]["mean_square"], rel=1e-3)
        for value in row["parameters"]:
            true = truth[value["effect"]][value["name"]]
            assert value["value"] == pytest.approx(true, rel=0.05)

    def test_runs_of_the_nominal_model_are_noise(self):
        found = screened({}, pairs=0)
        assert found.mean_square < 5.0
        assert not found.ranks
        assert set(found.unseen) >= {"presliding_compliance"}

    def test_uncertain_values_are_fitted_beside(self):
        heavy = replace(ROBOT, parameters={**ROBOT.parameters, "mass": 0.26})
        runs = table(measured({}, driven(step=0.005), robot=heavy))
        exact = screen(runs, ROBOT, pairs=0)
        loose = replace(ROBOT, other={**ROBOT.other, "uncertainty.mass": 0.05})
        assert screen(runs, loose, pairs=0).mean_square < 0.02 * exact.mean_square

    def test_threads_change_nothing(self):
        one, two = (
            screened({"drive_lag": {"T": 0.02}}, threads=threads, pairs=2) for threads in (1, 2)
        )
        assert one.table.equals(two.table)

    def test_runs_without_slides_have_no_screen(self):
        t = np.arange(0.0, 1.0, 0.01)
        x = np.random.default_rng(0).normal(0.0, 1e-5, t.size)
        with pytest.raises(SolveError, match="no run slides long enough"):
            screen({"t": t, "drive": np.zeros(t.size), "x": x}, ROBOT)

    @pytest.mark.parametrize("pairs", [-1, True, 1.5])
    def test_a_bad_count_of_pairs_is_refused(self, pairs):
        with pytest.raises(InputError, match="pairs is"):
            screened({}, pairs=pairs)

    def test_inputs_are_those_of_a_diagnosis(self):
        with pytest.raises(InputError, match="has effects"):
            nominal_model(replace(ROBOT, effects={"drive_lag": {"T": 0.1}}))
        assert isinstance(nominal_model(ROBOT), Robot)
        with pytest.raises(
            InputError, match=r"runs: no column tau \(given for drive\): there are t"
        ):
            read_runs({"t": [0.0]}, {"drive": "tau"}, {})
        with pytest.raises(InputError, match="not columns of one length"):
            read_runs({"t": [0.0], "x": [0.0, 1.0]}, {}, {})


@pytest.mark.usefixtures("files")
class TestCommand:
    @pytest.fixture
    def files(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "n.toml").write_text(NOMINAL)
        runs = measured({"drive_lag": {"T": 0.02}}, driven(step=0.005))
        table(runs).write_csv(tmp_path / "r.csv")

    @staticmethod
    def run(capsys, *arguments):
        code = main(["screen", *arguments])
        done = capsys.readouterr()
        return code, done.out, done.err

    def test_lists_singles_and_pairs(self, capsys):
        code, out, err = self.run(capsys, "r.csv", "--nominal", "n.toml", "--pairs", "2")
        assert code == 0
        assert all(line.startswith("locosweep: note: ") for line in err.splitlines())
        head, *lines = out.splitlines()
        said = r"equation error of the nominal model: \S+ times the noise \(mean squares\), "
        assert re.match(said + r"in \d+ slides of 3 of 3 runs; it does not see presliding_", head)
        at = next(i for i, line in enumerate(lines) if line.startswith("effect "))
        assert re.match(r"drive_lag +\S+ +\S+%  T = 0\.0\d+ s$", lines[at + 1])
        pairs = next(i for i, line in enumerate(lines) if line.startswith("pair "))
        assert len(lines[pairs:]) == 5
        assert " + " in lines[pairs + 1]
        assert lines[-1].startswith("a screen, no verdict")

    def test_json(self, capsys):
        code, out, _ = self.run(
            capsys, "r.csv", "--nominal", "n.toml", "--pairs", "0", "--threads", "1", "--json"
        )
        found = json.loads(out)
        assert code == 0
        assert found["effects"][0]["effects"] == ["drive_lag"]
        assert found["effects"][0]["parameters"][0]["unit"] == "s"
        assert found["ranks"] is True
        assert "presliding_compliance" in found["unseen"]

    def test_their_names_and_units(self, capsys):
        frame = pl.read_csv("r.csv").with_columns(pl.col("x") * 1e3).rename({"drive": "tau"})
        frame.write_csv("theirs.csv")
        given = ("--nominal", "n.toml", "--pairs", "0", "--json")
        _, plain, _ = self.run(capsys, "r.csv", *given)
        code, out, _ = self.run(
            capsys, "theirs.csv", *given, "--column", "drive=tau", "--unit", "x=mm"
        )
        assert code == 0
        first = [json.loads(text)["effects"][0] for text in (plain, out)]
        assert first[0]["effects"] == first[1]["effects"]
        assert first[0]["mean_square"] == pytest.approx(first[1]["mean_square"])

    def test_no_slides_are_one_line_and_code_1(self, capsys):
        t = np.arange(0.0, 1.0, 0.01)
        x = np.random.default_rng(0).normal(0.0, 1e-5, t.size)
        pl.DataFrame({"t": t, "drive": 0.0 * t, "x": x}).write_csv("still.csv")
        code, out, err = self.run(capsys, "still.csv", "--nominal", "n.toml")
        assert (code, out) == (1, "")
        assert err.count("\n") == 1
        assert err.startswith("locosweep: no run slides long enough in one direction")

    @pytest.mark.parametrize(
        "arguments",
        [
            ("r.csv",),
            ("no.csv", "--nominal", "n.toml"),
            ("r.csv", "--nominal", "no.toml"),
            ("r.csv", "--nominal", "n.toml", "--pairs", "-1"),
            ("r.csv", "--nominal", "n.toml", "--column", "drive"),
            ("r.csv", "--nominal", "n.toml", "--unit", "x=blorp"),
            ("n.toml", "--nominal", "n.toml"),
        ],
    )
    def test_bad_input_is_one_line(self, capsys, arguments):
        code, out, err = self.run(capsys, *arguments)
        assert (code, out) == (2, "")
        assert err.count("\n") == 1
        assert err.startswith("locosweep: ")
