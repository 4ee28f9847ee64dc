"""Friction laws fitted to measured motion: recovery, intervals, hold-out, bad input."""

import json
import os
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep import _core
from locosweep.cli import main
from locosweep.friction_fit import read_friction
from locosweep.friction_fit.prepare import prepare

DATA = os.environ.get("LOCOSWEEP_DATA")
NOISE = 0.01

# What each law adds to mu_coulomb = 0.6 and viscous = 1.0.
PLANTED = {
    "coulomb": {},
    "coulomb_viscous": {},
    "quadratic": {"quadratic": 60.0},
    "power_drag": {"power_drag": 8.0, "power_exponent": 0.8},
    "static_coulomb": {"mu_static": 0.9},
    "static_viscous": {"mu_static": 0.9},
    "tustin": {"mu_static": 1.1, "stribeck_speed": 0.01},
    "bo_pavelescu": {"mu_static": 1.1, "stribeck_speed": 0.01, "stribeck_exponent": 0.7},
    "stribeck": {"mu_static": 1.1, "stribeck_speed": 0.01},
    "hess_soom": {"mu_static": 1.1, "stribeck_speed": 0.01},
    "modelica": {"mu_static": 1.1, "modelica_decay": 90.0},
    "load_friction": {"load_friction": 0.2},
    "load_viscous": {"viscous_load": 2.0, "load_exponent": 1.0},
    "directional": {"skin_ratio": 1.6},
    "ripple": {"ripple_amplitude": 0.4, "ripple_length": 0.012, "ripple_phase_deg": 40.0},
    "patch": {"patch_start": 0.02, "patch_length": 0.025, "patch_ratio": 1.8},
    "track": {"track_length": 0.08, "track_2": 1.3, "track_3": 1.6, "track_5": 0.7},
    "buildup": {"buildup": 6.0, "buildup_root": 0.5},
    "mixed": {"mu_static": 0.9, "mixed_speed": 0.02, "mixed_exponent": 1.0, "viscous": 5.0},
    "tanh": {"transition_speed": 0.005},
    "threlfall": {"transition_speed": 0.02},
    "bengisu_akay": {"mu_static": 1.0, "transition_speed": 0.01},
    "brown_mcphee": {"mu_static": 1.0, "transition_speed": 0.01},
    "simscape": {"mu_static": 1.0, "transition_speed": 0.01},
    "dahl": {"bristle_stiffness": 400.0},
    "lugre": {"mu_static": 0.9, "stribeck_speed": 0.02, "bristle_stiffness": 400.0,
              "bristle_damping": 1.0},
    "elasto_plastic": {"mu_static": 0.9, "stribeck_speed": 0.02, "bristle_stiffness": 400.0,
                       "bristle_damping": 1.0},
    "maxwell_slip": {"mu_static": 0.9, "stribeck_speed": 0.02, "bristle_stiffness": 400.0},
    "gonthier": {"mu_static": 0.9, "stribeck_speed": 0.02, "bristle_stiffness": 400.0,
                 "bristle_damping": 4.0, "dwell_time": 0.5},
}  # fmt: skip


def motion(count=1200, *, dwell=False):
    """Back and forth at many speeds; with rests where `dwell`."""
    t = np.linspace(0.0, 12.0, count)
    fine = np.linspace(0.0, 12.0, 40 * count)
    v = 0.04 * np.sin(1.3 * fine) + 0.02 * np.sin(3.1 * fine)
    if dwell:
        v = np.where(np.abs(v) < 0.012, 0.0, v)
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(fine))])
    return t, np.interp(t, fine, x), np.interp(t, fine, v)


