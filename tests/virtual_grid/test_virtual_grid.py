"""Virtual grids compute what is taken from them, with the bits of a sweep."""

from __future__ import annotations

import importlib.metadata
import pickle
import sys
import time
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import locosweep as ls
from locosweep.registry import parameter
from locosweep.run_folder.written_spec import cells_of_spec
from locosweep.specs.simulation import Simulation
from locosweep.specs.span import Span
from locosweep.virtual_grid.backend import GridArray, LocosweepBackend

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[2]
SPEC = ls.Spec(
    ("mean_velocity", "peak_power"),
    (("mu_static", Span(0.2, 0.8, 7)), ("slope_deg", (0.0, 10.0, 30.0)), ("segments", Span(2, 8))),
    (("mu_coulomb", 0.3),),
)
REDUCED = ls.Spec(
    ("mean_velocity",), SPEC.axes, SPEC.fixed, "segments", ("argmax", "max"), None, "float32"
)
SIMULATED = ls.Spec(
    ("final_position",),
    (("mu_static", Span(0.3, 0.6, 4)), ("drive_amplitude", (0.5, 1.0, 2.0))),
    SPEC.fixed,
    simulation=Simulation(law="lugre", drive="sine"),
)
HUGE = ls.Spec(
    ("mean_velocity",),
    (
        ("mu_static", Span(0.2, 0.9, 10_000)),
        ("slope_deg", Span(0.0, 20.0, 10_000)),
        ("mass", Span(0.1, 1.0, 1000)),
    ),
    (("mu_coulomb", 0.3), ("segments", 4.0)),
)


@pytest.mark.parametrize("spec", [SPEC, REDUCED, SIMULATED], ids=["closed", "reduced", "simulated"])
def test_the_whole_grid_is_the_sweep(spec: ls.Spec) -> None:
    grid, result = ls.open_grid(spec), spec.run()
    assert list(grid.sizes) == list(result.axes)
    for output in result.outputs:
        found = grid[output.name]
        assert found.dtype == result[output.name].dtype
        assert found.attrs["units"] == output.unit
        assert found.to_numpy().tobytes() == result[output.name].tobytes()
        codes = grid[f"{output.name}_status"].to_numpy()
        assert np.array_equal(codes, result.status_of(output.name))
    for name, axis in result.axes.items():
        assert np.array_equal(grid[name], axis)
        assert grid[name].attrs["units"] == parameter(name).unit


# xarray itself fails on slices that go down and hold nothing, whatever the backend.
SLICES = st.slices(3).filter(lambda s: (s.step or 1) > 0 or len(range(*s.indices(3))) > 0)
INDEX = st.one_of(
    st.integers(-3, 2),
    SLICES,
    st.lists(st.integers(-3, 2), max_size=4).map(lambda v: np.array(v, int)),
)


@given(
    key=st.tuples(INDEX, INDEX, INDEX),
    name=st.sampled_from(["mean_velocity", "peak_power_status"]),
)
@settings(max_examples=80, deadline=None)
def test_any_index_gives_what_numpy_would(key: tuple[Any, ...], name: str) -> None:
    grid = ls.open_grid(SPEC).isel(mu_static=slice(2, 5), segments=slice(0, 6, 2))
    result = SPEC.run()
    whole = result.status_of("peak_power") if name.endswith("_status") else result[name]
    whole = whole[2:5, :, 0:6:2]
    picked = dict(zip(grid.sizes, key, strict=True))
    wanted = whole
    for dimension in (2, 1, 0):
        wanted = np.take(wanted, np.arange(3)[key[dimension]], axis=dimension)
    found = grid[name].isel(picked)
    assert found.shape == wanted.shape
    assert found.to_numpy().tobytes() == wanted.tobytes()


def test_points_and_labels_and_masks() -> None:
    grid, result = ls.open_grid(SPEC)["mean_velocity"], SPEC.run()["mean_velocity"]
    rows, columns = (xr.DataArray(v, dims="p") for v in ([6, 3, 4], [1, 5, 0]))
    points = grid.isel(mu_static=rows, segments=columns, slope_deg=0)
    assert np.array_equal(points, result[[6, 3, 4], 0, [1, 5, 0]], equal_nan=True)
    assert np.array_equal(grid.sel(slope_deg=10.0), result[:, 1], equal_nan=True)
    assert np.array_equal(grid[grid.mu_static > 0.45], result[3:], equal_nan=True)
    assert float(grid.isel(slope_deg=0).max()) == np.nanmax(result[:, 0])


