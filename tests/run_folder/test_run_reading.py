"""Open runs: parts, tables, holes; what is refused, and names of folders."""

from __future__ import annotations

import asyncio
import shutil
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl
import pytest
from run_cases import ALL, CLOSED, SIMULATED, data_files, forget_last_chunk, same

import locosweep as ls
from locosweep import _core
from locosweep.run_folder import begin, cells
from locosweep.run_folder.verify import verify

if TYPE_CHECKING:
    from collections.abc import Callable

SPEC: dict[str, Any] = {**CLOSED, "chunk": 40}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "run"
    ls.sweep(**SPEC, out=folder)
    return folder


@pytest.fixture
def holed(whole: Path, tmp_path: Path) -> Path:
    """A run whose last chunk was never finished."""
    folder = tmp_path / "holed"
    shutil.copytree(whole, folder)
    forget_last_chunk(folder)
    return folder


def test_parts_are_those_of_the_whole(whole: Path) -> None:
    run, result = ls.open_run(whole), ls.sweep(**CLOSED)
    part = run.to_result(mu_static=slice(2, 5), segments=slice(None, None, 3))
    for name in ("mean_velocity", "peak_power"):
        assert np.array_equal(part[name], result[name][2:5, :, ::3], equal_nan=True)
    assert part.axes["mu_static"].tolist() == result.axes["mu_static"][2:5].tolist()
    data = run.to_xarray()["peak_power"].isel(mu_static=[4, 0], slope_deg=1)
    assert np.array_equal(data, result["peak_power"][[4, 0], 1, :], equal_nan=True)
    with pytest.raises(ls.InputError, match="unknown axis 'mass'"):
        run.to_result(mass=slice(1))
    for odd in (3, None, [1, 2]):
        with pytest.raises(ls.InputError, match=r"segments is .* allowed is a slice"):
            run.to_result(segments=odd)
    nothing = run.to_result(mu_static=slice(2, 2))
    assert nothing.values.shape == (0, 3, 7)


def test_a_scan_gives_the_table(whole: Path) -> None:
    run, wanted = ls.open_run(whole), ls.sweep(**CLOSED).to_polars()
    axes = ["mu_static", "slope_deg", "segments"]
    frame = run.scan().collect()
    assert frame.columns == wanted.columns
    assert frame.schema == wanted.schema
    assert frame.sort(axes).equals(wanted.sort(axes), null_equal=True)
    few = run.scan().filter(pl.col("segments") == 4).select("mean_velocity", "mu_static").collect()
    assert few.columns == ["mean_velocity", "mu_static"]
    assert few.height == 21
    assert run.scan().head(5).collect().height == 5
    assert run.scan().head(3).filter(pl.col("mu_static") < 0).collect().height == 0
    best = run.scan().select(pl.col("peak_power").fill_nan(None).max()).collect().item()
    assert best == np.nanmax(ls.sweep(**CLOSED)["peak_power"])


def test_a_run_says_what_made_each_chunk(whole: Path) -> None:
    told = ls.open_run(whole).provenance
    (writer,) = told["writers"]
    assert told["numerics_version"] == writer["numerics_version"]
    assert (writer["locosweep"], writer["simd"]) == (_core.version(), _core.simd_level())
    assert writer["chunks"] == list(range(ls.open_run(whole).manifest.plan.count))
    assert told["spec_sha256"] == ls.open_run(whole).manifest.spec_sha256


def test_a_notebook_whose_loop_runs_fills_and_reads_a_run(tmp_path: Path) -> None:
    async def cell() -> None:
        run = ls.sweep(**SPEC, out=tmp_path / "run")
        assert same(run, ls.sweep(**CLOSED))
        assert verify(run.folder).faults == ()
        assert run.scan().head(2).collect().height == 2

    asyncio.run(cell())


def test_a_folder_may_be_moved_and_read_by_other_ways(whole: Path, tmp_path: Path) -> None:
    moved = tmp_path / "with a blank, ü and ." / "run.v1"
    moved.parent.mkdir()
    shutil.copytree(whole, moved)
    assert same(ls.open_run(str(moved)), ls.sweep(**CLOSED))
    assert ls.sweep(**SPEC, out=moved).complete
    (tmp_path / "link").symlink_to(moved)
    assert same(ls.open_run(tmp_path / "link"), ls.sweep(**CLOSED))


