"""Logs as rigs export them become runs in SI units."""

import numpy as np
import pytest

from locosweep.errors import DataFileError, InputError
from locosweep.files.atomic import write_frame
from locosweep.files.csv_form import CsvForm
from locosweep.files.runs import load_runs
from locosweep.intake.log import read_log

COUNT = 40


def written(tmp_path, head, row, name="log.csv", count=COUNT):
    file = tmp_path / name
    file.write_text("\n".join([head, *(row(k) for k in range(count))]) + "\n")
    return file


def again(log, tmp_path):
    """The runs as a diagnosis reads them from what was written."""
    write_frame(tmp_path / "runs.csv", log.frame)
    return load_runs(tmp_path / "runs.csv")


def test_everything_at_once(tmp_path):
    def row(k):
        stamp = f"1764075181{k * 10:03d}" if k < 20 else f"1764075281{k * 10:03d}"
        return f"{stamp};{0.5 * (k % 3)};{k}.25;x".replace(".", ",")

    file = written(tmp_path, "# rig\nStempel_ms;Sollkraft_N;Weg_mm;Notiz", row)
    log = read_log(file, columns={"t": "Stempel_ms"})
    assert log.columns == {"t": "Stempel_ms", "drive": "Sollkraft_N", "x": "Weg_mm"}
    assert log.units == {"t": "ms", "drive": "N", "x": "mm"}
    assert (log.runs, log.rotary, log.drive_in_force) == (2, False, True)
    runs, notices = again(log, tmp_path)
    assert notices == []
    assert [run.label for run in runs] == ["0", "1"]
    for run in runs:
        np.testing.assert_allclose(run.t, np.arange(20) * 0.01, atol=1e-12)
    assert runs[1].channels["x"][0] == pytest.approx(20.25e-3)
    said = "; ".join(log.notes)
    for words in (
        "t is Stempel_ms (as you say), in ms (by its name)", "not used: Notiz", "decimal commas",
        "is Unix time", "2 runs in", "x is Weg_mm (by its name), in mm (by its name)",
    ):  # fmt: skip
        assert words in said


def test_runs_by_jumps_and_pauses(tmp_path):
    back = written(tmp_path, "t,drive,x", lambda k: f"{k % 20 * 0.01},0,0")
    assert read_log(back).runs == 2
    pause = written(tmp_path, "t,drive,x", lambda k: f"{k * 0.01 + 0.5 * (k > 19)},0,0")
    assert read_log(pause).runs == 1
    assert read_log(pause, pause=0.2).runs == 2


def test_rows_that_come_late_are_put_in_their_place(tmp_path):
    late = {10: 11, 11: 10, 30: 31, 31: 30}
    file = written(tmp_path, "t,drive,x", lambda k: f"{late.get(k, k) * 0.01},0,{late.get(k, k)}")
    log = read_log(file)
    assert log.runs == 1
    assert log.frame["x"].is_sorted()
    assert "run 0: rows that came late, put in their place: 2" in log.notes


def test_drives_that_miss_are_counted(tmp_path):
    file = written(tmp_path, "t,drive,x", lambda k: f"{k * 0.01},{'' if k % 4 else 1},{k}")
    words = "run 0: 30 of 40 rows have no drive: a diagnosis holds the one before"
    assert words in read_log(file).notes


def test_units_in_cells(tmp_path):
    row = lambda k: f"{k * 10} ms,{k % 2}.5 N,{k}mm"  # noqa: E731
    log = read_log(written(tmp_path, "Time,MotorCmd,HeadPos", row))
    assert log.units == {"t": "ms", "drive": "N", "x": "mm"}
    assert (log.frame["t"][3], log.frame["drive"][1], log.frame["x"][3]) == (0.03, 1.5, 0.003)


def test_parts_that_are_too_short_are_left_out_and_named(tmp_path):
    file = written(tmp_path, "t,drive,x", lambda k: f"{k * 0.01 + 9 * (k > 24)},0,0")
    log = read_log(file)
    assert log.frame.height == 25
    assert "too few samples for a run, left out: 1 (15)" in log.notes
    with pytest.raises(DataFileError, match="no run of 20 samples"):
        read_log(
            written(tmp_path, "t,drive,x", lambda k: f"{k * 9.5},0,0"), units={"t": "s"}, pause=1.0
        )


def test_labels_stand_for_runs_wherever_their_rows_are(tmp_path):
    turns = written(tmp_path, "t,drive,x,trial", lambda k: f"{k * 0.01},0,{k},{'ab'[k % 2]}")
    log = read_log(turns)
    assert log.frame["run"].unique(maintain_order=True).to_list() == ["a", "b"]
    assert [run.t.size for run in again(log, tmp_path)[0]] == [20, 20]
    # A run goes on after a pause, unless one is said to end it; a clock that begins anew does.
    pause = written(tmp_path, "t,drive,x,run", lambda k: f"{k * 0.01 + 50 * (k > 19)},0,{k},a")
    assert read_log(pause).runs == 1
    log = read_log(pause, pause=2.0)
    assert log.frame["run"].unique(maintain_order=True).to_list() == ["a.0", "a.1"]
    assert any(
        "2 runs" in note and "by their labels and cut where time jumps back or pauses for 2 s"
        in note for note in log.notes
    )  # fmt: skip
    back = written(tmp_path, "t,drive,x,run", lambda k: f"{k % 20 * 0.01},0,{k},a")
    assert read_log(back).runs == 2


