"""The sweep engine against NumPy, and everything around it that can go wrong."""

import contextlib
import gc
import itertools
import multiprocessing
import os
import platform
import signal
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import locosweep as ls
from locosweep import _core, registry
from locosweep._core import simd_levels

MU = {"mu_coulomb": 0.3}
# Feasible and not, smooth and with limits.
GRID = {
    "mu_static": np.linspace(0.2, 1, 7),
    "slope_deg": np.linspace(-30, 40, 9),
    "segments": range(1, 24),
    "viscous": [0.0, 0.7],
    **MU,
}
LONG = {
    "mu_static": np.linspace(0.31, 1, 400),
    "slope_deg": np.linspace(0, 20, 400),
    "viscous": np.linspace(0.1, 2, 40),
    "segments": range(2, 4000),
    **MU,
}
PATIENCE = 0.5
"""Seconds after which a drawn point is left alone: the largest ones take minutes."""


def same(a, b):
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()


def test_values_stand_where_their_axes_say():
    full = ls.sweep("mean_velocity", **GRID)
    assert full.shape == (7, 9, 23, 2)
    for place in itertools.product((0, 3, 6), (0, 4, 8), (0, 5, 22), (0, 1)):
        names = ("mu_static", "slope_deg", "segments", "viscous")
        point = {n: float(GRID[n][i]) for n, i in zip(names, place, strict=True)}
        one = ls.sweep("mean_velocity", **point, **MU)
        np.testing.assert_allclose(full.values[place], one.values, rtol=1e-14)
        assert full.status[place] == one.status


@pytest.mark.parametrize("record", registry.quantities(), ids=lambda q: q.name)
def test_no_value_exactly_where_a_status_is(record):
    grid = {"mu_static": [0.0, 0.3, 0.8], "slope_deg": [-60, -10, 0, 10, 60], "moving": [1, 2],
            "segments": [1, 2, 5], "drive_limit": [0, 0.5, 3, np.inf], "viscous": [0, 1],
            "brake": [0, 1], "mu_coulomb": [0.0, 0.3]}  # fmt: skip
    known = {p.name for p in record.parameters}
    grid = {name: values for name, values in grid.items() if name in known}
    more = {n: 1.0 for n in ("time", "speed") if n in known}
    if record.simulated and "mu_static" not in known:
        more |= {"mu_coulomb": 0.2, "drive_force": 0.4}
    result = ls.sweep(record.name, **grid, **more)
    assert (np.isnan(result.values) == (result.status != 0)).all()
    assert not np.isinf(result.values).any()
    counts = result.status_counts()
    assert sum(counts.values()) == result.values.size
    assert all(isinstance(status, ls.Status) for status in counts)


FOLDS = {
    "max": np.nanmax,
    "min": np.nanmin,
    "mean": np.nanmean,
    "count": lambda a, axis: np.isfinite(a).sum(axis).astype(float),
}


@pytest.mark.parametrize("over", ["mu_static", "slope_deg", "segments", "viscous"])
class TestReductions:
    def full(self, over):
        grid = ls.Grid(**GRID)
        return ls.sweep("mean_velocity", grid), list(grid.axes).index(over), grid

    @pytest.mark.parametrize("how", FOLDS)
    def test_folds(self, over, how):
        full, place, grid = self.full(over)
        got = ls.sweep("mean_velocity", grid, over=over, reduce=how)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            expected = FOLDS[how](full.values, axis=place)
        if how != "count":
            np.testing.assert_allclose(got.values, expected, rtol=1e-13)
        else:
            np.testing.assert_array_equal(got.values, expected)
        empty = np.isnan(full.values).all(place)
        if how != "count":
            assert (np.isnan(got.values) == empty).all()
            assert (got.status[empty] == ls.Status.NONE_FEASIBLE).all()

    @pytest.mark.parametrize("how", ["argmax", "argmin"])
    def test_places(self, over, how):
        full, place, grid = self.full(over)
        got = ls.sweep("mean_velocity", grid, over=over, reduce=how).values
        values = np.moveaxis(full.values, place, -1)
        sign = 1 if how == "argmax" else -1
        filled = np.where(np.isnan(values), -np.inf, sign * values)
        top = filled.max(-1, keepdims=True)
        # Ties go to the earlier one.
        tied = filled >= top - 1e-12 * np.abs(top)
        expected = grid.axes[over][tied.argmax(-1)]
        expected = np.where(np.isnan(values).all(-1), np.nan, expected)
        np.testing.assert_array_equal(got, expected)

    def test_last_feasible(self, over):
        full, place, grid = self.full(over)
        got = ls.sweep("mean_velocity", grid, over=over, reduce="last_feasible").values
        works = np.isfinite(np.moveaxis(full.values, place, -1))
        last = works.shape[-1] - 1 - works[..., ::-1].argmax(-1)
        expected = np.where(works.any(-1), grid.axes[over][last], np.nan)
        np.testing.assert_array_equal(got, expected)

    @pytest.mark.parametrize("q", [0, 0.25, 0.5, 0.9, 1])
    def test_quantiles(self, over, q):
        full, place, grid = self.full(over)
        got = ls.sweep("mean_velocity", grid, over=over, reduce="quantile", q=q).values
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            expected = np.nanquantile(full.values, q, axis=place)
        np.testing.assert_allclose(got, expected, rtol=1e-12)