def test_a_grid_of_1e11_points_opens_at_once_and_gives_a_slice() -> None:
    ls.open_grid(HUGE)
    taken = []
    for _ in range(5):
        begin = time.perf_counter()
        grid = ls.open_grid(HUGE)
        taken.append(time.perf_counter() - begin)
    # Measured: 2 to 7 ms.
    assert min(taken) < 0.05
    assert grid["mean_velocity"].size == 10**11
    cut = grid["mean_velocity"].isel(mass=500, mu_static=slice(5000, 5020), slope_deg=[0, 9999])
    wanted = ls.sweep(
        "mean_velocity", mu_static=grid.mu_static[5000:5020], slope_deg=[0.0, 20.0],
        mass=float(grid.mass[500]), mu_coulomb=0.3, segments=4,
    )  # fmt: skip
    assert cut.to_numpy().tobytes() == wanted.values.tobytes()


def test_more_than_the_memory_holds_is_refused() -> None:
    with pytest.raises(ls.InputError, match=r"this part of the grid needs 800 GB.*smaller part"):
        ls.open_grid(HUGE)["mean_velocity"].load()


def test_a_slice_takes_the_time_of_its_sweep() -> None:
    """A bound far above what is measured (1.1 times), so that only a wrong kernel breaks it."""
    grid = ls.open_grid(HUGE)
    part = grid["mean_velocity"][2000:3000, 4000:5000, 500]
    axes = {"mu_static": part.mu_static.to_numpy(), "slope_deg": part.slope_deg.to_numpy()}
    fixed = {"mass": float(part.mass), "mu_coulomb": 0.3, "segments": 4}

    def least(job: Callable[[], object]) -> float:
        taken = []
        for _ in range(15):
            begin = time.perf_counter()
            job()
            taken.append(time.perf_counter() - begin)
        return min(taken)

    swept = least(lambda: ls.sweep("mean_velocity", **axes, **fixed))
    sliced = least(lambda: grid["mean_velocity"][2000:3000, 4000:5000, 500].to_numpy())
    assert sliced < 3 * swept


def test_it_is_sent_to_workers_as_text(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text("t,drive\n0,2.0\n0.1,1.5\n1,-1.0\n")
    spec = ls.Spec(
        ("final_speed",), (("mass", (0.2, 0.4)),), (("mu_static", 0.4), ("mu_coulomb", 0.3)),
        simulation=Simulation(drive="table", drive_file="drive.csv", folder=tmp_path),
    )  # fmt: skip
    grid = ls.open_grid(spec)
    text = pickle.dumps(grid)
    assert len(text) < 20_000
    (tmp_path / "drive.csv").unlink()
    again = pickle.loads(text)  # noqa: S301 - what this test wrote
    assert again["final_speed"].to_numpy().tobytes() == grid["final_speed"].to_numpy().tobytes()
    array = GridArray(cells_of_spec(SPEC), 0, status=False)
    function, arguments = array.__reduce__()
    assert all(isinstance(a, str | int | None) for a in arguments)
    assert function(*arguments).shape == array.shape


def test_the_backend_opens_sweep_files(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    SPEC.save(path)
    backend = LocosweepBackend()
    assert backend.guess_can_open(path)
    assert backend.guess_can_open(str(path))
    for other in (tmp_path / "none.toml", ROOT / "pyproject.toml", tmp_path / "s.nc", 3, b"x"):
        assert not backend.guess_can_open(other)
    data = xr.open_dataset(path, engine=LocosweepBackend, drop_variables="peak_power")
    assert set(data.data_vars) == {"mean_velocity", "mean_velocity_status", "peak_power_status"}
    result = SPEC.run()["mean_velocity"]
    assert data["mean_velocity"].to_numpy().tobytes() == result.tobytes()


def test_the_entry_point_is_the_backend() -> None:
    table = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    value = table["xarray.backends"]["locosweep"]
    point = importlib.metadata.EntryPoint("locosweep", value, "xarray.backends")
    assert point.load() is LocosweepBackend


def test_the_extra_is_named_where_xarray_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [n for n in sys.modules if n.split(".")[0] == "xarray"]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, "locosweep.virtual_grid.backend")
    with pytest.raises(ls.InputError, match=r"pip install '\.\[xarray\]'"):
        ls.open_grid(SPEC)
