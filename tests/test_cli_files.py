"""Files and options that commands used to take, lose or overwrite without a word."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.measured import load_runs
from locosweep.specs.simulation import read_drive

if TYPE_CHECKING:
    from pathlib import Path

T = np.arange(200) * 0.01
NOMINAL = "[robot]\nmass = 0.2\n[surface]\nmu_coulomb = 0.3\n[sensor]\nposition_noise = 1e-5\n"
SETTINGS = ("--set", "mu_coulomb=0.3", "--set", "mu_static=0.5")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with runs, a nominal model and a drive."""
    monkeypatch.chdir(tmp_path)
    frame = pl.DataFrame({"t": T, "drive": np.sin(9.0 * T), "x": 0.01 * np.sin(9.0 * T)})
    frame.write_csv("runs.csv")
    frame.select("t", "drive").write_csv("drive.csv")
    (tmp_path / "nominal.toml").write_text(NOMINAL)
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        "simulate --model nominal.toml --runs runs.csv --out runs.csv",
        "simulate --drive-file drive.csv --set mu_coulomb=0.3 --set mu_static=0.5 --out drive.csv",
        "distinguish nominal.toml --drive-file drive.csv --out drive.csv",
        "sweep mean_velocity --set mu_coulomb=0.3 --set mu_static=0.5 --out r.parquet"
        " --save-spec r.parquet",
        "init runs.csv --out . --force",
    ],
)
def test_no_input_is_overwritten(
    here: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.read_bytes() for path in here.iterdir()}
    assert main(command.split()) == 2
    assert "\n" not in capsys.readouterr().err.strip()
    assert {path: path.read_bytes() for path in here.iterdir()} == before


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            "propagate mean_velocity --axis segments=2:5 --set segments=4 --set mu_coulomb=0.3"
            " --unknown mu_static=0.4:0.6 --samples 16",
            "segments is given twice",
        ),
        (
            "simulate --model nominal.toml --runs runs.csv --samples 7 --out o.csv",
            "--samples is given beside",
        ),
        ("diagnose runs.csv --nominal nominal.toml --out d --runs ,", "--runs is ','"),
        ("reproduce gap --robot nominal.toml --out g", "--robot is given beside gap"),
        ("laws coulomb --out laws --set mu_coulomb=0", "the friction level of coulomb is 0"),
        ("init runs.csv --out o --pause nan", "pause is nan"),
        ("screen " + 300 * "a" + ".csv --nominal nominal.toml", "too long"),
    ],
)
@pytest.mark.usefixtures("here")
def test_what_was_ignored_or_ended_in_an_error_is_told(
    command: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command.split()) == 2
    said = capsys.readouterr().err.strip()
    assert words in said
    assert "cannot write" not in said
    assert "\n" not in said


def test_effects_of_a_robot_file_are_said_to_be_left_out(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "eff.toml").write_text(NOMINAL + "[effects.viscous_friction]\nc = 50.0\n")
    assert (
        main(["simulate", "--robot", "eff.toml", "--set", "drive_force=3", "--out", "o.csv"]) == 0
    )
    assert "effects are left out (viscous_friction)" in capsys.readouterr().err


@pytest.mark.usefixtures("here")
def test_the_energy_that_is_left_open_is_that_of_the_method_used(
    capsys: pytest.CaptureFixture[str],
) -> None:
    settings = ["drive_amplitude=20", "viscous=0.5", "drive_frequency=5", "time_step=0.05"]
    given = [word for text in settings for word in ("--set", text)]
    assert main(["simulate", "--law", "stribeck", "--drive", "sine", *SETTINGS, *given,
                 "--out", "o.csv"]) == 0  # fmt: skip
    assert "ledger" not in capsys.readouterr().err


def test_endings_in_capitals_and_files_that_differ_in_them_are_runs(here: Path) -> None:
    frame = pl.read_csv("runs.csv")
    (here / "logs").mkdir()
    frame.write_csv("logs/A.CSV")
    frame.write_csv("logs/a.csv")
    frame.write_csv("logs/a.tsv", separator="\t")
    frame.write_parquet("R.PARQUET")
    runs, _ = load_runs("logs")
    assert len({run.label for run in runs}) == 3
    assert len(load_runs("R.PARQUET")[0]) == 1


def test_times_of_whole_seconds_are_times() -> None:
    stamps = np.datetime64("2026-11-25T12:00:00", "s") + np.arange(60).astype("timedelta64[s]")
    runs, _ = load_runs({"t": stamps, "drive": np.ones(60), "x": np.zeros(60)})
    assert runs[0].t[-1] - runs[0].t[0] == pytest.approx(59.0)


def test_dates_below_a_missing_one_are_dates(here: Path) -> None:
    rows = ["NaN,1,0", *(f"2026-11-25T12:53:{i:02d},1,0" for i in range(40))]
    (here / "dates.csv").write_text("t,drive,x\n" + "\n".join(rows) + "\n")
    with pytest.raises(ls.DataFileError, match=r"row 1, column t: missing"):
        load_runs("dates.csv")


def test_millinewton_metres_are_torques() -> None:
    runs, _ = load_runs(
        {"t": T, "drive": 1e3 * np.ones(T.size), "x": np.zeros(T.size)}, units={"drive": "mNm"},
        rotary=True,
    )  # fmt: skip
    assert runs[0].drive[0] == pytest.approx(1.0)


@pytest.mark.parametrize("column", ["x", "force"])
def test_friction_data_without_a_value_name_the_column(column: str) -> None:
    data = {"t": T, "v": np.cos(T), "force": np.ones(T.size), "x": T}
    with pytest.raises(ls.DataFileError, match=f"column {column}: no values"):
        ls.fit_friction(data | {column: np.full(T.size, np.nan)})


@pytest.mark.usefixtures("here")
def test_a_column_without_numbers_is_named_by_init(capsys: pytest.CaptureFixture[str]) -> None:
    frame = pl.read_csv("runs.csv").with_columns(empty=pl.lit(None, pl.Float64))
    frame.drop("x").write_csv("log.csv")
    assert main(["init", "log.csv", "--column", "x=empty", "--out", "o"]) == 2
    assert "internal error" not in capsys.readouterr().err


def test_a_drive_file_without_rows_is_named(here: Path) -> None:
    (here / "none.csv").write_text("t,drive\n,\n,\n")
    with pytest.raises(ls.DataFileError, match=r"none\.csv: no rows"):
        ls.sweep("final_position", mu_coulomb=0.3, table=read_drive("none.csv"))


def test_friction_needs_a_force() -> None:
    data = {"t": T, "v": np.cos(9.0 * T), "force": np.zeros(T.size)}
    for force in (0.0, 1e200):
        with pytest.raises(ls.InputError, match="the friction force is up to"):
            ls.fit_friction(data | {"force": np.full(T.size, force)})


def test_what_is_unknown_is_a_mapping() -> None:
    for wrong in (["mass"], {3: "0.1:0.2"}):
        with pytest.raises(ls.InputError, match="allowed are distributions by names"):
            ls.propagate("mean_velocity", wrong)
