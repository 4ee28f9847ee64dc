"""One whole robot through Python: gait files, closed forms, parts of their own, the command."""

import re
import shutil
import threading
import time
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from matplotlib.figure import Figure
from PIL import Image

import locosweep as ls
from locosweep import _core
from locosweep.cli import main
from locosweep.plot.gait import joint_forces
from locosweep.simulation.gait import gait_parameters

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("gait_*.toml"))
DRY = {"mu_static": 0.5, "mu_coulomb": 0.3, "drive_limit": 0.85, "segments": 4}
PAPER = {**DRY, "impact": 0, "break_away": 0}
"""As in the closed forms: what is left at a stroke's end is dropped, movers do not stick."""

MINIMAL = """
[gait]
schedule = "single"
[robot]
segments = 4
[surface]
mu_static = 0.5
mu_coulomb = 0.3
[drive]
limit = 0.85
"""


def test_registry_in_python():
    assert [g.name for g in ls.gaits()] == [
        "single", "block", "window", "wave", "inchworm", "concertina",
    ]  # fmt: skip
    outputs = _core.gait_outputs()
    run = ls.run_gait(**PAPER, cycles=1)
    assert [o.name for o in outputs] == list(run.results) == run.summary["output"].to_list()
    assert all(o.unit and o.meaning and o.symbol for o in outputs)
    # Keys are those of a robot file where that has them.
    for record in gait_parameters().values():
        key = record.parameter.file_key
        assert key is None or key == (record.table, record.key)


# Closed forms.


def test_the_papers_gait_on_the_flat():
    run = ls.run_gait("single", **PAPER, cycles=3)
    phase = ls.sweep("phase_time", anchors_ahead=[0, 1], **DRY).values
    cycle = 2 * phase[0] + 2 * phase[1]
    assert run.results["time"] == pytest.approx(3 * cycle, rel=1e-12)
    assert run.results["velocity"] == pytest.approx(0.02 / cycle, rel=1e-12)
    assert run.results["slip_max"] == 0
    # The actuator's 0.85 N of (N - 1) mu_S m g on one side, twice that on both ends of one.
    weight = 0.271 * 9.81
    assert run.results["propulsive_peak"] == pytest.approx(1.7)
    assert run.results["anchor_safety"] == pytest.approx(0.5 * weight / 0.85)
    assert phase[0] == pytest.approx((0.04 / ((0.85 - 0.3 * weight) / 0.271)) ** 0.5)


def test_speed_limited_cycle_is_k_strokes_over_n_phases():
    # A strong, slow drive: phases last d/v + v/(2 a), and v = k d/(N t).
    for k in (1, 2):
        given = {**PAPER, "mu_static": 5, "drive_limit": 1.3 * k, "speed_limit": 0.05, "moving": k}
        run = ls.run_gait("window", cycles=2, **given)
        given = {n: v for n, v in given.items() if n not in ("impact", "break_away")}
        one, two = ls.sweep("phase_time", anchors_ahead=[0, 1], **given).values
        assert one == pytest.approx(0.4 + 0.025 / (1.3 / 0.271 - 0.3 * 9.81))
        assert run.results["advance"] == pytest.approx(k * 0.02, rel=1e-12)
        # Windows that reach an end (or wrap around it) are driven by fewer joints.
        mean = run.results["time"] / 8
        assert two * (1 - 1e-12) <= mean <= one * (1 + 1e-12)
        assert run.results["velocity"] == pytest.approx(k * 0.02 / (4 * mean), rel=1e-12)