def test_several_in_one_pass():
    names, how = ["mean_velocity", "cost_of_transport"], ["max", "argmax", "mean", "quantile"]
    both = ls.sweep(names, ls.Grid(**GRID), over="segments", reduce=how, q=0.3)
    assert [o.name for o in both.outputs] == [f"{n}_{h}" for n in names for h in how]
    for name, one in itertools.product(names, how):
        q = 0.3 if one == "quantile" else None
        alone = ls.sweep(name, ls.Grid(**GRID), over="segments", reduce=one, q=q)
        assert same(both[f"{name}_{one}"], alone.values)
        assert same(both.status_of(f"{name}_{one}"), alone.status)


def test_ties_go_to_the_earlier_value():
    grid = {"mu_static": 0.5, "segments": [5, 3, 4, 3, 2], **MU}
    assert ls.sweep("resistance", **grid, over="segments", reduce="argmax").values == 5
    again = {"mu_static": 0.5, "segments": 4, "gravity": 9.81, "stroke": [0.02] * 5, **MU}
    assert ls.sweep("mean_velocity", **again, over="stroke", reduce="argmin").values == 0.02


@settings(deadline=None, max_examples=25)
@given(
    st.integers(1, 9),
    st.integers(1, 3000),
    st.sampled_from([None, *registry.reductions()]),
    st.sampled_from(["mean_velocity", "peak_power", "best_segments", "preload"]),
    st.sampled_from(["mu_static", "segments", "viscous"]),
)
def test_threads_and_chunks_do_not_change_a_bit(threads, chunk, how, name, over):
    grid = dict(GRID, viscous=np.linspace(0, 1, 13))
    options = {} if how is None else {"over": over, "reduce": how}
    options |= {"q": 0.4} if how == "quantile" else {}
    one = ls.sweep(name, **grid, **options, threads=1)
    other = ls.sweep(name, **grid, **options, threads=threads, chunk=chunk)
    assert same(one.values, other.values)


def test_lanes_do_not_change_the_result():
    from locosweep._core import Sweep

    grid = ls.Grid(**GRID)
    job = Sweep(list(grid.axes.items()), list(grid.fixed.items()), [("mean_velocity", None, None)])
    results = []
    for level in simd_levels():
        array = np.full(grid.shape, 7.0)
        job.run([(0, array)], 2, None, None, None, level)
        results.append(array)
    for array in results:
        assert same(array, results[0])


@settings(deadline=None)
@given(st.lists(st.integers(1, 6), min_size=1, max_size=4), st.data())
def test_shapes(lengths, data):
    names = data.draw(st.permutations(["mu_static", "segments", "slope_deg", "stroke"]))
    ends = {"mu_static": 0.5, "segments": 4, "slope_deg": 5.0, "stroke": 0.01}
    grid = {
        n: [ends[n] + i for i in range(length)] for n, length in zip(names, lengths, strict=False)
    }
    fixed = {n: v for n, v in ends.items() if n not in grid}
    result = ls.sweep("mean_velocity", **grid, **fixed, **MU)
    assert result.shape == result.values.shape == result.status.shape == tuple(lengths)
    point = tuple(data.draw(st.integers(0, length - 1)) for length in lengths)
    at = {n: v[i] for (n, v), i in zip(grid.items(), point, strict=True)}
    one = ls.sweep("mean_velocity", **at, **fixed, **MU)
    np.testing.assert_allclose(result.values[point], one.values, rtol=1e-14)


