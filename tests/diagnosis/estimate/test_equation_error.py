"""Displacements along a measured motion, against replays and by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for
from locosweep import InputError, _core
from locosweep.diagnosis.data.regimes import MeasuredMotion
from locosweep.diagnosis.estimate.equation_error import EquationError, equation_error, slides_of
from locosweep.diagnosis.estimate.least_squares import start_fits

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Search


def motion(v: list[float]) -> MeasuredMotion:
    speed = np.array(v)
    return MeasuredMotion(np.cumsum(speed), speed, 0.01)


def test_slides_end_where_the_head_rests_or_turns() -> None:
    v = [0.0] * 3 + [1.0] * 6 + [-1.0] * 5 + [0.0] * 2 + [1.0] * 4
    assert slides_of(motion(v), len(v), 4) == [(3, 9), (9, 14), (16, 20)]
    assert slides_of(motion(v), 14, 5) == [(3, 9), (9, 14)]
    assert slides_of(motion([0.0] * 9), 9, 1) == []


EFFECTS = {
    "viscous_friction": {"c": 0.05},
    "quadratic_drag": {"c2": 0.4},
    "coulomb_error": {"d_mu": 0.03},
    "drive_lag": {"T": 0.02},
    "drive_delay": {"T": 0.013},
    "drive_saturation": {"F_max": 0.95},
    "payload_mass": {"dm": 0.05},
    "back_emf": {"k_e": 0.06},
    "position_dependent_friction": {"a": 0.2, "L": 0.05, "p": 0.4},
    "transmission_compliance": {"k": 40.0, "d": 0.3, "m_d": 0.05},
    "transmission_backlash": {"b": 2e-3, "m_d": 0.05},
    "sensor_scale": {"e": 0.02},
    "sensor_delay": {"T": 0.01},
}


def fit_at(search: Search, name: str, values: dict[str, float]) -> Fit:
    model = search.model((name,))
    row = np.array([[values[free.name] for free in model.free]])
    (fit,) = start_fits(search.nuisances, model, row)
    return fit


@pytest.mark.parametrize("name", EFFECTS)
def test_a_true_model_leaves_noise_and_another_one_more(name: str) -> None:
    """What samples of 10 ms do not resolve of a sine adds some noise of the sensor's size."""
    search = search_for({name: EFFECTS[name]}, name)
    along = search.along
    assert along is not None
    true = fit_at(search, name, EFFECTS[name])
    left, gap = along.measured - along.displacements([true, search.none])
    assert gap @ gap > 15.0 * (left @ left)
    # The reading of a late sensor is taken to first order in its delay.
    assert left @ left < (100.0 if name == "sensor_delay" else 7.0) * left.size


def test_lines_in_time_are_taken_out() -> None:
    search = search_for({})
    along = search.along
    assert along is not None
    drift = fit_at(search, "sensor_drift", {"b": 1.0})
    a, b = along.displacements([search.none, drift])
    np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(a).max())


def test_runs_that_are_kept_from_fits_have_no_slides() -> None:
    search = search_for({})
    kept = EquationError(replace(search.problem, held=(1,)))
    assert kept.slides[1] == []
    assert kept.slides[0] == search.along.slides[0]  # type: ignore[union-attr]
    assert equation_error(replace(search.problem, held=(0, 1, 2))) is None


def test_blocks_that_are_not_those_of_the_slides_are_refused() -> None:
    problem = search_for({}).problem
    zero = np.zeros(problem.lengths[0])
    for slides, block, blocks in (([], 2, 0), ([(0, 6)], 2, 2), ([(0, 6)], 0, 3), ([(4, 4)], 1, 0)):
        motions = [(zero, zero, zero, slides if r == 0 else []) for r in range(len(problem.runs))]
        with pytest.raises(InputError, match="allowed"):
            _core.EquationError(problem.experiment, motions, block, *[np.zeros(blocks)] * 3)


def test_threads_do_not_change_bits() -> None:
    search = search_for({"viscous_friction": {"c": 0.05}}, "viscous_friction")
    fit = fit_of(search, "viscous_friction")
    one = EquationError(replace(search.problem, threads=1)).displacements([fit] * 40)
    two = EquationError(replace(search.problem, threads=2)).displacements([fit] * 40)
    np.testing.assert_array_equal(one, two)