def test_trace_shapes_and_ledger():
    run = ls.run_gait("single", **PAPER, cycles=2, samples=1001)
    times = len(run.t)
    assert times == 1001
    assert run.x.shape == run.v.shape == run.sliding.shape == (times, 4)
    assert run.force.shape == (times, 3)
    assert run.phase.min() == 0
    assert run.phase.max() == 3
    assert run.x[-1].mean() == pytest.approx(2 * run.results["advance"], abs=1e-4)
    assert (run.v[run.sliding == 0] == 0).all()
    assert abs(run.force).max() == pytest.approx(run.results["actuator_peak"])
    assert run.power.max() <= run.results["power_peak"] * (1 + 1e-12)
    # In the head's phase its one joint is all that pushes.
    head = (run.phase == 0) & (run.sliding[:, 0] == 1)
    assert run.propulsive[head] == pytest.approx(run.force[head, 0])
    r = run.results
    spent = r["friction"] + r["damping"] + r["impact"] + r["kinetic"] + r["potential"]
    assert r["work"] == pytest.approx(spent + r["elastic"] + r["residual"])


def test_table_of_the_trace():
    run = ls.run_gait("single", **PAPER, cycles=1, samples=11)
    table = run.to_polars()
    assert table.shape == (run.x.size, 10)
    rear = table.filter(pl.col("segment") == 3)
    assert rear["joint_force"].null_count() == len(run.t)
    assert (rear["x"].to_numpy() == run.x[:, 3]).all()
    second = table.filter(pl.col("segment") == 1)
    assert (second["joint_force"].to_numpy() == run.force[:, 1]).all()


def test_every_sets_the_samples():
    run = ls.run_gait("single", **PAPER, cycles=1, every=0.01)
    assert np.diff(run.t) == pytest.approx(0.01)


# Parts with values of their own.


def test_equal_parts_given_one_by_one_change_nothing():
    one = ls.run_gait("block", moving=2, **{**PAPER, "drive_limit": 2}, cycles=2)
    each = {**PAPER, "mu_static": [0.5] * 4, "drive_limit": [2.0] * 3, "mass": [0.271] * 4}
    other = ls.run_gait("block", moving=2, **each, cycles=2)
    assert one.results == other.results
    assert (one.x == other.x).all()
    assert other.values["mass"] == (0.271,) * 4


@pytest.mark.parametrize(
    ("name", "values", "phase"),
    [("mass", [0.2, 0.271, 0.271, 0.271], 0), ("viscous", [0, 0.5, 0, 0], 1),
     ("mu_coulomb", [0.3, 0.3, 0.2, 0.3], 2), ("mass", [0.271, 0.271, 0.271, 0.25], 3)],
)  # fmt: skip
def test_a_segment_of_its_own_changes_its_phase_only(name, values, phase):
    def durations(run):
        return np.bincount(run.phase)

    plain = ls.run_gait(**PAPER, cycles=1, every=1e-4)
    own = ls.run_gait(**{**PAPER, name: values}, cycles=1, every=1e-4)
    change = abs(durations(own) - durations(plain))
    assert change[phase] > 5
    assert (np.delete(change, phase) <= 1).all()
    # The others' phases keep their form: a = (F - mu_C m g)/m with one or two drives.
    if (name, phase) == ("mass", 0):
        a = 0.85 / 0.2 - 0.3 * 9.81
        assert durations(own)[0] == pytest.approx((0.04 / a) ** 0.5 * 1e4, abs=2)


def test_a_weak_anchor_ahead_slides_back():
    firm = ls.run_gait(**PAPER, cycles=2)
    # The head alone holds the second segment's pull: 0.85 N of mu_S m g.
    weak = ls.run_gait(**{**PAPER, "mu_static": [0.31, 0.5, 0.5, 0.5]}, cycles=2)
    assert firm.slip.tolist() == [0] * 4
    assert weak.slip[0] > 1e-3
    assert weak.slip[1:].max() == 0
    assert weak.results["anchor_safety"] == pytest.approx(0.31 * 0.271 * 9.81 / 0.85)
    assert (weak.sliding[:, 0] == -1).any()


def test_strokes_of_joints():
    run = ls.run_gait(**{**PAPER, "stroke": [0.02, 0.03, 0.01]}, cycles=1, every=1e-4)
    first = run.x[run.phase == 0]
    assert first[-1, 0] == pytest.approx(0.02, abs=1e-4)