@pytest.mark.slow
@settings(deadline=None)
@given(st.data())
def test_extreme_values_give_a_number_or_a_status(data):
    record = data.draw(st.sampled_from(registry.quantities()))
    point = {}
    for p in record.parameters:
        low, high = p.range
        if p.integer:
            point[p.name] = data.draw(st.sampled_from([low, low + 1, min(high, 1000), high]))
        else:
            values = [low, high, 0.0, -0.0, 1e-30, -1e-30, 1e-9, 0.3, 1.0, 1e30]
            if low > 0:
                values.append(np.nextafter(low, np.inf))
            point[p.name] = data.draw(st.sampled_from([v for v in values if low <= v <= high]))
    if record.simulated and "mu_static" not in point:
        point["mu_coulomb"] = data.draw(st.sampled_from([0.0, 1e-30, 0.3, 1e3]))
        point["drive_force"] = data.draw(st.sampled_from([0.0, -1.0, 0.3, 1e9]))
    if "segments_min" in point:
        low, high = sorted((point["segments_min"], point["segments_max"]))
        point |= {"segments_min": low, "segments_max": high}
    token = ls.CancelToken()
    alarm = threading.Timer(PATIENCE, token.cancel)
    alarm.start()
    try:
        result = ls.sweep(record.name, **point, token=token)
    except ls.Cancelled:
        # A million cycles of a gait: minutes of work, no fault.
        return
    finally:
        alarm.cancel()
        alarm.join()
    assert np.isfinite(result.values) == (result.status == 0)


class TestOut:
    def test_fills_what_is_given(self):
        out = np.empty((7, 9, 23, 2))
        result = ls.sweep("mean_velocity", **GRID, out=out)
        assert result.values is out
        assert same(out, ls.sweep("mean_velocity", **GRID).values)

    def test_single_precision_is_rounded_once(self):
        out = np.empty((7, 9, 23, 2), np.float32)
        ls.sweep("mean_velocity", **GRID, out=out)
        assert same(out, ls.sweep("mean_velocity", **GRID).values.astype(np.float32))
        assert same(out, ls.sweep("mean_velocity", **GRID, dtype=np.float32).values)

    def test_without_axes(self):
        out = np.empty(())
        ls.sweep("resistance", **MU, out=out)
        assert out == ls.sweep("resistance", **MU).values

    @pytest.mark.parametrize(
        ("out", "words"),
        [
            (np.zeros(4), "shape"),
            (np.zeros((3, 1)), "shape"),
            (np.zeros(()), "shape"),
            (np.zeros(3, int), "type"),
            (np.zeros(3, np.float16), "type"),
            (np.zeros(3, bool), "type"),
            (np.zeros(3, object), "type"),
            (np.zeros(3, ">f8"), "type"),
            (np.zeros(3, complex), "type"),
            (np.zeros(6)[::2], "contiguous"),
            (np.zeros(3)[::-1], "contiguous"),
            (np.frombuffer(b"\0" * 24), "writeable"),
            (np.zeros(25, np.uint8)[1:].view(float), "aligned"),
            ([], "0 arrays"),
            ([np.zeros(3)] * 2, "2 arrays"),
            (["x"], "str"),
            ([[1.0, 2.0, 3.0]], "list"),
        ],
    )
    def test_what_does_not_fit(self, out, words):
        with pytest.raises(ls.InputError, match=f"out.*{words}"):
            ls.sweep("resistance", mu_coulomb=[0.1, 0.2, 0.3], out=out)

    def test_the_same_array_twice(self):
        out = np.empty(3)
        for pair in ([out, out], [out, out[:]]):
            with pytest.raises(ls.InputError, match="out"):
                ls.sweep(["resistance", "mean_velocity"], mu_static=0.5, segments=4,
                         mu_coulomb=[0.1, 0.2, 0.3], out=pair)  # fmt: skip


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"threads": 0}, "threads is 0"),
        ({"threads": -1}, "threads"),
        ({"threads": 1.5}, "threads"),
        ({"threads": True}, "threads"),
        ({"threads": "2"}, "threads"),
        ({"chunk": 0}, "chunk is 0"),
        ({"chunk": -5}, "chunk"),
        ({"dtype": "float16"}, "dtype"),
        ({"dtype": int}, "dtype"),
        ({"dtype": "nope"}, "dtype"),
        ({"dtype": None, "threads": 0}, "threads"),
        ({"over": "mass"}, "over"),
        ({"reduce": "max"}, "over"),
        ({"q": 0.5}, "q"),
        ({"over": "stroke", "reduce": "max"}, "stroke"),
        ({"over": "mu_coulomb", "reduce": []}, "reduce"),
        ({"over": "mu_coulomb", "reduce": "maxx"}, "did you mean 'max'"),
        ({"over": "mu_coulomb", "reduce": ["max", "max"]}, "twice"),
        ({"over": "mu_coulomb", "reduce": ["max", "min"], "q": 0.5}, "q"),
        ({"over": "mu_coulomb", "reduce": "quantile"}, "q is missing"),
        ({"over": "mu_coulomb", "reduce": "quantile", "q": 1.5}, "q is 1.5"),
        ({"over": "mu_coulomb", "reduce": "quantile", "q": float("nan")}, "q is nan"),
        ({"memory_limit": 10}, "limit"),
        ({"threads": 2**64}, "threads is 1.84e[+]19: allowed is a whole number up to"),
        ({"chunk": 10**30}, "chunk is 1e[+]30: allowed is a whole number up to"),
        ({"chunk": 10**400}, "chunk is too large"),
    ],
    ids=str,
)
def test_arguments_are_checked(options, words):
    with pytest.raises(ls.InputError, match=words):
        ls.sweep("resistance", mu_coulomb=[0.1, 0.2, 0.3], **options)


