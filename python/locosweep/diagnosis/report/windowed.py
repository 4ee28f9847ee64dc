"""Gap, localization and curves of runs that were replayed in windows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.data.regimes import regimes_of
from locosweep.diagnosis.estimate.window_plan import adjoining_windows
from locosweep.diagnosis.report import localization as where
from locosweep.diagnosis.report.improvement import HORIZONS, RESAMPLES, units_of
from locosweep.diagnosis.report.result import Trace

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.estimate.shooting import WindowProblem
    from locosweep.diagnosis.estimate.window_plan import Plan

    Floats = NDArray[np.float64]

_JUDGED = 60_000
"""Samples kept from the fit on which every candidate's shrink is judged."""
_WORST = 0.1
"""Part of the windows that a push may be in."""
_MOST = 0.4
_MANY = 20
"""One window of so many should not hold that part of what is left."""
_FEW = 0.05
"""Part of a run's gap whose fall is no fall."""


class ShotReport:
    """Errors of models in windows from end to end of all runs."""

    def __init__(self, whole: Problem, plan: Plan) -> None:
        self.whole, self.plan = whole, plan
        self.tiles: WindowProblem = adjoining_windows(whole, plan)
        self.record = np.array([window.record for window in self.tiles.windows], dtype=int)
        self.units = units_of(whole)
        ends = np.array([window.span[1] for window in self.tiles.windows])
        if whole.train_fraction < 1.0:
            kept = ends > whole.train_fraction * whole.lengths[self.record]
        else:
            kept = np.isin(self.record, whole.held)
        tiles = np.flatnonzero(kept)
        most = max(1, int(_JUDGED / max(float(np.mean(self.tiles.lengths)), 1.0)))
        if tiles.size > most:
            tiles = tiles[((np.arange(most) + 0.5) * tiles.size / most).astype(int)]
        self.judged: list[int] = tiles.tolist()

    def squares(self, point: Point) -> dict[str, list[Floats]]:
        """Squared errors of a model by channel and run; NaN where nothing counts."""
        e = self.tiles.errors([point], range(len(self.tiles.runs)))
        return {c: self._by_run(values[0] ** 2, np.nan) for c, values in e.items()}

    def _by_run(self, values: Floats, missing: float) -> list[Floats]:
        """Lay windows' values over the samples of the runs; the parts that count win."""
        found = [np.full(int(n), missing) for n in self.whole.lengths]
        for counting in (False, True):
            for i, window in enumerate(self.tiles.windows):
                own = values[self.tiles.starts_at[i] : self.tiles.starts_at[i + 1]]
                a, (first, last) = window.span[0], window.counted
                if not counting:
                    first, last = 0, own.size
                    fresh = found[window.record][a : a + last]
                    found[window.record][a : a + last] = np.where(np.isnan(fresh), own, fresh)
                else:
                    found[window.record][a + first : a + last] = own[first:last]
        return found

    def gap(
        self,
        before: Point,
        after: Point,
        seed: int,
        warnings: list[str],
        channel: str | None = None,
    ) -> dict[str, Any]:
        """Return the report's `gap`."""
        both = self.tiles.errors([before, after], self.judged)
        sums = {c: _sums(e**2, self.tiles.lengths[self.judged]) for c, e in both.items()}
        counts = {c: s[0, :, 1].sum() for c, s in sums.items()}
        rms = {c: np.sqrt(s[:, :, 0].sum(axis=1) / max(counts[c], 1.0)) for c, s in sums.items()}
        known = {c: float(rms[c][0]) / self.tiles.noise[c].sd for c in sums if counts[c] > 0}
        channel = channel or (max(known, key=lambda c: known[c]) if known else "x")
        old, new = (float(value) for value in rms[channel])
        floor = float(self.tiles.noise[channel].sd)
        same = before.names == after.names
        shrink = explained = None
        interval: list[float] | None = None
        if channel in known and old > 1.05 * floor:
            shrink = 0.0 if same else 1.0 - new / old
            if old**2 > 1.2 * floor**2:
                explained = 0.0 if same else 1.0 - (new**2 - floor**2) / (old**2 - floor**2)
            table = sums[channel][:, :, 0]
            interval = [0.0, 0.0] if same else _interval(table, shrink, seed)
        elif not same:
            warnings.append(
                "the windows kept from the fit show no gap beyond the noise: "
                "how far it shrinks there is not known"
            )
        labels = [run.label for run in self.whole.runs]
        held = list(self.whole.held)
        runs = held or list(range(len(labels)))
        return {
            "channel": channel,
            "unit": self.units[channel],
            "metric": f"rmse, free-running simulation over {self.plan.seconds:.3g} s from the "
            "measured state, "
            + ("last part of the run" if self.whole.train_fraction < 1.0 else "held-out runs"),
            "before": old if channel in known else None,
            "after": new if channel in known else None,
            "noise_floor": floor,
            "shrink": shrink,
            "shrink_ci": interval,
            "explained": explained,
            "horizons": where.horizons(self.whole, before, after, runs, HORIZONS)
            if channel == "x"
            else [],
            "held_out": [labels[r] for r in held],
            "used_for_fit": [labels[r] for r in self.whole.fitted],
        }

    def without_worst(self, before: Point, after: Point, channel: str) -> float | None:
        """Return how much a model shrinks the error in windows kept from fits, but for the worst.

        A push from outside in one window would outweigh all that a model does in others.
        """
        e = self.tiles.errors([before, after], self.judged)[channel]
        sums = _sums(e**2, self.tiles.lengths[self.judged])
        means = sums[:, :, 0] / np.maximum(sums[:, :, 1], 1.0)
        order = np.argsort(means.max(axis=0), kind="stable")
        old, new = means[:, order[: int(np.ceil((1.0 - _WORST) * order.size))]].sum(axis=1)
        return float(1.0 - np.sqrt(new / old)) if old > 0.0 else None

    def places(self, before: Point, after: Point, channel: str) -> dict[str, Any]:
        """Return the report's `where`, but for its site, and what needs saying of runs."""
        old, new = self.squares(before), self.squares(after)
        rows = []
        for c in self.tiles.channels:
            total = float(np.nansum(np.concatenate(old[c]))) / self.tiles.noise[c].sd ** 2
            row = {"channel": c, "before": _rms(old[c]), "after": _rms(new[c])}
            rows.append((total, {**row, "unit": self.units[c]}))
        whole = sum(total for total, _ in rows)
        squares = [np.nan_to_num(s) for s in old[channel]]
        windows = where.windows(self.whole, squares)
        regimes = [regimes_of(motion) for motion in self.whole.motions]
        return {
            "channels": [{**row, "share": float(t / whole) if whole else 0.0} for t, row in rows],
            "runs": self._rows(old[channel], new[channel]),
            # Windows start anew: where a gap shows is where it arises.
            "windows": windows,
            "origin": [dict(row) for row in windows],
            "regimes": where.regime_shares(squares, regimes),
        }

    def runs(self, before: Point, after: Point, channel: str) -> list[dict[str, Any]]:
        """Return errors of every run before and after."""
        return self._rows(self.squares(before)[channel], self.squares(after)[channel])

    def _rows(self, old: Sequence[Floats], new: Sequence[Floats]) -> list[dict[str, Any]]:
        return [
            {"run": run.label, "before": _rms([a]), "after": _rms([b])}
            for run, a, b in zip(self.whole.runs, old, new, strict=True)
        ]

    def traces(self, before: Point, after: Point) -> tuple[Trace, ...]:
        """Curves of the runs; the simulated ones start anew with every window."""
        read = self.tiles.replay([before, after])
        laid = {c: [self._by_run(values, np.nan) for values in rows] for c, rows in read.items()}
        return tuple(
            Trace(
                run.label,
                run.t,
                run.drive,
                self.whole.nominal["slope_deg"] if run.slope_deg is None else run.slope_deg,
                dict(run.channels),
                {c: rows[0][r] for c, rows in laid.items()},
                {c: rows[1][r] for c, rows in laid.items()},
                regimes_of(self.whole.motions[r]),
                r in self.whole.held,
            )
            for r, run in enumerate(self.whole.runs)
        )

    def said_of_runs(self, rows: Sequence[dict[str, Any]], channel: str) -> list[str]:
        """Say which runs do not move, and which no effect helps as it does the others."""
        said = []
        noise = self.whole.noise["x"]
        still = []
        for run in self.whole.runs:
            x = run.channels["x"]
            x = x[np.isfinite(x)]
            n = max(1, x.size // 2000)
            moves = np.abs(np.diff(x[::n])) > 4.0 * max(noise.sd, noise.step)
            if moves.mean() < 0.01:
                still.append(run.label)
                said.append(f"run {run.label}: the head hardly ever moves: it says what holds "
                            "the head, and little of what moves it")  # fmt: skip
        left = {row["run"]: row["after"] for row in rows if row["after"] is not None}
        usual = float(np.median(list(left.values()))) if left else 0.0
        for row in rows:
            if row["run"] in still or row["before"] is None or len(rows) < 3:
                continue
            helped = row["after"] < (1.0 - _FEW) * row["before"]
            if row["after"] > 3.0 * usual and not helped:
                said.append(
                    f"run {row['run']}: no effect makes its error smaller than "
                    f"{row['after']:.2g} {self.units[channel]}, {row['after'] / usual:.2g} times "
                    "the usual one: something acts there that the other runs whiteness, which may "
                    "be clearer without it"
                )
        return said

    def said_of_windows(self, point: Point, channel: str) -> list[str]:
        """Say where a few windows hold most of what a model leaves."""
        squares = [np.nan_to_num(s) for s in self.squares(point)[channel]]
        first = where.windows(self.whole, squares)[:1]
        return [
            f"run {row['run']}, {row['t0']:.3g} to {row['t1']:.3g} s holds {row['share']:.0%} of "
            "the squared error that is left: a push from outside, or a reading that jumped?"
            for row in first
            if row["share"] > _MOST and len(self.tiles.runs) >= _MANY
        ]


def _rms(parts: Sequence[Floats]) -> float | None:
    values = np.concatenate(list(parts))
    values = values[np.isfinite(values)]
    return float(np.sqrt(values.mean())) if values.size else None


def _sums(squares: Floats, lengths: NDArray[np.intp]) -> Floats:
    """Sum and number of what is known in each window; shape (points, windows, 2)."""
    edges = np.concatenate([[0], np.cumsum(lengths)])[:-1]
    ok = np.isfinite(squares)
    top = np.add.reduceat(np.where(ok, squares, 0.0), edges, axis=1)
    return np.stack([top, np.add.reduceat(ok.astype(float), edges, axis=1)], axis=2)


def _interval(table: Floats, shrink: float, seed: int) -> list[float]:
    """90 % interval of the shrink on as many windows like these."""
    generator = np.random.default_rng(seed)
    picks = generator.integers(0, table.shape[1], size=(RESAMPLES, table.shape[1]))
    old, new = table[:, picks].sum(axis=2)
    low, high = np.quantile(1.0 - np.sqrt(new / np.maximum(old, 1e-300)), [0.05, 0.95])
    return [float(min(low, shrink)), float(max(high, shrink))]