def test_same_input_same_bits():
    elastic = {"joint_stiffness": 2000, "joint_damping": 5, "speed_limit": 0.05}
    given = {**DRY, **elastic, "drive_limit": 2, "break_away": 0, "cycles": 2}
    runs = [ls.run_gait("wave", **given) for _ in range(2)]
    assert runs[0].results == runs[1].results
    for name in ("t", "x", "v", "force", "sliding", "heap", "power", "propulsive"):
        assert getattr(runs[0], name).tobytes() == getattr(runs[1], name).tobytes()


# Lubricant.

ELASTIC = {**DRY, "mu_coulomb": 0.2, "joint_stiffness": 2000, "joint_damping": 20,
           "speed_limit": 0.1, "drive_limit": 3, "dwell": 0.1, "cycles": 1}  # fmt: skip


def test_lubricant_from_a_file_to_the_trace():
    spec = ls.GaitSpec.load(ROOT / "examples" / "gait_lubricated.toml")
    run = spec.run(samples=2401)
    stroke, pitch = run.values["stroke"], run.values["segment_pitch"]
    assert run.heap.shape == run.x.shape
    # The head finds fresh ground in every stroke, the followers once, for the pitch.
    assert run.heap[:, 0].max() == pytest.approx(stroke, rel=0.05)
    assert run.heap[:, 1:].max(axis=0) == pytest.approx(pitch, rel=0.01)
    second = run.t > run.t[-1] / 2
    assert run.heap[second, 0].max() > 0.9 * stroke
    assert run.heap[second, 1:].max() == 0
    assert (run.heap[run.sliding != 1] == 0).all()
    table = run.to_polars()
    assert (table.filter(pl.col("segment") == 0)["heap"].to_numpy() == run.heap[:, 0]).all()
    # Each segment may have its own.
    own = {**spec.values, "buildup": (20.0, 0.0, 0.0, 0.0), "segment_pitch": 0.0}
    again = ls.GaitSpec.from_toml(ls.GaitSpec("single", own).to_toml()).run()
    assert again.results == ls.run_gait(**{**spec.values, "segment_pitch": 0.0}).results


def test_without_lubricant_nothing_is_pushed():
    dry = ls.run_gait(**ELASTIC)
    assert dry.heap.shape == dry.x.shape
    assert not dry.heap.any()
    # The ground under a robot without pitch is swept, and its speed of the fall is of no use.
    assert ls.run_gait(**ELASTIC, segment_pitch=0.05).results == dry.results
    lubricated = ls.run_gait(**ELASTIC, stribeck_term=1, stribeck_speed=0.02)
    assert lubricated.results["friction"] > dry.results["friction"]
    swept = ls.sweep("gait_friction", gait="single", stribeck_term=[0, 1], stribeck_speed=0.02,
                     **ELASTIC)  # fmt: skip
    assert swept.values.tolist() == [dry.results["friction"], lubricated.results["friction"]]
    result = ls.sweep("gait_advance", gait="single", buildup=[0, 5], **PAPER)
    assert [ls.Status(code).name for code in result.status] == ["OK", "ELASTIC_JOINTS_ONLY"]


