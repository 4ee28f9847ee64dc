"""Distances between effects, and what a planned experiment could tell apart."""

import json

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.files.robot import Robot
from locosweep.files.runs import Run

ROBOT = Robot({"mass": 0.271, "segments": 4.0, "mu_coulomb": 0.15})
NOISE = {"x": 1e-4}
T = np.arange(0.0, 1.2, 0.01)
PUSH = np.where((T > 0.05) & (T < 0.4), 0.62, 0.0)
BOTH = PUSH - np.where((T > 0.7) & (T < 1.0), 0.7, 0.0)


def planned(*drives):
    return [Run(str(i), T, drive) for i, drive in enumerate(drives)]


@pytest.fixture(scope="module")
def one_way():
    return ls.distinguish(ROBOT, planned(PUSH), noise=NOISE, threads=1)


@pytest.fixture(scope="module")
def both_ways():
    return ls.distinguish(ROBOT, planned(BOTH, 0.8 * BOTH), noise={**NOISE, "force": 1e-3})


class TestTwins:
    """What is known from physics: which effects are one signal, and what splits them."""

    @pytest.mark.parametrize(
        ("name", "twin"),
        [
            ("viscous_friction", "back_emf"),
            ("drive_delay", "sensor_delay"),
            ("payload_mass", "drive_gain_error"),
            ("slope_error", "coulomb_error"),
            ("slope_error", "direction_dependent_friction"),
        ],
    )
    def test_one_way_motion_without_force(self, one_way, name, twin):
        assert twin in one_way.rivals(name)
        assert one_way.distances[one_way.names.index(name), one_way.names.index(twin)] < 0.5

    def test_reversal_splits_slope_from_coulomb(self, both_ways):
        assert "coulomb_error" not in both_ways.rivals("slope_error")

    @pytest.mark.parametrize(
        ("name", "twin"),
        [("viscous_friction", "back_emf"), ("drive_delay", "sensor_delay"),
         ("payload_mass", "drive_gain_error")],
    )  # fmt: skip
    def test_a_force_sensor_splits(self, both_ways, name, twin):
        assert twin not in both_ways.rivals(name)

    def test_the_matrix_is_one_of_distances(self, one_way):
        assert (np.diag(one_way.distances) == 0.0).all()
        assert (one_way.distances >= 0.0).all()
        assert (one_way.distances <= one_way.size * 1.2).all()

    def test_unseen_effects_have_a_reason(self, one_way):
        assert "x_rear" in one_way.unseen["anchor_slip"]
        assert {*one_way.names, *one_way.unseen} == {e.name for e in ls.effects()}

    def test_the_body_shows_where_it_is_measured(self):
        robot = Robot({"mass": 0.271, "segments": 2.0, "mu_coulomb": 0.15})
        found = ls.distinguish(robot, planned(2.0 * BOTH), noise={"x": 1e-4, "x_rear": 1e-4})
        assert "anchor_slip" in found.names
        assert found.rivals("anchor_slip") == []

    def test_a_rotary_bench(self):
        robot = Robot({"mass": 0.15, "segments": 1.0},
                      {"surface.coulomb_force": 0.3, "bench.kind": "rotary",
                       "bench.gravity_torque": 3.0})  # fmt: skip
        found = ls.distinguish(robot, planned(2.0 * BOTH), noise={"x": 2e-3})
        assert set(found.unseen) >= {"anchor_slip", "slope_error"}
        assert list(found.seen_from["coulomb_error"][0]) == ["d_force"]
        assert "back_emf" in found.rivals("viscous_friction")

    def test_same_bits_for_every_number_of_threads(self, one_way):
        again = ls.distinguish(ROBOT, planned(PUSH), noise=NOISE, threads=2)
        assert (again.distances == one_way.distances).all()
        assert again.seen_from == one_way.seen_from

    def test_less_noise_shows_smaller_effects(self, one_way):
        finer = ls.distinguish(ROBOT, planned(PUSH), noise={"x": 1e-5})
        ratio = (
            one_way.seen_from["coulomb_error"][0]["d_mu"]
            / (finer.seen_from["coulomb_error"][0]["d_mu"])
        )
        assert ratio == pytest.approx(10.0, rel=0.1)