def planted(law, given, *, seed=1, noise=NOISE, dwell=False, load=None, count=1200):
    """Measured data whose friction is a law of the registry."""
    t, x, v = motion(count, dwell=dwell)
    drive = 3.0 * np.sin(0.9 * t)
    known = _names(law)
    values = {"mu_static": 0.6, "mu_coulomb": 0.6, "viscous": 1.0} | given
    pairs = [(name, float(value)) for name, value in values.items() if name in known]
    normal = np.ones_like(t) if load is None else load
    force = _core.imposed_force(law, pairs, t, x, v, normal, drive, 1e-5)
    rest = np.abs(v) <= 1e-5
    if dwell:
        # At rest friction is what is pushed with, up to what it holds.
        force = np.where(rest, force * _ramps(rest), force)
    noise = np.random.default_rng(seed).normal(0.0, noise, t.size)
    data = {"t": t, "x": x, "v": v, "force": force + noise}
    if "load_friction" in known:
        data["drive"] = drive
    if load is not None:
        data["load"] = load
    return data, dict(pairs)


def _names(law):
    return {p.name for p in next(one for one in ls.laws() if one.name == law).parameters}


def _ramps(rest):
    """Share that rises from 0 to 1 over each rest."""
    share = np.ones(rest.size)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rest.astype(int), [0]])))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        share[begin:end] = np.linspace(0.0, 1.0, end - begin)
    return share


class TestRecovery:
    @pytest.mark.parametrize("law", [law.name for law in ls.laws()])
    def test_every_law_is_found_again(self, law):
        t = motion()[0]
        load = 1.0 + 0.6 * np.sin(0.37 * t) if law == "load_viscous" else None
        dwell = law in ("static_coulomb", "static_viscous")
        data, true = planted(law, PLANTED[law], dwell=dwell, load=load)
        fit = ls.fit_friction(data, laws=[law])
        own = next(one for one in fit.laws if one.law == law)
        # Nothing but the noise that was put in is left, on samples held out too.
        assert own.rms == pytest.approx(NOISE, rel=0.12)
        assert own.held_out_rms == pytest.approx(NOISE, rel=0.2)
        clean, _ = planted(law, PLANTED[law], noise=0.0, dwell=dwell, load=load)
        run = fit.data.runs[0]
        same = np.searchsorted(clean["t"], run.t[run.rows])
        off = own.predicted - clean["force"][same]
        assert np.sqrt(np.mean(off**2)) < 0.4 * NOISE
        for name in ("mu_coulomb", "mu_static"):
            if name not in true or own.parameters[name].std is None:
                continue
            found = own.parameters[name]
            assert abs(found.value - true[name]) < 5.0 * found.std + 0.02 * true[name]

    @pytest.mark.slow
    @pytest.mark.parametrize("seed", range(2, 9))
    @pytest.mark.parametrize("law", ["lugre", "elasto_plastic"])
    def test_bristles_are_found_under_other_noise(self, law, seed):
        data, _ = planted(law, PLANTED[law], seed=seed)
        own = ls.fit_friction(data, laws=[law]).chosen
        assert own.rms == pytest.approx(NOISE, rel=0.12)

    def test_every_law_is_planted(self):
        assert set(PLANTED) == {law.name for law in ls.laws()}

    def test_mass_and_drive_stand_in_for_force(self):
        """Simulated by the engine: friction is drive less mass times acceleration."""
        run = ls.simulate(
            law="lugre", drive="sine", mu_static=0.4, mu_coulomb=0.3, viscous=2.0, mass=0.5,
            drive_amplitude=4.0, drive_frequency=0.7, duration=6.0, bristle_stiffness=1e5,
            samples=3001,
        )  # fmt: skip
        data = {"t": run.t, "x": run.x, "drive": run.force}
        fit = ls.fit_friction(data, mass=0.5, laws=["coulomb", "coulomb_viscous"])
        assert fit.chosen.law == "coulomb_viscous"
        found = fit.chosen.parameters
        assert found["mu_coulomb"].value == pytest.approx(0.3, rel=0.06)
        assert found["viscous"].value == pytest.approx(2.0, rel=0.1)

    def test_static_level_only_shows_where_a_push_ends_a_rest(self):
        data, _ = planted("static_viscous", PLANTED["static_viscous"], dwell=True)
        fit = ls.fit_friction(data, laws=["static_viscous", "coulomb_viscous"])
        assert fit.data.breakaways > 3
        assert fit.chosen.law == "static_viscous"
        assert fit.chosen.parameters["mu_static"].value == pytest.approx(0.9, abs=0.02)
        moving, _ = planted("static_viscous", PLANTED["static_viscous"])
        fit = ls.fit_friction(moving, laws=["static_viscous", "coulomb_viscous"])
        assert fit.chosen.law == "coulomb_viscous"
        static = next(one for one in fit.laws if one.law == "static_viscous")
        assert static.parameters["mu_static"].std is None

    @pytest.mark.slow
    def test_intervals_cover(self):
        """95 % intervals hold the truth about so often, with noise that has a memory."""
        held = {"mu_coulomb": 0, "viscous": 0}
        count = 60
        for seed in range(count):
            data, true = planted("coulomb_viscous", {}, noise=0.0, count=800)
            white = np.random.default_rng(seed).normal(0.0, NOISE, 800)
            noise = np.empty(800)
            state = white[0]
            for i, step in enumerate(white):
                state = 0.7 * state + step
                noise[i] = state
            data["force"] = data["force"] + noise
            fit = ls.fit_friction(data, laws=["coulomb_viscous"])
            own = next(one for one in fit.laws if not one.offset)
            assert own.memory > 2.5
            for name in held:
                low, high = own.parameters[name].interval
                held[name] += low < true[name] < high
        # Binomial with 0.95: fewer than 51 of 60 has a chance of 0.2 %.
        assert all(51 <= number <= count for number in held.values()), held


