"""Runs that leave all bounds: a status and no values, never a huge number that is ok."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.plot import motion
from locosweep.registry import Status
from locosweep.simulation.replay import replay_runs

MU = {"mu_static": 0.5, "mu_coulomb": 0.3}
DIVERGING = [
    ("coulomb", "ramp", "runge_kutta",
     {"mass": 0.78, "drive_amplitude": 9.33, "duration": 0.01, "time_step": 2e-4,
      "spring_stiffness": 2872.0, "spring_damping": 24868.0, "start_speed": -1e6}),
    ("patch", "ramp", None,
     {"mass": 0.0328, "drive_amplitude": 7823.0, "duration": 0.0376, "time_step": 0.0392,
      "viscous": 37736.0, "start_speed": 1000.0}),
    ("load_viscous", "sine", None,
     {"mass": 7.41e-4, "drive_amplitude": 1.963e6, "duration": 0.0232, "time_step": 0.0156,
      "viscous": 3.19}),
    ("hess_soom", "ramp", "runge_kutta",
     {"mass": 0.516, "drive_amplitude": 6299.0, "duration": 3.05, "time_step": 7.77e-3,
      "viscous": 1641.0}),
    ("quadratic", "ramp", "dormand_prince_fixed",
     {"mass": 85.1, "drive_amplitude": 1.27e5, "duration": 0.0196, "time_step": 0.091,
      "viscous": 1.28, "quadratic": 414.0, "start_speed": -1e6}),
    ("dahl", "constant", "rosenbrock_fixed",
     {"mass": 63.3, "drive_force": 3.3e8, "duration": 0.0061, "time_step": 0.0526,
      "bristle_stiffness": 1.19e5}),
    ("lugre", "sine", "rosenbrock_fixed",
     {"mass": 3.08, "drive_amplitude": 9.3e7, "duration": 0.556, "time_step": 0.02,
      "stribeck_speed": 5.08e-3, "bristle_stiffness": 2.62}),
]  # fmt: skip
"""Found by random search: each ended in a huge finite number with the status ok. The last one has
longer steps now, as those of order four follow it where it was found."""

T = 0.005 * np.arange(600)
NOMINAL = {"segments": 4.0, "mass": 0.271, "mu_coulomb": 0.15}
GROWS = {"viscous_friction": {"c": -300.0}}
MODEL = "".join(
    f"{key} = {value}\n" for key, value in
    [("robot.segments", 4), ("robot.mass", NOMINAL["mass"]),
     ("surface.mu_coulomb", NOMINAL["mu_coulomb"]),
     ("effects.viscous_friction.c", GROWS["viscous_friction"]["c"])]
)  # fmt: skip
"""The same as a file."""


def pushed(label: str, force: float) -> Run:
    return Run(label, T, np.where(T < 0.1, 0.0, force), {"x": np.zeros(T.size)})


class TestSegments:
    @pytest.mark.parametrize(("law", "drive", "method", "values"), DIVERGING)
    def test_a_run_that_diverges_is_never_ok(self, law, drive, method, values):
        for name in ("final_position", "final_speed", "peak_motion"):
            found = ls.sweep(name, law=law, drive=drive, method=method, **MU, **values)
            assert np.isnan(found.values)
            assert found.status == Status.DIVERGED

    def test_stiff_steps_far_longer_than_a_bristle_takes_to_bend_are_unresolved(self):
        given = {"law": "dahl", "mass": 0.3, "drive_force": 0.5, "bristle_stiffness": 1e5, **MU}
        coarse = ls.sweep("final_position", method="rosenbrock_fixed", time_step=0.01, **given)
        assert coarse.status == Status.UNRESOLVED
        fine = ls.sweep("final_position", method="rosenbrock_fixed", time_step=1e-4, **given)
        assert fine.status == Status.OK
        exact = ls.sweep("final_position", tolerance=1e-9, **given)
        assert float(fine.values) == pytest.approx(float(exact.values), rel=1e-4)

    @pytest.mark.slow
    def test_stiff_steps_of_any_length_that_miss_all_of_the_motion_are_not_ok(self):
        rng = np.random.default_rng(1)
        right = wrong = refused = 0
        for law in ("dahl", "lugre", "elasto_plastic", "maxwell_slip", "gonthier") * 30:
            mass = 10 ** rng.uniform(-2, 1)
            drive = str(rng.choice(["constant", "sine", "ramp", "pulse"]))
            name = "drive_force" if drive == "constant" else "drive_amplitude"
            given = {"law": law, "drive": drive, "mass": mass, **MU,
                     name: mass * 9.81 * 10 ** rng.uniform(-1.5, 1.0),
                     "bristle_stiffness": 10 ** rng.uniform(2, 6),
                     "duration": 10 ** rng.uniform(-1, 0.5)}  # fmt: skip
            step = 10 ** rng.uniform(-4, -1.5)
            fixed = ls.sweep("final_position", method="rosenbrock_fixed", time_step=step, **given)
            if fixed.status == Status.UNRESOLVED:
                refused += 1
            elif fixed.status == Status.OK:
                exact, peak = (float(ls.sweep(quantity, tolerance=1e-8, **given).values)
                               for quantity in ("final_position", "peak_motion"))  # fmt: skip
                off = abs(float(fixed.values) - exact)
                right += off <= 1e-2 * abs(peak) + 1e-6
                wrong += off > abs(peak) + 1e-6
        assert wrong == 0
        assert right > 100
        assert refused > 5

    def test_motion_ends_where_it_diverges(self):
        law, drive, method, values = DIVERGING[0]
        run = ls.simulate(law=law, drive=drive, method=method, **MU, **values, samples=51)
        assert run.status == Status.DIVERGED
        gone = np.isnan(run.x)
        assert not gone[0]
        assert gone[-1]
        first = int(np.argmax(gone))
        for field in (run.x, run.v, run.force, run.way):
            assert np.isfinite(field[:first]).all()
            assert np.isnan(field[first:]).all()

    def test_picture_says_which_curve_ends(self):
        given = {"law": "dahl", "method": "rosenbrock_fixed", "time_step": 0.05, "mass": 0.3}
        ends = "diverged, no values from 0.1 s on"
        several = motion(ls.simulate(**given, **MU, drive_force=[0.1, 1e8], samples=11))[0]
        words = [text.get_text() for text in several.get_legend().get_texts()]
        assert words == ["$F_0$ = 0.1 N", f"$F_0$ = 1e+08 N,\n{ends}"]
        one = motion(ls.simulate(**given, **MU, drive_force=1e8, samples=11))[0]
        assert one.get_title(loc="left").endswith(f"\n{ends}")

    def test_a_law_that_lacks_a_level_of_friction_is_bounded_too(self):
        found = ls.sweep("final_speed", law="coulomb_viscous", mu_coulomb=0.3, drive_force=1.0)
        assert found.status == Status.OK

    @pytest.mark.parametrize("pull", [-1e3, 0.0, 0.3, 1e6])
    def test_what_forces_can_do_is_kept(self, pull):
        """A free fall keeps all that it is given, a spring throws what it holds."""
        free = {"mu_static": 0.0, "mu_coulomb": 0.0, "law": "coulomb"}
        fall = ls.sweep("final_speed", slope_deg=-90.0, start_position=1e6, **free)
        assert float(fall.values) == pytest.approx(9.81)
        thrown = ls.sweep("final_speed", pull_speed=pull, spring_stiffness=2e3, mass=0.3,
                          start_position=0.5, time_step=1e-4, **free)  # fmt: skip
        assert thrown.status == Status.OK

    def test_command_names_curve_and_time(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        arguments = ["--law", "dahl", "--method", "rosenbrock_fixed", "--set", "mu_static=.5",
                     "--set", "mu_coulomb=.3", "--set", "mass=0.3", "--set", "time_step=.05",
                     "--set", "drive_force=0.1,1e8", "--samples", "11"]  # fmt: skip
        assert main(["simulate", *arguments, "--out", "a.csv", "--plot", "a.png"]) == 1
        err = capsys.readouterr().err.splitlines()
        assert err[-1].startswith("locosweep: drive_force=1e+08: no values from 0.1 s on")
        assert "diverged" in err[-1]
        frame = pl.read_csv("a.csv")
        assert frame.filter(pl.col("drive_force") == 0.1)["x"].is_finite().all()
        assert frame["x"].is_infinite().sum() == 0
        assert frame["x"].is_nan().sum() == 10

    def test_json_has_no_ledger_where_no_curve_has_one(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        arguments = ["--law", "dahl", "--method", "rosenbrock_fixed", "--set", "mu_static=.5",
                     "--set", "mu_coulomb=.3", "--set", "mass=0.3", "--set", "time_step=.05",
                     "--set", "drive_force=1e8", "--samples", "11"]  # fmt: skip
        assert main(["simulate", *arguments, "--out", "a.csv", "--json"]) == 1
        report = json.loads(capsys.readouterr().out)
        assert report["curves_with_values"] == 0
        assert report["energy_residual"] is None


class TestReplays:
    @pytest.mark.parametrize(
        "effects",
        [
            {"viscous_friction": {"c": -300.0}},
            {"viscous_friction": {"c": -278156.0}},
            {"quadratic_drag": {"c2": -1.4e6}},
            {"quadratic_drag": {"c2": -9.8}, "sensor_delay": {"T": -655.0}},
            {"viscous_friction": {"c": -300.0}, "sensor_delay": {"T": -0.05}},
            {"back_emf": {"k_e": -240.0}},
        ],
    )
    def test_no_reading_is_huge(self, effects):
        frame = replay_runs(Robot(NOMINAL, {}, effects), [pushed("a", 2.0)])
        gone = frame["x"].is_nan().to_numpy()
        assert gone[-1]
        first = int(np.argmax(gone))
        for name in ("x", "v", "x_rear", "force"):
            values = frame[name].to_numpy()
            assert np.isfinite(values[:first]).all(), name
            assert np.isnan(values[first:]).all(), name

    def test_runs_that_stay_are_kept(self):
        runs = [pushed("a", 0.0), pushed("b", 2.0)]
        frame = replay_runs(Robot(NOMINAL, {}, GROWS), runs)
        alone = replay_runs(Robot(NOMINAL, {}, GROWS), runs[:1])
        assert frame.head(600).equals(alone)
        assert frame.head(600)["x"].is_finite().all()

    def test_command_names_run_and_time(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "m.toml").write_text(MODEL)
        runs = [(label, pushed(label, force)) for label, force in (("a", 0.0), ("b", 2.0))]
        pl.concat(
            [
                pl.DataFrame(
                    {"run": [label] * T.size, "t": T + 1e9, "drive": run.drive, "x": 0.0 * T}
                )
                for label, run in runs
            ]
        ).write_csv("r.csv")
        code = main(["simulate", "--model", "m.toml", "--runs", "r.csv", "--out", "p.csv"])
        assert code == 1
        note, err = capsys.readouterr().err.splitlines()
        assert note.endswith("t is Unix time: times count from the start of each run")
        assert err.startswith("locosweep: p.csv: run b leaves all bounds")
        frame = pl.read_csv("p.csv")
        first = frame.filter(pl.col("x").is_nan())["t"][0]
        assert f"from {first:g} s on" in err
        assert not frame["x"].is_infinite().any()

    def test_derivatives_end_with_the_readings(self):
        robot = Robot(NOMINAL, {}, GROWS)
        plain = replay_runs(robot, [pushed("b", 2.0)])
        names = ["viscous_friction.c", "gain_share"]
        frame = replay_runs(robot, [pushed("b", 2.0)], sensitivities=names)
        gone = plain["x"].is_nan()
        assert frame["x"].is_nan().equals(gone)
        for name in names:
            assert frame[f"x_by_{name}"].filter(gone).is_nan().all()
            assert frame[f"x_by_{name}"].filter(~gone).is_finite().all()

    def test_a_head_without_mass_is_refused(self):
        robot = Robot(NOMINAL, {}, {"payload_mass": {"dm": -5.0}})
        with pytest.raises(InputError, match=r"payload_mass\.dm is -5\.0 kg: allowed is more than"):
            replay_runs(robot, [pushed("a", 2.0)])