def test_holes_are_refused_unless_allowed(holed: Path) -> None:
    run = ls.open_run(holed)
    assert not run.complete
    assert len(run.missing) == 1
    for read in (run.to_xarray, run.to_result, run.to_polars, run.scan):
        with pytest.raises(ls.InputError, match=r"1 of \d+ chunks are not computed"):
            read()
    loose = ls.open_run(holed, allow_missing=True)
    data = loose.to_xarray().load()
    hole = data["mean_velocity_status"].to_numpy() == 255
    lost = run.manifest.plan.cells(run.missing[0])
    assert hole.sum() == lost
    assert np.isnan(data["mean_velocity"].to_numpy()[hole]).all()
    result = ls.sweep(**CLOSED)
    assert np.array_equal(
        data["mean_velocity"].to_numpy()[~hole], result["mean_velocity"][~hole], equal_nan=True
    )
    assert loose.to_polars().height == result.values.size - lost
    assert sum(loose.status_counts().values()) == result.values.size - lost
    with pytest.raises(ls.InputError, match="not computed as a whole"):
        loose.to_result()
    assert loose.to_result(mu_static=slice(1)).values.shape == (1, 3, 7)


def test_a_resume_with_another_sweep_is_refused(whole: Path) -> None:
    before = data_files(whole)
    for other in (
        {"mu_coulomb": 0.31}, {"segments": range(2, 10)}, {"quantity": "mean_velocity"},
        {"dtype": "float32"}, {"mass": 0.3},
    ):  # fmt: skip
        with pytest.raises(ls.InputError, match="holds another sweep"):
            ls.sweep(**(SPEC | other), out=whole)
    assert data_files(whole) == before


def test_another_drive_is_another_sweep(tmp_path: Path) -> None:
    table = ALL["table"]
    run = ls.sweep(**table, out=tmp_path / "run")
    other = {**table, "table": ([0.0, 0.1, 1.0], [2.0, 1.5, -1.1])}
    with pytest.raises(ls.InputError, match="with another drive"):
        ls.sweep(**other, out=run.folder)
    assert ls.sweep(**table, out=run.folder).complete