@pytest.mark.parametrize(
    ("quantity", "words"),
    [("mean_velocty", "did you mean 'mean_velocity'"), ([], "empty"), ("", "unknown quantity"),
     (["resistance", "resistance"], "twice"), ("velocity", "time is needed")],
)  # fmt: skip
def test_quantities_are_checked(quantity, words):
    with pytest.raises(ls.InputError, match=words):
        ls.sweep(quantity, mu_static=0.5, mu_coulomb=0.3, segments=4)


def test_too_much_memory_is_refused_before_it_is_taken():
    axis = np.linspace(0.1, 1, 100_000)
    begin = time.perf_counter()
    with pytest.raises(ls.InputError, match=r"needs 80 GB, the limit is 1 GB.*dtype='float32'"):
        ls.sweep("resistance", mu_coulomb=axis, mass=axis, memory_limit=10**9)
    with pytest.raises(ls.InputError, match="limit"):
        ls.sweep("resistance", mu_coulomb=axis, mass=axis, gravity=axis[:1000])
    assert time.perf_counter() - begin < 1.0


def test_more_points_than_can_be_counted():
    axis = np.ones(2**16)
    grid = dict.fromkeys(["mass", "gravity", "mu_coulomb", "stroke", "mu_static"], axis)
    with pytest.raises(ls.InputError, match="64 bits"):
        ls.sweep("resistance", **grid)


class TestProgress:
    def test_is_told_at_the_end(self):
        calls = []
        ls.sweep("mean_velocity", **GRID, progress=lambda *a: calls.append(a))
        done, total, rate = calls[-1]
        assert done == total == 7 * 9 * 23 * 2
        assert rate > 0

    def test_rises_and_is_not_called_often(self):
        calls, token = [], ls.CancelToken()

        def note(done, total, rate):
            calls.append((time.perf_counter(), done, total, rate))
            if len(calls) == 5:
                token.cancel()

        with pytest.raises(ls.Cancelled):
            ls.sweep(
                "mean_velocity", **LONG, over="segments", reduce="mean", progress=note, token=token
            )
        assert all(b[0] - a[0] > 0.08 for a, b in itertools.pairwise(calls))
        assert all(0 <= a[1] <= b[1] <= b[2] for a, b in itertools.pairwise(calls))
        assert token.done >= calls[-1][1]

    def test_its_errors_surface(self):
        def fail(*_):
            raise ZeroDivisionError("mine")

        with pytest.raises(ZeroDivisionError, match="mine"):
            ls.sweep("mean_velocity", **LONG, over="segments", reduce="mean", progress=fail)
        assert np.isfinite(ls.sweep("resistance", **MU).values)

    def test_line(self, capsys):
        ls.sweep("mean_velocity", **GRID, progress=True)
        assert "100%" in capsys.readouterr().err


def test_another_thread_cancels():
    token = ls.CancelToken()
    timer = threading.Timer(0.2, token.cancel)
    timer.start()
    begin = time.perf_counter()
    with pytest.raises(ls.Cancelled):
        ls.sweep("mean_velocity", **LONG, over="segments", reduce="mean", token=token)
    assert 0.15 < time.perf_counter() - begin < 0.2 + 0.5
    timer.join()


def test_a_used_token_stops_at_once():
    token = ls.CancelToken()
    token.cancel()
    with pytest.raises(ls.Cancelled):
        ls.sweep("mean_velocity", **LONG, over="segments", reduce="mean", token=token)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs timers")
def test_ctrl_c_within_a_quarter_of_a_second():
    def ring(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, ring)
    late = []
    try:
        # Thrice, as a busy machine may stand still for longer than this once.
        for _ in range(3):
            asked = time.perf_counter() + 0.2
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            with pytest.raises(KeyboardInterrupt):
                ls.sweep("mean_velocity", **LONG, over="segments", reduce="mean")
            late.append(time.perf_counter() - asked)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert min(late) <= 0.25
    assert np.isfinite(ls.sweep("resistance", **MU).values)


