"""The split into runs that are fitted and runs that check the fit."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.holdout import hold_out, known_labels
from locosweep.errors import InputError
from locosweep.files.runs import Run


def runs(count: int, slopes: list[float | None] | None = None) -> list[Run]:
    slopes = slopes or [None] * count
    t = np.arange(10.0)
    return [Run(f"r{k}", t, t, {"x": t}, slopes[k]) for k in range(count)]


class TestAsked:
    def test_runs_that_are_asked_for_are_kept(self) -> None:
        assert hold_out(runs(4), ["r3", "r1"], [1.0] * 4) == ((1, 3), 1.0, True)

    def test_a_name_that_is_none(self) -> None:
        with pytest.raises(InputError, match="no run 7: there are r0, r1"):
            known_labels(runs(2), ["7"])
        known_labels(runs(2), ["r1"])

    def test_one_has_to_be_left(self) -> None:
        with pytest.raises(InputError, match="leave at least one"):
            hold_out(runs(2), ["r0", "r1"], [1.0] * 2)


class TestChosen:
    def test_one_run_keeps_its_last_part(self) -> None:
        assert hold_out(runs(1), None, [1.0]) == ((), 0.7, False)

    def test_of_one_run_the_last_readings_are_kept(self) -> None:
        (run,) = runs(1)
        x = np.where(np.arange(10) < 5, run.t, np.nan)
        (_, fraction, _) = hold_out([Run("r0", run.t, run.t, {"x": x})], None, [1.0])
        assert fraction == pytest.approx(0.3)

    def test_the_gap_most_like_that_of_all(self) -> None:
        # The mean is 25: 18 is next in difference, 33 in ratio, which counts.
        assert hold_out(runs(4), None, [18.0, 33.0, 1.0, 48.0])[0] == (1,)

    @pytest.mark.parametrize(("count", "kept"), [(2, 1), (7, 1), (8, 2), (12, 3)])
    def test_a_quarter_is_kept_and_at_least_one(self, count: int, kept: int) -> None:
        held, share, asked = hold_out(runs(count), None, list(range(1, count + 1)))
        assert (len(held), share, asked) == (kept, 1.0, False)

    def test_the_richest_run_is_fitted(self) -> None:
        # The mean, 3.7, is next to 11 in ratio, but that is the richest of the three.
        assert hold_out(runs(3), None, [0.03, 0.07, 11.0])[0] == (1,)

    def test_a_slope_of_one_run_is_fitted(self) -> None:
        gaps = [10.0, 11.0, 1.0, 30.0]
        assert hold_out(runs(4), None, gaps)[0] == (1,)
        assert hold_out(runs(4, [0.0, 5.0, 0.0, 0.0]), None, gaps)[0] == (0,)

    def test_runs_without_a_gap(self) -> None:
        assert hold_out(runs(4), None, [0.0] * 4)[0] == (0,)