# Refusals.


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"gait": "singel"}, "did you mean 'single'"),
        ({"mas": 1}, "did you mean 'mass'"),
        ({"anchor_weight": 1}, "unknown parameter of a gait 'anchor_weight'"),
        ({"mass": -1.0}, "mass is -1.0 kg: allowed"),
        ({"mass": [0.2, 0.3]}, "mass is 2 values: allowed is one, or 4"),
        ({"mass": [0.2, 0.3, float("nan"), 1]}, "mass[2]"),
        ({"drive_limit": [1, 1, 1, 1]}, "drive_limit is 4 values: allowed is one, or 3"),
        ({"cycles": [1, 2, 3, 4]}, "cycles has the shape (4,): allowed is one number"),
        ({"mass": [[1, 2], [3, 4]]}, "mass has the shape (2, 2)"),
        ({"mass": "heavy"}, "mass is 'heavy': allowed is a number"),
        ({"mass": True}, "mass is True: allowed is a number"),
        ({"segments": 33}, "segments is 33: allowed is a whole number from 2 to 32"),
        ({"segments": 1}, "nothing_anchored"),
        ({"drive_limit": 0.1}, "drive_too_weak)"),
        ({"joint_stiffness": [1e3, 1e3, float("inf")]}, "mixed_joints"),
        ({"buildup": 5}, "need elastic joints: give a joint_stiffness (elastic_joints_only)"),
        ({"stribeck_term": [0, 0, 1, 0]}, "elastic_joints_only"),
        ({"stribeck_speed": 0.1}, "stribeck_speed is 0.1, without stribeck_term: allowed is"),
        ({"buildup": [1, 2, -3, 4]}, "buildup[2] is -3.0"),
        ({"segment_pitch": -0.1}, "segment_pitch is -0.1 m: allowed is"),
        ({"segment_pitch": [0.1] * 4}, "segment_pitch has the shape (4,): allowed is one number"),
        ({"samples": 1}, "samples is 1"),
        ({"every": 0.0}, "every is 0.0"),
        ({"every": 1e-30}, "the trace needs"),
    ],
)
def test_bad_input_is_refused_in_one_line(given, words):
    with pytest.raises(ls.InputError, match=re.escape(words)) as caught:
        ls.run_gait(**{**PAPER, **given})
    assert "\n" not in str(caught.value)


def test_a_drive_that_static_friction_alone_holds_is_told_what_leaves_that_out():
    with pytest.raises(ls.InputError, match=r"\(drive_too_weak\); break_away=0 starts segments"):
        ls.run_gait(**{**PAPER, "drive_limit": 0.85, "break_away": 1})
    for break_away in (0, 1):
        with pytest.raises(ls.InputError, match=r"\(drive_too_weak\)$"):
            ls.run_gait(**{**PAPER, "drive_limit": 0.1, "break_away": break_away})


def test_a_motion_that_cannot_be_computed_is_no_bad_input(tmp_path, capsys):
    elastic = {"joint_stiffness": 2000, "joint_damping": 5, "speed_limit": 0.05}
    given = {**PAPER, **elastic, "time_step": 1e-9, "cycles": 1}
    with pytest.raises(ls.SolveError, match="too_many_steps"):
        ls.run_gait(**given)
    spec = ls.GaitSpec("single", {name: float(value) for name, value in given.items()})
    spec.save(tmp_path / "long.toml")
    assert main(["gait", str(tmp_path / "long.toml"), "--out", str(tmp_path / "out")]) == 1
    assert "too many steps" in capsys.readouterr().err


def test_what_has_no_default_is_asked_for():
    with pytest.raises(ls.InputError, match="mu_static is not given: allowed is a number"):
        ls.run_gait(segments=4, mu_coulomb=0.3)
    with pytest.raises(ls.InputError, match="segments is not given"):
        ls.run_gait(mu_static=0.5, mu_coulomb=0.3)


def test_a_token_stops_a_long_run():
    token = ls.CancelToken()
    timer = threading.Timer(0.2, token.cancel)
    timer.start()
    begin = time.perf_counter()
    with pytest.raises(ls.Cancelled):
        ls.run_gait("single", **PAPER, cycles=1_000_000, token=token)
    assert time.perf_counter() - begin < 5
    timer.join()