class TestLoad:
    @staticmethod
    def runs(force, *, loads=(20.0, 60.0, 100.0, 140.0), seed=3):
        rng = np.random.default_rng(seed)
        t, x, v = motion(600)
        parts = []
        for i, level in enumerate(loads):
            load = level * (1.0 + 0.01 * np.sin(t))
            measured = force(v, load) + rng.normal(0.0, NOISE, t.size)
            parts.append(pl.DataFrame({"run": [f"r{i}"] * t.size, "t": t, "x": x, "v": v,
                                       "force": measured, "load": load}))  # fmt: skip
        return pl.concat(parts)

    def test_a_coefficient_and_an_area_error_are_told_apart(self):
        frame = self.runs(lambda v, load: 0.03 * load * np.sign(v) + 0.01 * load)
        fit = ls.fit_friction(frame, laws=["coulomb", "coulomb_viscous"], holdout=["r2"])
        assert (fit.chosen.law, fit.chosen.load, fit.chosen.gain) == (
            "coulomb", "proportional", True
        )  # fmt: skip
        assert fit.chosen.parameters["mu_coulomb"].value == pytest.approx(0.03, rel=0.01)
        assert fit.chosen.parameters["load_gain"].value == pytest.approx(0.01, rel=0.02)
        assert fit.data.held_out == ["r2"]
        assert fit.shrink > 0.9

    def test_a_preload_is_found(self):
        frame = self.runs(lambda v, load: 0.03 * (load + 80.0) * np.sign(v))
        fit = ls.fit_friction(frame, laws=["coulomb"])
        assert (fit.chosen.load, fit.chosen.offset) == ("affine", False)
        assert fit.chosen.parameters["preload"].value == pytest.approx(80.0, rel=0.03)

    def test_no_dependence_is_said(self):
        frame = self.runs(lambda v, _: 2.0 * np.sign(v))
        fit = ls.fit_friction(frame, laws=["coulomb", "coulomb_viscous"])
        assert (fit.chosen.law, fit.chosen.load) == ("coulomb", "constant")
        assert len(fit.chosen.parameters) == 1

    def test_held_out_runs_are_not_fitted_to(self):
        frame = self.runs(lambda v, load: 0.03 * load * np.sign(v))
        broken = frame.with_columns(
            pl.when(pl.col("run") == "r3").then(9.0).otherwise(pl.col("force")).alias("force")
        )
        candidate = [_core.FrictionCandidate("coulomb", "proportional")]
        found = []
        for one in (frame, broken):
            data = prepare(read_friction(one)[0], holdout=["r3"])
            outcome = data.core().fit(candidate, 1)[0]
            left = data.column("force") - outcome.held_out
            found.append((outcome.rms, outcome.predicted.tobytes(), np.nanstd(left)))
            assert np.isfinite(left).sum() == data.lengths[3]
        assert found[0][:2] == found[1][:2]
        assert found[0][2] < 1.5 * NOISE
        assert found[1][2] > 1.0