def test_columns_that_are_not_taken_are_not_read(tmp_path):
    file = written(tmp_path, "t,drive,x,v,run", lambda k: f"{k * 0.01},0,{k},{'a' if k else 1},{k}")
    log = read_log(file)
    assert (log.frame.columns, log.runs) == (["run", "t", "drive", "x"], 1)
    assert "not used: v, run" in log.notes
    assert "v is not taken for v: row 2 has 'a', which is no number" in log.notes


def test_a_slope_holds_for_a_run(tmp_path):
    shaking = written(tmp_path, "t,drive,x,tilt_deg", lambda k: f"{k},0,{k},{2 + k % 3 * 0.1}")
    log = read_log(shaking)
    assert log.frame["slope_deg"][0] == pytest.approx(2.1)
    assert "slope_deg of run 0 is 2 to 2.2 deg: 2.1 is taken" in log.notes
    turned = written(tmp_path, "t,drive,x,tilt_deg", lambda k: f"{k},0,{k},{10 * (k > 19)}")
    words = "run 0, column tilt_deg: 0 to 10 deg, allowed is one slope per run"
    with pytest.raises(DataFileError, match=words):
        read_log(turned)


def test_computed_numbers_have_no_noise(tmp_path):
    smooth = [1.0 + np.sin(1e-3 * k) for k in range(COUNT)]
    log = read_log(written(tmp_path, "t,drive,x,v", lambda k: f"{k * 0.01},0,{smooth[k]:.17g},1"))
    assert log.noise["x"].gaussian == 0.0
    assert "v" not in log.noise
    assert "v: no noise to be seen, as in computed numbers" in log.notes


def test_several_files(tmp_path):
    for name in ("one", "two"):
        written(tmp_path, "time_ms;cmd_mN;pos_mm", lambda k: f"{k * 10};500;{k}", f"{name}.csv")
    log = read_log(tmp_path)
    assert log.frame["run"].unique(maintain_order=True).to_list() == ["one", "two"]
    assert log.frame["drive"][0] == 0.5
    assert log.columns == {"t": "time_ms", "drive": "cmd_mN", "x": "pos_mm"}


def test_rows_of_units_angles_and_voltages(tmp_path):
    file = written(tmp_path, "time,u,theta\n[ms],[V],[deg]", lambda k: f"{k * 10},2,{k}")
    log = read_log(file)
    assert log.units == {"t": "ms", "drive": "V", "x": "deg"}
    assert (log.rotary, log.drive_in_force) == (True, False)
    assert log.frame["x"][30] == pytest.approx(np.pi / 6.0)


def test_noise_is_that_of_the_readings(tmp_path):
    noise = np.random.default_rng(0).normal(0.0, 0.02, 400)
    row = lambda k: f"{k * 0.01:.2f},0,{noise[k]:.6f}"  # noqa: E731
    log = read_log(written(tmp_path, "t,drive,x [mm]", row, count=400))
    assert log.noise["x"].gaussian == pytest.approx(2e-5, rel=0.15)


def test_missing_values_stay_missing(tmp_path):
    file = written(tmp_path, "t,drive,x,v", lambda k: f"{k * 0.01},0,{'' if k == 3 else k},1")
    log = read_log(file)
    assert log.frame["x"].null_count() == 1
    gone = written(tmp_path, "t,drive,x", lambda k: f"{'' if k == 3 else k * 0.01},0,0")
    assert f"{gone}: rows without a time, left out: 1" in read_log(gone).notes


def test_what_is_refused(tmp_path):
    file = written(tmp_path, "t,drive,x", lambda k: f"{k * 0.01},0,1,234" if k else "0,0,1")
    with pytest.raises(DataFileError, match="row 2 has 4 values"):
        read_log(file)
    file = written(tmp_path, "t;drive;x", lambda k: f"{k};0;1,234")
    with pytest.raises(DataFileError, match="--decimal comma or --decimal point"):
        read_log(file)
    assert read_log(file, form=CsvForm(decimal="comma")).frame["x"][0] == 1.234
    with pytest.raises(DataFileError, match=r"no column pos \(given for x\)"):
        read_log(file, columns={"x": "pos"})
    huge = written(tmp_path, "t,drive,x", lambda k: f"{k * 0.01},0,1e300")
    with pytest.raises(DataFileError, match=r"column x has 1e\+300, allowed is up to 1e\+15"):
        read_log(huge)
    file = written(tmp_path, "t,drive,x", lambda k: f"{k},0,1")
    with pytest.raises(InputError, match="unknown column 'y'"):
        read_log(file, columns={"y": "x"})
    with pytest.raises(InputError, match="unit of x: kN measures something else"):
        read_log(file, units={"x": "kN"})
    with pytest.raises(InputError, match="unit of v: rpm measures something else"):
        read_log(written(tmp_path, "t,drive,x_mm,v", lambda k: f"{k},0,1,2"), units={"v": "rpm"})