def test_sweeps_in_many_threads():
    expected = ls.sweep("mean_velocity", **GRID).values
    found = []

    def work():
        found.extend(same(ls.sweep("mean_velocity", **GRID).values, expected) for _ in range(10))

    threads = [threading.Thread(target=work) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 60


def test_other_threads_run_meanwhile():
    token, ticks = ls.CancelToken(), []

    def tick():
        for _ in range(20):
            time.sleep(0.01)
            ticks.append(1)
        token.cancel()

    thread = threading.Thread(target=tick)
    thread.start()
    with contextlib.suppress(ls.Cancelled):
        ls.sweep("mean_velocity", **LONG, over="segments", reduce="mean", token=token)
    thread.join()
    assert len(ticks) == 20


def _child(pipe):
    big = dict(GRID, viscous=np.linspace(0, 1, 50))
    pipe.send(ls.sweep("mean_velocity", **big, threads=2).values.tobytes())
    pipe.close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_fork_after_first_use():
    big = dict(GRID, viscous=np.linspace(0, 1, 50))
    expected = ls.sweep("mean_velocity", **big, threads=2).values.tobytes()
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(theirs,))
    child.start()
    try:
        assert ours.poll(20), "the child hangs"
        assert ours.recv() == expected
        child.join(20)
        assert child.exitcode == 0
    finally:
        child.kill()
        child.join()


def test_nothing_leaks():
    def some():
        for _ in range(200):
            ls.sweep("mean_velocity", **GRID)
            with contextlib.suppress(ls.InputError):
                ls.sweep("mean_velocity", **GRID, mass=-1)

    some()
    gc.collect()
    before = len(gc.get_objects())
    some()
    gc.collect()
    assert len(gc.get_objects()) - before < 100


def test_status_of_an_unknown_output():
    result = ls.sweep("resistance", **MU)
    for ask in (result.status_of, result.output, result.__getitem__):
        with pytest.raises(ls.InputError, match="unknown output 'resistence'"):
            ask("resistence")


def test_statuses_are_those_of_the_core():
    from locosweep import _core

    known = [(int(s), s.name.lower(), s.sentence) for s in ls.Status]
    assert known == _core.statuses()


def test_names_of_the_package():
    assert set(ls.__all__) <= set(dir(ls))
    assert all(getattr(ls, name) is not None for name in ls.__all__)
    with pytest.raises(AttributeError, match="no attribute 'swep'"):
        _ = ls.swep


def test_vectors_are_compiled_into_their_kernels():
    # What the compiler did not inline runs as a call for every single operation, and
    # says so by its name among the symbols.
    symbols = Path(_core.__file__).read_bytes()
    if platform.machine() in ("x86_64", "AMD64"):
        assert b"vectorize_avx2" in symbols
    assert b"__fearless_simd_kernel" not in symbols


def test_progress_with_a_used_token_counts_from_zero():
    token, calls = ls.CancelToken(), []
    for _ in range(2):
        ls.sweep(
            "mean_velocity", **{**LONG, "viscous": 0.1, "segments": range(2, 300)},
            over="segments", reduce="mean", token=token, progress=lambda *a: calls.append(a),
        )  # fmt: skip
    assert max(done for done, _, _ in calls) == calls[-1][1]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"grid": {"segments": 4}}, "grid is a dict"),
        ({"out": 5}, "out is 5"),
        ({"token": 5}, "token is 5"),
        ({"memory_limit": "1GB"}, "memory_limit is '1GB'"),
        ({"law": "lugre"}, "law is given, but mean_velocity is not simulated"),
        ({"quantity": None}, "quantity is None"),
        ({"reduce": 5}, "reduce is 5"),
        ({"over": "segments", "reduce": "quantile", "q": "0.5"}, "q is '0.5'"),
        ({"over": "segments", "reduce": "quantile", "q": True}, "q is True"),
    ],
)
def test_what_is_no_argument_of_a_sweep_is_named(wrong, words):
    with pytest.raises(ls.InputError, match=words):
        ls.sweep(
            **{"quantity": "mean_velocity", **MU, "mu_static": 0.5, "segments": [3, 4], **wrong}
        )


def test_a_part_without_axes_has_the_shape_of_one_value():
    one = ls.sweep("mean_velocity", **MU, mu_static=0.5, segments=[3, 4]).sel(segments=4)
    assert one.values.shape == one.shape == ()
    assert float(one.to_xarray()["mean_velocity"]) == float(one.values)