# Gait files.


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_examples_move_and_read_back(file):
    spec = ls.GaitSpec.load(file)
    assert file.stem in {f"gait_{spec.schedule}", "gait_lubricated"}
    again = ls.GaitSpec.from_toml(spec.to_toml())
    assert again == spec
    assert again.to_toml() == spec.to_toml()
    run = spec.run()
    count, results = run.x.shape[1], run.results
    assert results["velocity"] > 1e-3
    # Nearly the gait's own travel, in spite of slip and momentum.
    stroke = run.values["stroke"]
    travel = {"window": run.values["moving"], "wave": 1.22, "inchworm": count - 1}
    expected = stroke * travel.get(spec.schedule, 1)
    assert results["advance"] == pytest.approx(expected, rel=0.05)
    assert abs(results["residual"]) < 1e-4 * results["work"]
    assert set(np.unique(run.sliding)) <= {-1, 0, 1}


def test_every_gait_has_an_example():
    grounds = {"lubricated"}
    names = {f.stem.removeprefix("gait_") for f in EXAMPLES}
    assert names == {g.name for g in ls.gaits()} | grounds


def test_numbers_keep_their_bits(tmp_path):
    values = {n: p.parameter.default for n, p in gait_parameters().items()}
    values |= {"segments": 3.0, "mu_static": (0.1 + 0.2, 1 / 3, 5e-324 * 0), "mu_coulomb": 1e-17}
    values["speed_limit"] = (float("inf"), 0.1)
    spec = ls.GaitSpec("wave", values, robot='odd "name"\\\x7f.toml')
    assert ls.GaitSpec.from_toml(spec.to_toml()) == spec
    spec.save(tmp_path / "one.toml")
    back = ls.GaitSpec.load(tmp_path / "one.toml")
    assert back.values == values