class TestVerdict:
    def test_ties_are_said_and_the_simplest_is_chosen(self):
        data, _ = planted("coulomb_viscous", {})
        fit = ls.fit_friction(data, laws=["coulomb", "coulomb_viscous", "static_viscous",
                                          "quadratic", "stribeck"])  # fmt: skip
        assert fit.chosen.law == "coulomb_viscous"
        assert {"static_viscous", "quadratic", "stribeck"} <= {one.law for one in fit.no_better}
        coulomb = next(one for one in fit.laws if one.law == "coulomb")
        assert not coulomb.tied
        assert coulomb.sigmas > 3

    def test_two_forms_of_the_same_curve_tie(self):
        data, _ = planted("tustin", PLANTED["tustin"])
        fit = ls.fit_friction(data, laws=["tustin", "modelica", "coulomb"])
        assert fit.status == "tie"
        assert {fit.chosen.law, *(one.law for one in fit.equal)} == {"tustin", "modelica"}

    def test_what_is_left_is_told_by_its_variable(self):
        data, _ = planted("ripple", PLANTED["ripple"] | {"ripple_length": 0.05})
        fit = ls.fit_friction(data, laws=["coulomb_viscous"])
        assert max(fit.left, key=fit.left.get) == "x"
        assert fit.left["x"] > 0.3
        assert "position" in fit.summary

    def test_velocity_from_position(self):
        data, _ = planted("coulomb_viscous", {})
        del data["v"]
        data["x"] = data["x"] + np.random.default_rng(5).normal(0.0, 2e-5, data["x"].size)
        fit = ls.fit_friction(data, laws=["coulomb", "coulomb_viscous"])
        assert fit.chosen.law == "coulomb_viscous"
        assert fit.chosen.parameters["viscous"].value == pytest.approx(1.0, rel=0.1)

    def test_same_bits_whatever_the_threads(self):
        data, _ = planted("stribeck", PLANTED["stribeck"])
        laws = ["coulomb", "stribeck", "tanh"]
        one = ls.fit_friction(data, laws=laws, threads=1).to_dict()
        assert one == ls.fit_friction(data, laws=laws, threads=3).to_dict()

    def test_a_lone_fault_of_the_sensor_is_left_out(self):
        data, _ = planted("coulomb", {})
        data["force"][500] = 1e6
        fit = ls.fit_friction(data, laws=["coulomb"])
        assert fit.chosen.parameters["mu_coulomb"].value == pytest.approx(0.6, rel=0.02)
        assert any("stand alone" in notice for notice in fit.notices)

    def test_a_break_away_is_no_fault(self):
        data, _ = planted("static_coulomb", PLANTED["static_coulomb"], dwell=True)
        fit = ls.fit_friction(data, laws=["static_coulomb"])
        assert not any("stand alone" in notice for notice in fit.notices)


