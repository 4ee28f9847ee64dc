"""Times that are dates or Unix time count from the start of each run, to the last digit."""

import numpy as np
import polars as pl
import pytest

from locosweep.errors import DataFileError
from locosweep.files.runs import load_runs, runs_from_frame

COUNT = 25
STEPS = np.arange(COUNT) * 0.001


def written(tmp_path, stamps, head="t,drive,x", more=""):
    file = tmp_path / "log.csv"
    file.write_text("\n".join([head, *(f"{stamp},0,0{more}" for stamp in stamps)]) + "\n")
    return file


def clock(k, second=1):
    return f"12:53:{second:02d}.{k:03d}250"


@pytest.mark.parametrize(
    "form",
    [
        "2026-11-25T{}", "2026-11-25 {}", "2026-11-25T{}Z", "2026-11-25 {}+01:00",
        "2026-11-25T{}-0530", "25.11.2026 {}", "{}",
    ],
)  # fmt: skip
def test_dates(tmp_path, form):
    file = written(tmp_path, [form.format(clock(k)) for k in range(COUNT)])
    (run,), notices = load_runs(file)
    np.testing.assert_allclose(run.t, STEPS, atol=1e-12)
    assert notices == [f"{file}: t is a date and time: times count from the start of each run"]


def test_a_change_of_zone_is_no_jump(tmp_path):
    stamps = [f"2026-10-25T02:59:{k:02d}+02:00" for k in range(35, 60)]
    stamps += [f"2026-10-25T02:00:{k:02d}+01:00" for k in range(25)]
    (run,), _ = load_runs(written(tmp_path, stamps))
    np.testing.assert_array_equal(np.diff(run.t), 1.0)


@pytest.mark.parametrize(
    ("bad", "words"),
    [("25.11.2026", "row 8, column t: '25.11.2026' is no date and time, others are"),
     ("2026-11-25T12:53:01.007", "row 8, column t: .* has no time zone, others have")],
)  # fmt: skip
def test_one_date_of_another_form(tmp_path, bad, words):
    stamps = [f"2026-11-25T{clock(k)}Z" for k in range(COUNT)]
    stamps[7] = bad
    with pytest.raises(DataFileError, match=words):
        load_runs(written(tmp_path, stamps))


def test_unix_time_keeps_nanoseconds(tmp_path):
    stamps = [f"1764075181.{k:03d}000001" for k in range(COUNT)]
    (run,), notices = load_runs(written(tmp_path, stamps))
    np.testing.assert_allclose(run.t, STEPS, atol=1e-12)
    assert "t is Unix time: times count from the start of each run" in notices[0]


@pytest.mark.parametrize(("unit", "digits"), [("ms", 3), ("us", 6), ("ns", 9)])
def test_finer_unix_time_has_to_be_named(tmp_path, unit, digits):
    stamps = [f"1764075181{k:03d}".ljust(10 + digits, "0") for k in range(COUNT)]
    file = written(tmp_path, stamps)
    with pytest.raises(DataFileError, match=f"is no time in s: --unit t={unit} takes it as Unix"):
        load_runs(file)
    (run,), _ = load_runs(file, units={"t": unit})
    np.testing.assert_allclose(run.t, STEPS, atol=1e-12)


@pytest.mark.parametrize(("start", "step"), [(1_200_000_000, 10_000), (1.6e15, 1e7)])
def test_counters_of_micro_and_nanoseconds_are_no_unix_time(tmp_path, start, step):
    file = written(tmp_path, [f"{start + k * step:.0f}" for k in range(COUNT)])
    (run,), notices = load_runs(file)
    assert (run.t[0], run.t[1] - run.t[0], notices) == (start, step, [])


def test_each_run_has_its_own_start(tmp_path):
    file = tmp_path / "log.csv"
    rows = [f"{run},{1764075181 + 100 * run}.{k:03d},0,0" for run in (1, 2) for k in range(COUNT)]
    file.write_text("\n".join(["run,t,drive,x", *rows]))
    for run in load_runs(file)[0]:
        np.testing.assert_allclose(run.t, STEPS, atol=1e-12)


def test_usual_times_stay_as_they_are(tmp_path):
    (run,), notices = load_runs(written(tmp_path, [f"{100 + k * 0.5}" for k in range(COUNT)]))
    assert run.t[0] == 100.0
    assert notices == []


def test_typed_columns_of_frames():
    at = pl.Series(np.arange(COUNT) + 1764075181000).cast(pl.Datetime("ms"))
    for t in (at, at.dt.replace_time_zone("Europe/Berlin"), (at - at[0])):
        (run,) = runs_from_frame(pl.DataFrame({"t": t, "drive": 0.0, "x": 0.0}))
        np.testing.assert_allclose(run.t, STEPS, atol=1e-12)
    whole = pl.DataFrame({"t": np.arange(COUNT) + 1764075181, "drive": 0.0, "x": 0.0})
    np.testing.assert_array_equal(runs_from_frame(whole)[0].t, np.arange(COUNT))
