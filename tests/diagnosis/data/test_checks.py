"""Data checks: which runs are left out, and what is said of the others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.checks import check_runs, usable
from locosweep.errors import DataFileError
from locosweep.files.robot import Robot
from locosweep.files.runs import Run

ROBOT = Robot(
    {"mass": 0.5, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": 1e-5},
)
T = np.arange(0.0, 1.0, 0.01)


def moving(label: str, rate: float, **more: object) -> Run:
    """A run that its drive could have moved as far as it says: 1 N on 0.5 kg for 1 s."""
    x = 0.05 * T**2
    return Run(label, T, np.sign(np.sin(rate * T + 0.1)), {"x": x}, **more)  # type: ignore[arg-type]


FOUR = [moving(str(k), 5.0 + k) for k in range(4)]


def said(runs: list[Run], robot: Robot = ROBOT) -> str:
    return "\n".join(check_runs(runs, robot))


def gone(run: Run, first: int, last: int) -> Run:
    """The run without some of its readings."""
    x = run.channels["x"].copy()
    x[first:last] = np.nan
    return replace(run, channels={"x": x})


class TestUsable:
    def test_runs_with_fewer_than_eight_positions_are_left_out(self) -> None:
        seven, eight = gone(FOUR[1], 7, 100), gone(FOUR[2], 8, 100)
        kept, warnings = usable([FOUR[0], seven, eight])
        assert kept == [FOUR[0], eight]
        assert warnings == ["run 1: x has 7 values, at least 8 are needed: it is left out"]

    def test_one_run_has_to_have_twenty(self) -> None:
        assert usable([gone(FOUR[0], 20, 100)])[1] == []
        with pytest.raises(DataFileError, match="fewer than 20 values in every run"):
            usable([gone(run, 19, 100) for run in FOUR])
        with pytest.raises(DataFileError):
            usable([])


class TestCheckRuns:
    def test_good_runs_need_no_word(self) -> None:
        assert check_runs(FOUR, ROBOT) == []

    @pytest.mark.parametrize(("count", "words"), [(1, "one run only"), (3, "3 runs only")])
    def test_few_runs(self, count: int, words: str) -> None:
        assert said(FOUR[:count]).startswith(words)

    def test_a_drive_that_never_changes(self) -> None:
        flat = [replace(run, drive=np.full(T.size, 1.0 + k)) for k, run in enumerate(FOUR)]
        assert "drive is constant in every run" in said(flat)
        assert said([*flat[:3], FOUR[3]]) == ""

    def test_one_drive_in_every_run(self) -> None:
        assert "every run has the same drive" in said([FOUR[0]] * 4)

    def test_a_head_that_stays_within_eight_deviations(self) -> None:
        def spans(size: float) -> list[Run]:
            return [replace(run, channels={"x": size * T / T[-1]}) for run in FOUR]

        assert "never moves beyond the noise" in said(spans(7.9e-5))
        assert "never moves" not in said(spans(8.1e-5))
        coarse = replace(ROBOT, other={"sensor.position_resolution": 1e-3})
        assert "never moves" in said(spans(7.9e-3), coarse)

    def test_a_position_beyond_what_the_drive_can_do_is_in_another_unit(self) -> None:
        # 1 N on 0.5 kg for 0.99 s: a t^2 / 2 = 0.98 m; from twice that on it is said.
        near = [replace(run, channels={"x": 1.9 * T / T[-1]}) for run in FOUR]
        far = [replace(run, channels={"x": 2.0 * T / T[-1]}) for run in FOUR]
        assert said(near) == ""
        assert "most 0.98 m: is x in another unit than m (--unit x=mm)?" in said(far)
        # Downhill a head moves without any drive.
        assert said([replace(run, slope_deg=20.0) for run in far]) == ""

    def test_power_without_a_motor(self) -> None:
        runs = [replace(r, channels={**r.channels, "power": np.ones(T.size)}) for r in FOUR]
        assert said(runs).startswith("power is measured but")
        motor = {**ROBOT.parameters, "winding_resistance": 20.0, "force_constant": 1.7}
        assert said(runs, replace(ROBOT, parameters=motor)) == ""

    def test_a_gap_of_more_than_ten_steps_in_time(self) -> None:
        late = T + np.where(T > 0.5, 0.095, 0.0)
        assert said([replace(FOUR[0], t=late), *FOUR[1:]]).startswith(
            "run 0: a gap of 0.105 s between samples"
        )
        short = T + np.where(T > 0.5, 0.085, 0.0)
        assert said([replace(FOUR[0], t=short), *FOUR[1:]]) == ""

    def test_more_than_a_fifth_of_x_missing(self) -> None:
        assert said([gone(FOUR[0], 10, 30), *FOUR[1:]]) == ""
        assert said([gone(FOUR[0], 10, 31), *FOUR[1:]]) == "run 0: 21% of x is missing"
