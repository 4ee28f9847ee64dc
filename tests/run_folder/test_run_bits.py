"""A run holds the bits of one call, whatever its chunks, and others can read it."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import xarray as xr
import zarr
from hypothesis import given, settings
from hypothesis import strategies as st
from run_cases import ALL, CLOSED, REDUCED, SIMULATED, data_files, same

import locosweep as ls
from locosweep.run_folder import writer
from locosweep.run_folder.arrays import encode
from locosweep.run_folder.plan import MOST_BYTES, Plan, cells_of_chunk, cut

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("chunk", [1, 7, 64, None])
def test_any_chunk_plan_gives_the_bits_of_one_call(
    name: str, chunk: int | None, tmp_path: Path
) -> None:
    if chunk == 1 and name == "closed":
        chunk = 12
    run = ls.sweep(**ALL[name], out=tmp_path / "run", chunk=chunk)
    assert run.complete
    whole = ls.sweep(**ALL[name])
    assert run.manifest.plan.count > 1 or chunk is None or chunk >= whole.values.size
    assert same(run, whole)
    assert run.fixed == whole.fixed
    assert run.to_result().how == whole.how
    assert run.status_counts() == whole.status_counts()
    assert run.to_polars().equals(whole.to_polars(), null_equal=True)


@pytest.mark.parametrize("threads", [1, 2, 8])
def test_threads_change_no_byte_of_the_store(threads: int, tmp_path: Path) -> None:
    one = ls.sweep(**CLOSED, out=tmp_path / "one", chunk=40, threads=1)
    more = ls.sweep(**CLOSED, out=tmp_path / "more", chunk=40, threads=threads)
    assert data_files(one.folder) == data_files(more.folder)


def test_a_sweep_without_axes_is_one_cell(tmp_path: Path) -> None:
    point: dict[str, Any] = {"mu_static": 0.5, "mu_coulomb": 0.3, "segments": 4}
    run = ls.sweep("mean_velocity", **point, out=tmp_path / "run")
    assert same(run, ls.sweep("mean_velocity", **point))
    assert xr.open_zarr(run.folder / "data.zarr")["mean_velocity"].shape == ()


@pytest.mark.parametrize("name", ["closed", "reduced"])
def test_zarr_and_xarray_read_the_store_without_us(name: str, tmp_path: Path) -> None:
    run = ls.sweep(**ALL[name], out=tmp_path / "run", chunk=17)
    whole = ls.sweep(**ALL[name])
    data = xr.open_zarr(run.folder / "data.zarr", chunks=None)
    assert list(data.sizes) == list(whole.axes)
    for axis, values in whole.axes.items():
        assert np.array_equal(data[axis], values)
        assert data[axis].attrs["units"]
    group = zarr.open_group(run.folder / "data.zarr", mode="r")
    for output in whole.outputs:
        for found in (data[output.name], group[output.name]):
            assert found.attrs["units"] == output.unit
            assert found.dtype == whole[output.name].dtype
            assert np.array_equal(found[...], whole[output.name], equal_nan=True)
        codes = group[f"{output.name}_status"]
        assert codes.metadata.dimension_names == tuple(whole.axes)
        assert codes.fill_value == 255
        assert math.isnan(group[output.name].fill_value)
        assert np.array_equal(codes[...], whole.status_of(output.name))


@pytest.mark.parametrize("status", [False, True])
def test_our_chunk_files_are_those_of_zarr(status: bool, tmp_path: Path) -> None:
    """The bytes of values; statuses may be compressed otherwise and read the same."""
    run = ls.sweep(**CLOSED, out=tmp_path / "run", chunk=40)
    name = "peak_power_status" if status else "peak_power"
    ours = zarr.open_array(run.folder / "data.zarr" / name, mode="r")
    theirs = zarr.create_array(
        tmp_path / "theirs", shape=ours.shape, chunks=ours.chunks, dtype=ours.dtype,
        fill_value=ours.fill_value, compressors=ours.compressors,
        chunk_key_encoding={"name": "default", "separator": "."},
        config={"write_empty_chunks": True},
    )  # fmt: skip
    theirs[...] = ours[...]
    for path in (run.folder / "data.zarr" / name).glob("c.*"):
        other = (tmp_path / "theirs" / path.name).read_bytes()
        assert path.read_bytes() == other
    assert len(list((tmp_path / "theirs").glob("c.*"))) == run.manifest.plan.count


def test_a_chunk_of_nothing_but_the_fill_value_has_a_file(tmp_path: Path) -> None:
    """All cells are NaN: what is there is told from what is not computed."""
    run = ls.sweep(
        "mean_velocity", mu_static=[0.1, 0.2], mu_coulomb=0.3, segments=[2, 3],
        slope_deg=[60.0, 70.0], out=tmp_path / "run", chunk=2,
    )  # fmt: skip
    assert np.isnan(run.to_result().values).all()
    assert len(list((run.folder / "data.zarr" / "mean_velocity").glob("c.*"))) == 4
    assert run.complete


def test_chunks_at_the_ends_of_axes_are_stored_whole(tmp_path: Path) -> None:
    run = ls.sweep(**CLOSED, out=tmp_path / "run", chunk=40)
    root = run.folder / "data.zarr" / "mean_velocity"
    assert {path.stat().st_size for path in root.glob("c.*")} == {
        math.prod(run.manifest.plan.chunk) * 8 + 4
    }


@given(
    shape=st.lists(st.integers(1, 60), max_size=5).map(tuple), cells=st.integers(1, 5000)
)  # fmt: skip
@settings(max_examples=60, deadline=None)
def test_plans_cover_each_cell_once(shape: tuple[int, ...], cells: int) -> None:
    plan = cut(shape, cells)
    assert math.prod(plan.chunk) <= max(cells, 1)
    if math.prod(shape) > 20_000 or plan.count > 200:
        return
    seen = np.zeros(shape, int)
    for chunk in range(plan.count):
        seen[plan.slices(chunk)] += 1
        assert plan.number(plan.key(chunk)) == chunk
        assert plan.cells(chunk) == seen[plan.slices(chunk)].size
    assert (seen == 1).all()


@pytest.mark.parametrize("key", ["c", "c.0", "c.0.9", "c.0.0.0", "d.0.0", "c.0.x", "zarr.json", ""])
def test_other_file_names_are_no_chunks(key: str) -> None:
    assert Plan((10, 4), (4, 2)).number(key) is None


def test_sizes_of_chunks_follow_bytes_and_seconds() -> None:
    assert cells_of_chunk(9, 1e-9) == MOST_BYTES // 9
    assert cells_of_chunk(9, 0.1) == 300
    assert cells_of_chunk(9, 1e4) == 1
    least = 10**12 / (MOST_BYTES // 9)
    assert least <= cut((10**6, 10**6), MOST_BYTES // 9).count < 1.01 * least


def test_encoding_leaves_its_input_alone() -> None:
    values = np.arange(6.0).reshape(2, 3)
    values.flags.writeable = False
    parts = encode(values, (4, 4), status=False)
    raw = b"".join(bytes(part) for part in parts)
    padded = np.frombuffer(raw[:-4], "<f8").reshape(4, 4)
    assert np.array_equal(padded[:2, :3], values)
    assert np.isnan(padded[2:]).all()


def test_progress_tells_all_evaluations(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    ls.sweep(**REDUCED, out=tmp_path / "run", chunk=5, progress=lambda d, t, _: told.append((d, t)))
    assert told[-1] == (9 * 3 * 38 * 3, 9 * 3 * 38 * 3)
    assert [d for d, _ in told] == sorted(d for d, _ in told)
    again: list[tuple[int, int]] = []
    ls.sweep(**REDUCED, out=tmp_path / "run", progress=lambda d, t, _: again.append((d, t)))
    assert again == [(0, 0)]


def test_a_token_stops_a_run_that_is_resumed(tmp_path: Path) -> None:
    token = ls.CancelToken()

    def stop(done: int, _total: int, _rate: float) -> None:
        if done:
            token.cancel()

    with pytest.raises(ls.Cancelled) as stopped:
        ls.sweep(**SIMULATED, out=tmp_path / "run", chunk=1, token=token, progress=stop)
    # Of the whole run, not of the chunk that the core was at.
    kept = ls.open_run(tmp_path / "run", allow_missing=True).state.done_count
    assert str(stopped.value).startswith(
        f"interrupted after {kept} of 15 points; {kept} of 15 chunks are kept in "
    )
    assert ls.open_run(tmp_path / "run").missing
    assert same(ls.sweep(**SIMULATED, out=tmp_path / "run"), ls.sweep(**SIMULATED))


def test_a_chunk_that_one_writer_renames_while_another_writes_the_log_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, begun = writer.Done, []

    def slow(*given: Any) -> Any:
        begun.append(given)
        if len(begun) == 1:
            time.sleep(0.3)
        return made(*given)

    monkeypatch.setattr(writer, "Done", slow)
    assert ls.sweep(**CLOSED, chunk=40, out=tmp_path / "run").complete