@pytest.mark.parametrize("how", ["version", "bits"])
def test_a_resume_by_a_version_with_other_bits_is_refused_unless_allowed(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    if how == "version":
        monkeypatch.setattr(begin, "NUMERICS_VERSION", 999)
    else:
        monkeypatch.setattr(cells.Cells, "probe", lambda _: "0" * 64)
    with pytest.raises(ls.InputError, match="gives other bits than"):
        ls.sweep(**SPEC, out=run.folder)
    assert ls.sweep(**SPEC, out=run.folder, allow_drift=True).complete


def test_the_same_axis_given_otherwise_is_the_same_sweep(tmp_path: Path) -> None:
    ls.sweep(**SPEC, out=tmp_path / "run")
    axes = {"segments": [2, 3, 4, 5, 6, 7, 8], "mu_static": list(np.linspace(0.2, 0.8, 7))}
    assert ls.sweep(**(SPEC | axes), out=tmp_path / "run").complete


def test_odd_axes_come_back_to_the_bit(tmp_path: Path) -> None:
    chance = np.random.default_rng(3)
    odd = {"mu_static": chance.uniform(0.3, 0.9, 5), "slope_deg": [-0.0, 1e-30, 0.1 + 0.2]}
    run = ls.sweep("mean_velocity", **odd, mu_coulomb=0.3, segments=4, out=tmp_path / "run")
    for name, values in odd.items():
        assert ls.open_run(run.folder).axes[name].tobytes() == np.asarray(values).tobytes()


def test_a_long_axis_of_odd_values_is_written_at_once(tmp_path: Path) -> None:
    values = np.sort(np.random.default_rng(3).uniform(0.3, 0.9, 20_000))
    begin = time.process_time()
    run = ls.sweep("mean_velocity", mu_static=values, mu_coulomb=0.3, segments=4,
                   out=tmp_path / "run")  # fmt: skip
    assert time.process_time() - begin < 10
    assert ls.open_run(run.folder).axes["mu_static"].tobytes() == values.tobytes()


def spoil_file(path: Path) -> None:
    path.write_text("mine")


def spoil_folder(path: Path) -> None:
    path.mkdir()
    (path / "mine.txt").write_text("mine")


@pytest.mark.parametrize(
    ("name", "prepare", "words"),
    [
        ("run", spoil_file, "a file is there"),
        ("run", spoil_folder, "not empty and no run folder"),
        ("run.zarr", None, "ends as a file's name does"),
        ("r.parquet", None, "ends as a file's name does"),
        ("x" * 256, None, "name too long"),
        ("nul\0", None, "cannot have a NUL"),
        ("file/run", lambda path: spoil_file(path.parent), "Not a directory"),
    ],
)
def test_names_and_places_that_are_refused(
    name: str, prepare: Callable[[Path], None] | None, words: str, tmp_path: Path
) -> None:
    path = tmp_path / name
    if prepare is not None:
        prepare(path)
    before = sorted(str(p) for p in tmp_path.rglob("*"))
    with pytest.raises(ls.InputError, match=words) as caught:
        ls.sweep(**SPEC, out=path)
    assert "\n" not in str(caught.value)
    assert sorted(str(p) for p in tmp_path.rglob("*")) == before


def test_a_place_where_nothing_can_be_made_is_refused() -> None:
    with pytest.raises(ls.InputError, match="/proc/run: cannot make this folder: No such file"):
        ls.sweep(**SPEC, out="/proc/run")


def test_missing_parents_are_made_and_a_slash_makes_a_folder(tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=f"{tmp_path}/a/b/run.v1/")
    assert run.folder == tmp_path / "a" / "b" / "run.v1"
    assert run.complete


def test_no_folder_and_no_run_folder_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(ls.DataFileError, match="no such folder"):
        ls.open_run(tmp_path / "none")
    with pytest.raises(ls.DataFileError, match=r"has no manifest\.json"):
        ls.open_run(tmp_path)


@pytest.mark.parametrize("shard", [(2, 2), (-1, 2), (0, 0), (0, 1, 2), "0/2", (0.0, 2), (True, 2)])
def test_shards_that_do_not_exist_are_refused(shard: Any, tmp_path: Path) -> None:
    with pytest.raises(ls.InputError, match="allowed is I/N"):
        ls.sweep(**SPEC, out=tmp_path / "run", shard=shard)
    assert not (tmp_path / "run").exists()


def test_options_of_folders_are_refused_without_one() -> None:
    for option in ({"shard": (0, 2)}, {"allow_drift": True}):
        with pytest.raises(ls.InputError, match="only together with out="):
            ls.sweep(**SPEC, **option)


def test_a_chunk_beyond_the_memory_limit_is_refused_before_it_starts(tmp_path: Path) -> None:
    big = {**SPEC, "mu_static": np.linspace(0.2, 0.8, 100_000), "chunk": 10**9}
    with pytest.raises(ls.InputError, match=r"chunks of the run needs .* fewer cells a chunk"):
        ls.sweep(**big, out=tmp_path / "run", memory_limit=10_000_000)
    assert not (tmp_path / "run").exists()


def test_the_extra_is_named_where_zarr_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ls.InputError, match=r"need zarr: pip install '\.\[runs\]'"):
        ls.sweep(**SPEC, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_run_describes_itself(whole: Path) -> None:
    run = ls.open_run(whole)
    text = repr(run)
    assert "Run of mean_velocity, peak_power" in text
    assert "segments [1]: 7 values, 2 .. 8" in text
    assert f"{run.manifest.plan.count} of {run.manifest.plan.count} chunks done" in text
    summary = run.summary()
    assert summary["axes"]["segments"] == {"count": 7, "first": 2.0, "last": 8.0}
    with pytest.raises(ls.InputError, match="unknown output 'speed'"):
        run.status_counts("speed")


def test_a_spec_file_runs_into_a_folder(tmp_path: Path) -> None:
    from locosweep.specs.sweep import Spec

    options = {k: v for k, v in SIMULATED.items() if k != "quantity"}
    run = ls.sweep("final_position", **options, out=tmp_path / "run")
    again = Spec.from_toml(run.manifest.spec).run(out=tmp_path / "run")
    assert isinstance(again, ls.Run)
    assert again.complete
    assert len(list((tmp_path / "run" / "log").iterdir())) == 1