class TestResult:
    def test_table(self, one_way):
        frame = one_way.to_polars()
        assert frame["effect"].to_list() == [*one_way.names, *one_way.unseen]
        row = frame.row(by_predicate=pl.col("effect") == "payload_mass", named=True)
        assert row["distance"] < 0.5
        assert row["seen_from"].startswith("dm = ±")
        assert row["seen_from"].endswith(" kg")

    def test_picture(self, one_way):
        ax = one_way.plot()
        assert len(ax.get_xticklabels()) == len(one_way.names)
        assert "σ" in ax.get_ylabel()
        ax.get_figure().canvas.draw()

    def test_in_short(self, one_way):
        assert "payload_mass: not told from" in repr(one_way)
        with pytest.raises(InputError, match="did you mean 'payload_mass'"):
            one_way.rivals("payload_mas")

    @pytest.mark.parametrize(
        ("runs", "options", "words"),
        [
            ([], {"noise": NOISE}, "runs is empty"),
            ({"a": (T, T[:-1])}, {"noise": NOISE}, "run a: times have shape"),
            ({"a": (T[::-1], PUSH)}, {"noise": NOISE}, "time must rise"),
            ({"a": (T, np.full(T.size, np.nan))}, {"noise": NOISE}, "finite"),
            (planned(0.1 * PUSH), {"noise": NOISE}, "does not move"),
            (planned(PUSH), {}, "no position_noise"),
            (planned(PUSH), {"noise": {"x": -1.0}}, "above 0"),
            (planned(PUSH), {"noise": {"y": 1.0}}, "unknown channel 'y'"),
            (planned(PUSH), {"noise": NOISE, "channels": ["power"]}, "unknown channel 'power'"),
            (planned(PUSH), {"noise": NOISE, "size": 0.0}, "size is 0.0"),
        ],
    )
    def test_bad_input(self, runs, options, words):
        with pytest.raises(InputError) as caught:
            ls.distinguish(ROBOT, runs, **options)
        assert words in str(caught.value)
        assert "\n" not in str(caught.value)


@pytest.mark.whole
class TestCommand:
    @pytest.fixture
    def call(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "n.toml").write_text(
            "[robot]\nsegments = 4\nmass = 0.271\n[surface]\nmu_coulomb = 0.15\n"
            "[drive]\ngain = 2.0\n[sensor]\nposition_noise = 1e-4\n"
        )

        def run(*arguments):
            code = main(["distinguish", *arguments])
            done = capsys.readouterr()
            return code, done.out, done.err

        return run

    PULSE = ("n.toml", "--drive", "pulse", "--set", "drive_amplitude=0.7,0.8", "--set",
             "duration=1.5", "--samples", "101")  # fmt: skip

    @pytest.mark.slow
    def test_table_picture_and_matrix(self, call, tmp_path):
        code, out, err = call(*self.PULSE, "--out", "m.csv", "--plot", "m.png")
        assert (code, err) == (0, "")
        assert "payload_mass" in out
        assert out.splitlines()[-2:] == ["m.csv", "m.png"]
        frame = pl.read_csv(tmp_path / "m.csv")
        assert frame.columns == ["effect", "rival", "distance"]
        assert (tmp_path / "m.png").read_bytes()[1:4] == b"PNG"

    def test_runs_of_a_file_give_the_same_as_their_drive(self, call, tmp_path):
        """A command is a force over the gain; a file of it is the same experiment."""
        rows = ["run,t,drive"]
        for amplitude in (0.7, 0.8):
            run = ls.simulate(law="coulomb", drive="pulse", mu_coulomb=0.5, samples=101,
                              drive_amplitude=amplitude, duration=1.5)  # fmt: skip
            rows += [f"{amplitude},{t!r},{f / 2.0!r}" for t, f in
                     zip(run.t.tolist(), run.force.tolist(), strict=True)]  # fmt: skip
        (tmp_path / "r.csv").write_text("\n".join(rows))
        _, named, _ = call(*self.PULSE, "--json")
        _, filed, _ = call("n.toml", "--runs", "r.csv", "--json")
        assert json.loads(named) == json.loads(filed)

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (("n.toml",), "allowed is one of --drive"),
            (("n.toml", "--drive", "sine", "--runs", "r.csv"), "allowed is one of --drive"),
            (("n.toml", "--drive", "table"), "needs --drive-file"),
            (("n.toml", "--drive", "sine", "--set", "mass=1"), "--set mass: allowed for drive"),
            (("n.toml", "--drive", "sine", "--set", "duration=1", "--set", "duration=2"), "twice"),
            (("n.toml", "--drive", "sine", "--noise", "x=abc"), "--noise x is 'abc'"),
            (("n.toml", "--drive", "constant"), "does not move"),
            (("n.toml", "--runs", "none.csv"), "no such file"),
            (("n.toml", "--runs", "none.csv", "--set", "duration=1"), "beside --runs"),
            (("none.toml", "--drive", "sine"), "none.toml"),
            (("n.toml", "--drive", "sine", "--out", "a.csv", "--plot", "a.csv"), "ends in"),
        ],
    )
    def test_bad_input_is_one_line(self, call, tmp_path, arguments, words):
        code, out, err = call(*arguments)
        assert (code, out) == (2, "")
        assert words in err
        assert err.count("\n") == 1
        assert [path.name for path in tmp_path.iterdir()] == ["n.toml"]