def test_a_robot_file_counts_from_the_gait_file(tmp_path):
    shutil.copy(ROOT / "examples" / "locosnake.toml", tmp_path / "robot.toml")
    (tmp_path / "gait.toml").write_text(
        '[gait]\nschedule = "single"\nrobot = "robot.toml"\ncycles = 1\nbreak_away = 0\n'
        "impact = 0\n[robot]\nmass = [0.2, 0.2, 0.2, 0.2]\n"
    )
    spec = ls.GaitSpec.load(tmp_path / "gait.toml")
    run = spec.run()
    assert run.values["mu_static"] == 0.5
    assert run.values["mass"] == (0.2,) * 4
    same = ls.run_gait(**{**PAPER, "mass": 0.2, "supply_voltage": 10.0}, cycles=1)
    assert run.results["time"] == same.results["time"]
    (tmp_path / "sub").mkdir()
    spec.save(tmp_path / "sub" / "moved.toml")
    moved = ls.GaitSpec.load(tmp_path / "sub" / "moved.toml")
    assert moved.robot == "../robot.toml"
    assert moved.run().results == run.results


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[gait]", "x = 1\n[gait]", "unknown key or table 'x'"),
        ("\n[gait]", "motor = 1\n[gait]", "motor is not a table: write [motor]"),
        ("[gait]", 'format = "locosweep.gait/2"\n[gait]', "this version reads"),
        ('schedule = "single"', "", "[gait] schedule is missing: allowed is single, block"),
        ('"single"', '"blok"', "[gait] schedule: unknown gait 'blok': did you mean 'block'"),
        ('"single"', "3", "[gait] schedule is 3: allowed is a word in quotes"),
        ("segments", "segmens", "unknown key in [robot] 'segmens': did you mean 'segments'"),
        ("segments = 4", "segments = [4]", "[robot] segments is an array: allowed is"),
        ("segments = 4", "segments = 4.5", "[robot] segments is 4.5: allowed is a whole number"),
        ("mu_static = 0.5", "", "[surface] mu_static is missing: allowed is a number"),
        ("0.5", '"0.5"', "[surface] mu_static is '0.5': allowed is a number"),
        ("0.5", "[0.5, 0.5]", "[surface] mu_static has 2 values: allowed is one, or 4"),
        ("0.5", "[0.5, 0.5, -1, 0.5]", "[surface] mu_static[2] is -1.0: allowed is"),
        ("0.85", "[1, 1]", "[drive] limit has 2 values: allowed is one, or 3"),
        ("0.85", "-1", "[drive] limit is -1.0 N: allowed is"),
        ("0.5", "0.5\nsnowplough = -1", "[surface] snowplough is -1.0 N s^2/m^2: allowed is"),
        ("0.5", "0.5\nbuildup_root = 1", "elastic_joints_only"),
        ("0.85", f"1{'0' * 400}", "[drive] limit is too large: allowed is"),
        ("0.85", "0.1", "drive_too_weak"),
        ("limit", "limit =", "not TOML"),
    ],
)
def test_bad_files_end_the_command_with_one_line(old, new, words, tmp_path, capsys):
    file = tmp_path / "bad.toml"
    file.write_text(MINIMAL.replace(old, new))
    assert main(["gait", str(file), "--out", str(tmp_path / "out")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert words in lines[0]
    assert str(file) in lines[0]
    assert not (tmp_path / "out").exists()


# The command.

FILES = ["forces.png", "spacetime.png", "summary.csv", "summary.md", "trace.parquet"]


@pytest.mark.whole
def test_command_writes_pictures_and_tables(tmp_path, capsys):
    out = tmp_path / "new" / "folder"
    assert main(["gait", str(ROOT / "examples/gait_window.toml"), "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sorted(p.name for p in out.iterdir()) == FILES
    assert sorted(Path(line).name for line in lines[:-1]) == FILES
    assert re.match(r"window, 6 segments: \d+\.?\d* mm/s, .* back per cycle", lines[-1])
    for name in FILES[:2]:
        with Image.open(out / name) as image:
            assert min(image.size) > 700
            assert "gait_window.toml" in image.info["Command"]
    summary = pl.read_csv(out / "summary.csv")
    assert summary.columns == ["output", "value", "unit", "meaning"]
    assert summary["output"].to_list() == [o.name for o in _core.gait_outputs()]
    text = (out / "summary.md").read_text(encoding="utf-8")
    assert lines[-1] in text
    assert all(f"| {name} |" in text for name in [*summary["output"], *gait_parameters()])
    trace = pl.read_parquet(out / "trace.parquet")
    assert trace["segment"].n_unique() == 6


@pytest.mark.whole
def test_a_folder_that_is_not_empty_needs_force(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("")
    command = ["gait", str(ROOT / "examples/gait_single.toml"), "--out", str(tmp_path)]
    assert main(command) == 2
    assert "is not empty: name another folder, or give --force" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]
    assert main([*command, "--force", "--json"]) == 0
    assert '"velocity"' in capsys.readouterr().out
    first = {name: (tmp_path / name).read_bytes() for name in FILES if name != "trace.parquet"}
    assert main([*command, "--force", "--json"]) == 0
    assert all((tmp_path / name).read_bytes() == data for name, data in first.items())


def test_no_such_file(tmp_path, capsys):
    assert main(["gait", str(tmp_path / "none.toml"), "--out", str(tmp_path / "out")]) == 2
    assert "none.toml" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("samples", [2, 7, 601])
@pytest.mark.parametrize("segments", [3, 4, 5])
def test_the_last_sample_is_the_end(samples, segments):
    run = ls.run_gait(
        "single", segments=segments, mu_static=0.5, mu_coulomb=0.3, drive_limit=0.85,
        break_away=0, cycles=1, samples=samples,
    )  # fmt: skip
    assert len(run.t) == samples
    assert run.t[-1] == pytest.approx(run.results["time"], rel=1e-9)


def test_a_trace_of_one_sample_is_drawn():
    run = ls.run_gait("single", segments=3, mu_static=0.5, mu_coulomb=0.3, drive_limit=0.85,
                      break_away=0, every=1000.0)  # fmt: skip
    assert len(run.t) == 1
    assert joint_forces(run, Figure().subplots()).get_ylabel()