@pytest.fixture
def call(tmp_path, monkeypatch, capsys):
    """Run the command here: code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code = main(["friction", *(str(part) for part in arguments)])
        done = capsys.readouterr()
        return code, done.out, done.err

    return run


@pytest.fixture
def refused(call, tmp_path):
    """Run what must fail: its one line; nothing may have been written."""

    def run(*arguments):
        before = sorted(tmp_path.rglob("*"))
        code, out, err = call(*arguments)
        assert (code, out) == (2, ""), err
        assert err.startswith("locosweep: ")
        assert err.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before
        return err

    return run


def table(folder, data=None, name="data.csv", **columns):
    frame = pl.DataFrame(data if data is not None else planted("coulomb_viscous", {})[0])
    frame = frame.with_columns(**columns)
    path = folder / name
    if path.suffix == ".parquet":
        frame.write_parquet(path)
    else:
        frame.write_csv(path)
    return path


@pytest.mark.whole
@pytest.mark.whole
class TestCommand:
    LAWS = ("--law", "coulomb", "--law", "coulomb_viscous")

    def test_report_and_pictures(self, call, tmp_path):
        path = table(tmp_path)
        code, out, _ = call(path, "--out", "found", *self.LAWS)
        assert code == 0
        assert "coulomb_viscous" in out
        folder = tmp_path / "found"
        assert sorted(f.name for f in folder.iterdir()) == [
            "characteristic.png", "force.png", "friction.json", "friction.md", "laws.png",
            "residuals.png",
        ]  # fmt: skip
        report = json.loads((folder / "friction.json").read_text())
        assert report["verdict"]["law"] == "coulomb_viscous"
        assert report["laws"][0]["parameters"]["viscous"]["unit"] == "N s/m"
        assert len(report["provenance"]["data_sha256"]) == 64
        assert (folder / "characteristic.png").read_bytes()[1:4] == b"PNG"

    def test_same_report_twice_and_a_full_folder_is_refused(self, call, refused, tmp_path):
        path = table(tmp_path, name="data.parquet")
        assert call(path, "--out", "a", "--quiet", *self.LAWS) == (0, "", "")
        # Pictures also hold the command, which differs.
        names = ("friction.json", "friction.md")
        first = [(tmp_path / "a" / name).read_bytes() for name in names]
        assert "not empty" in refused(path, "--out", "a", *self.LAWS)
        assert call(path, "--out", "a", "--quiet", "--force", *self.LAWS)[0] == 0
        assert [(tmp_path / "a" / name).read_bytes() for name in names] == first

    def test_columns_and_units_of_others(self, call, tmp_path):
        data, _ = planted("coulomb_viscous", {})
        frame = {"zeit": data["t"], "weg": data["x"] * 1e3, "kraft": data["force"]}
        path = table(tmp_path, frame)
        options = ("--column", "t=zeit", "--column", "x=weg", "--column", "force=kraft",
                   "--unit", "x=mm")  # fmt: skip
        code, out, _ = call(path, "--out", "o", *options, "--json", *self.LAWS)
        report = json.loads(out)
        assert code == 0
        best = next(law for law in report["laws"] if law["law"] == "coulomb_viscous")
        assert best["parameters"]["mu_coulomb"]["value"] == pytest.approx(0.6, rel=0.05)

    @pytest.mark.parametrize(
        ("change", "options", "words"),
        [
            ({"drop": ["t"]}, (), ["no column t"]),
            ({"drop": ["force"]}, (), ["no column force", "drive"]),
            ({"drop": ["x", "v"]}, (), ["no column x", "v"]),
            ({"rename": {"force": "drive"}}, (), ["mass is missing"]),
            ({}, ("--law", "coulom"), ["coulom", "did you mean 'coulomb'"]),
            ({}, ("--holdout", "7"), ["holdout", "unknown run '7'"]),
            ({}, ("--holdout", "0"), ["every run"]),
            ({}, ("--runs", "3"), ["unknown run '3'"]),
            ({}, ("--holdout", ","), ["--holdout"]),
            ({}, ("--unit", "x=blorp"), ["blorp"]),
            ({}, ("--unit", "force"), ["--unit"]),
            ({}, ("--column", "force=cell"), ["no column cell"]),
            ({}, ("--mass", "-1"), ["mass", "-1"]),
        ],
    )
    def test_bad_options(self, refused, tmp_path, change, options, words):
        frame = pl.DataFrame(planted("coulomb_viscous", {})[0])
        frame = frame.drop(change.get("drop", [])).rename(change.get("rename", {}))
        err = refused(table(tmp_path, frame), "--out", "o", *options)
        assert all(word in err for word in words), err

    def test_bad_files(self, refused, tmp_path):
        frame = pl.DataFrame(planted("coulomb_viscous", {})[0])
        words = frame.cast(pl.String).with_columns(
            force=pl.when(pl.int_range(pl.len()) == 41).then(pl.lit("heavy")).otherwise("force")
        )
        err = refused(table(tmp_path, words), "--out", "o")
        assert "row 42" in err
        assert "column force" in err
        assert "'heavy'" in err
        back = frame.with_columns(t=frame["t"].reverse())
        assert "time must rise" in refused(table(tmp_path, back), "--out", "o")
        assert "samples" in refused(table(tmp_path, frame.head(5)), "--out", "o")
        infinite = frame.with_columns(force=pl.lit(float("inf")))
        assert "infinite" in refused(table(tmp_path, infinite), "--out", "o")
        gone = frame.with_columns(force=pl.lit(None, dtype=pl.Float64))
        assert "column force: no values" in refused(table(tmp_path, gone), "--out", "o")
        still = frame.with_columns(v=0.0)
        assert "never move" in refused(table(tmp_path, still), "--out", "o")
        fake = tmp_path / "fake.parquet"
        fake.write_text("t,x,force\n1,2,3\n")
        assert "not a readable Parquet" in refused(fake, "--out", "o")
        (tmp_path / "empty.csv").write_text("")
        assert "empty" in refused(tmp_path / "empty.csv", "--out", "o")
        assert "no such file" in refused(tmp_path / "none.csv", "--out", "o")

    def test_one_way_at_one_speed_is_a_tie_not_an_answer(self, call, tmp_path):
        """A constant velocity shows one number: no law is told from another."""
        rng = np.random.default_rng(2)
        t = np.linspace(0.0, 5.0, 500)
        force = 0.7 + rng.normal(0.0, NOISE, t.size)
        path = table(tmp_path, {"t": t, "x": 0.02 * t, "force": force})
        code, out, _ = call(path, "--out", "o", "--json", "--law", "coulomb", "--law", "stribeck",
                            "--law", "coulomb_viscous")  # fmt: skip
        report = json.loads(out)
        assert code == 0
        assert report["verdict"]["law"] == "coulomb"
        assert {"coulomb_viscous", "stribeck"} <= {
            n.split()[0] for n in report["verdict"]["no_better"]
        }

    def test_missing_values_are_left_out_with_a_note(self, call, tmp_path):
        data, _ = planted("coulomb_viscous", {})
        data["force"][100:110] = np.nan
        path = table(tmp_path, data)
        code, _, err = call(path, "--out", "o", *self.LAWS)
        assert code == 0
        assert "10 samples with a missing value" in err


class TestWhatWasNotMeasured:
    """Levels that no speed measured shows, and levels that rise."""

    FALLING = ("stribeck", "hess_soom", "tustin", "modelica")

    @staticmethod
    def rising(noise=NOISE):
        """Force that rises with speed and bends towards a level beyond the speeds measured."""
        t, x, v = motion()
        force = np.sign(v) * (0.4 + 1.2 * (1 - np.exp(-np.abs(v) / 0.08)))
        return {"t": t, "x": x, "v": v,
                "force": force + np.random.default_rng(3).normal(0, noise, t.size)}  # fmt: skip

    def test_static_friction_is_never_below_coulomb_friction(self):
        fit = ls.fit_friction(self.rising(), laws=self.FALLING)
        for law in fit.laws:
            levels = law.parameters["mu_static"], law.parameters["mu_coulomb"]
            assert levels[0].value >= levels[1].value, law.name

    def test_a_level_beyond_the_speeds_measured_is_said(self):
        data, _ = planted("stribeck", {"mu_static": 1.1, "stribeck_speed": 0.09})
        fit = ls.fit_friction(data, laws=["stribeck"])
        assert any("mu_coulomb lies beyond" in remark for remark in fit.chosen.remarks)
        report = fit.to_dict()
        assert report["laws"][0]["remarks"] == fit.chosen.remarks
        seen, _ = planted("stribeck", {"mu_static": 1.1, "stribeck_speed": 0.01})
        assert not ls.fit_friction(seen, laws=["stribeck"]).chosen.remarks

    def test_a_parameter_at_its_end_is_said_and_does_not_win(self):
        data, _ = planted("coulomb_viscous", {})
        laws = ["coulomb_viscous", "stribeck", "hess_soom", "modelica"]
        fit = ls.fit_friction(data, laws=laws)
        assert fit.chosen.law == "coulomb_viscous"
        assert not fit.chosen.remarks
        for law in fit.laws:
            ends = [p for p in law.parameters.values() if p.bounded]
            assert len([r for r in law.remarks if "end of its range" in r]) == len(ends)

    def test_intervals_hold_their_estimate_and_keep_its_sign(self):
        data, _ = planted("stribeck", {"mu_static": 1.1, "stribeck_speed": 0.01}, noise=0.1)
        for law in ls.fit_friction(data, laws=self.FALLING).laws:
            for name, p in law.parameters.items():
                if p.interval is None:
                    continue
                assert p.interval[0] <= p.value <= p.interval[1], name
                if name in ("stribeck_speed", "modelica_decay"):
                    assert p.interval[0] > 0


@pytest.mark.skipif(DATA is None, reason="LOCOSWEEP_DATA names no folder of measured data")
@pytest.mark.whole
class TestSeals:
    """Seals in a cylinder under pressure (E. Zillen, TU Delft 2021): four pressures each."""

    def fit(self, seal, **options):
        folder = Path(DATA or "") / "realdata" / "pneumatic_seal"
        meta = pl.read_csv(folder / "meta.csv").filter(pl.col("seal") == seal).sort("bar")
        runs = [str(run) for run in meta["run"]]
        laws = ["coulomb", "coulomb_viscous", "stribeck", "directional", "load_viscous"]
        middle = [str(run) for run in meta.filter(pl.col("bar") == 5)["run"]]
        return ls.fit_friction(folder / "friction.parquet", runs=runs, holdout=middle,
                               laws=options.get("laws", laws))  # fmt: skip

    @pytest.mark.parametrize(
        ("seal", "slope", "shrink"),
        [("NAPN", 0.027, 0.6), ("PK", 0.013, 0.6), ("O-ring", 0.0125, 0.4)],
    )
    def test_friction_follows_pressure_beside_an_area_error(self, seal, slope, shrink):
        fit = self.fit(seal)
        assert fit.chosen.load != "constant"
        assert fit.chosen.gain
        assert fit.chosen.parameters["mu_coulomb"].value == pytest.approx(slope, rel=0.35)
        assert 0.003 < fit.chosen.parameters["load_gain"].value < 0.02
        assert fit.shrink > shrink

    @pytest.mark.parametrize("seal", ["NAP310", "O-ring257", "KDN"])
    def test_friction_never_rises_from_rest(self, seal):
        fit = self.fit(seal)
        for law in fit.laws:
            if {"mu_static", "mu_coulomb"} <= law.parameters.keys():
                levels = law.parameters["mu_static"].value, law.parameters["mu_coulomb"].value
                assert levels[0] >= levels[1], law.name
            for p in law.parameters.values():
                assert p.interval is None or p.interval[0] <= p.value <= p.interval[1]
        tied = [law for law in fit.laws if law.tied and not law.remarks]
        assert not tied or not fit.chosen.remarks

    def test_a_seal_with_hardly_any_dependence(self):
        fit = self.fit("KDN")
        assert fit.chosen.gain
        load = fit.chosen.parameters.get("mu_coulomb")
        assert load is not None
        # 5.7 N at 1 bar and 6.8 N at 7 bar: under 0.006 N per newton of load.
        low, high = (abs(fit.chosen.force([0.01], at)[0]) for at in (50.0, 340.0))
        assert (high - low) / 290.0 < 0.008
