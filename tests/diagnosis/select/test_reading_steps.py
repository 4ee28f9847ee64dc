"""Slips of about the noise of a reading, told by levels of a replay's error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import diagnosis_small as small
from diagnosis_search import fit_of, search_of
from locosweep.diagnosis.effects.catalogue import parameters_of
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.least_squares import Model, Nuisances, evaluate, start_fits
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select import reading_steps
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.reading_steps import stepped_readings
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

NOISE = 2e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE},
)
T = np.arange(600) * 0.005


def measured(steps: float = 0.0, every: float = 0.7, **effects: dict[str, float]) -> list[Run]:
    """Two runs that move half of the time; readings step by `steps` deviations by the clock."""
    runs = []
    for k in range(2):
        active = (T % 1.0) < 0.5
        drive = np.where(active, (1.0 + 0.2 * k) * np.sin(4.0 * np.pi * T), 0.0)
        runs.append(Run(str(k), T, drive, {"x": np.zeros(T.size)}))
    x = replay_runs(replace(ROBOT, effects=effects), runs)["x"].to_numpy().reshape(2, -1)
    x = x + np.random.default_rng(3).normal(0.0, NOISE, x.shape)
    x = x + steps * NOISE * np.floor(T / every)
    return [replace(run, channels={"x": own}) for run, own in zip(runs, x, strict=True)]


def found(runs: list[Run]) -> tuple[list[np.ndarray], list[tuple[float, float, int]]]:
    problem = Problem(ROBOT, runs, 1)
    (fit,) = evaluate(problem, start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))))
    flags, findings = stepped_readings(problem, fit, fit)
    assert all(one.kind == "slip" and one.masked and one.column == "x" for one in findings)
    return flags, [(one.t0, one.t1, one.samples) for one in findings]


def test_noise_has_none() -> None:
    flags, findings = found(measured())
    assert findings == []
    assert not np.any(flags)


def test_no_line_is_bent_where_jumps_do_worse_than_a_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """A large gap has a level for every reading: lines with as many bends took most of a
    diagnosis."""

    def bent(*_: object) -> float:
        raise AssertionError

    search = search_of(small.measured({"viscous_friction": {"c": 0.15}}), "viscous_friction")
    best = fit_of(search, "viscous_friction", values=(0.1,))
    monkeypatch.setattr(reading_steps, "_bent_line", bent)
    flags, findings = stepped_readings(search.problem, search.none, best)
    assert findings == []
    assert not np.any(flags)


def test_steps_of_a_deviation_are_found_where_they_are() -> None:
    flags, findings = found(measured(steps=1.5))
    assert len(findings) == 8
    for (t0, t1, _), at in zip(findings, [0.7, 1.4, 2.1, 2.8] * 2, strict=True):
        assert t1 - t0 == pytest.approx(0.005)
        assert t1 == pytest.approx(at, abs=0.06)
    # One level of each run stays, of 0.7 s.
    assert [int((~own).sum()) for own in flags] == pytest.approx([140, 140], abs=12)
    assert sum(samples for _, _, samples in findings) == int(np.sum(flags))


@pytest.mark.parametrize(
    "effects",
    [
        {"coulomb_error": {"d_mu": 0.02}},
        {"sensor_drift": {"b": 4e-5}},
        {"drive_delay": {"T": 0.002}},
        {"position_dependent_friction": {"a": 0.1, "L": 0.01, "p": 0.0}},
    ],
)
def test_what_a_model_lacks_is_none(effects: dict[str, dict[str, float]]) -> None:
    assert found(measured(**effects))[1] == []


def test_jumps_while_the_head_moves_are_forces() -> None:
    runs = measured()
    moving = (T % 1.0 >= 0.1) & (T % 1.0 < 0.4)
    steps = 2.0 * NOISE * np.cumsum(np.diff(moving.astype(float), prepend=0.0) > 0)
    runs = [replace(r, channels={"x": r.channels["x"] + steps}) for r in runs]
    assert found(runs)[1] == []


def test_jumps_under_a_drive_that_may_move_the_head_are_forces() -> None:
    """Steps that begin where the head rests: under almost what holds it, and under no drive."""
    holds = 0.3 * 0.25 * 9.81
    for share, count in ((0.98, 0), (0.3, 4)):
        pulse = np.where((T % 1.0) < 0.5, share * holds, 0.0)
        runs = []
        for run in measured():
            x = np.random.default_rng(int(run.label)).normal(0.0, NOISE, T.size)
            x += 4.0 * NOISE * np.searchsorted([0.3, 1.3], T, side="right")
            runs.append(replace(run, drive=pulse, channels={"x": x}))
        assert len(found(runs)[1]) == count


def test_a_single_run_is_looked_at_to_its_end() -> None:
    """Fits see its first part only: what they do not see is no level of its own."""
    (run, _) = measured(steps=3.0)
    problem = Problem(ROBOT, [run], 1, train_fraction=0.7)
    (fit,) = evaluate(problem, start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))))
    flags, findings = stepped_readings(problem, fit, fit)
    assert [one.t1 for one in findings] == pytest.approx([0.7, 1.4, 2.1, 2.8], abs=0.06)
    assert int((~flags[0]).sum()) == pytest.approx(140, abs=12)


def test_jumps_have_to_do_better_than_another_law_where_one_was_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a law that is worth more than the jumps, and of one that is worth less."""
    runs = measured(steps=1.5)
    problem = Problem(ROBOT, runs, 1)
    model = Model(
        ("viscous_friction",), tuple(parameters_of("viscous_friction", scale_of(ROBOT, runs)))
    )
    (none, fit) = evaluate(
        problem,
        [
            *start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))),
            *start_fits(Nuisances(), model, np.zeros((1, 1))),
        ],
    )
    for worth, slips in ((1e5, 0), (10.0, 8)):
        monkeypatch.setattr(
            NonparametricCorrection, "log_bayes_factor", lambda *_, worth=worth: worth
        )
        assert len(stepped_readings(problem, none, fit, other_law=True)[1]) == slips
        assert len(stepped_readings(problem, none, fit)[1]) == 8


@pytest.mark.parametrize("origin", [0.0, 2.0])
def test_a_coarse_encoder_slips_wherever_its_zero_lies(origin: float) -> None:
    step, noise = 1e-4, 3e-5
    sensor = {"sensor.position_noise": noise, "sensor.position_resolution": step}
    runs, random = [], np.random.default_rng(3)
    for run in measured():
        x = run.channels["x"] + origin + random.normal(0.0, noise, T.size)
        x = step * np.round(x / step) + 2.0 * step * np.floor(T / 0.7)
        runs.append(replace(run, channels={"x": x}))
    problem = Problem(replace(ROBOT, other=sensor), runs, 1)
    (fit,) = evaluate(problem, start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))))
    assert len(stepped_readings(problem, fit, fit)[1]) > 6


@pytest.mark.parametrize(("jump", "pushes"), [(0.5, []), (5.0, [103.0])])
def test_a_jump_below_the_noise_may_lie_where_the_head_still_moved(
    jump: float, pushes: list[float]
) -> None:
    # It moves fifteen readings before the cut: only a large jump is known not to be there.
    nominal = np.where(np.arange(200) < 85, 0.0, 1e-3)
    levels = reading_steps._Levels(np.arange(200), [0, 100, 200], [0.0, jump])
    weights, push = np.full(200, 1e5), np.arange(200.0)
    assert reading_steps._at_rest(levels, nominal, weights, push) == pushes


@pytest.mark.parametrize(("slope_deg", "count"), [(0.0, 4), (12.0, 0)])
def test_on_a_slope_a_head_at_rest_may_be_about_to_slide(slope_deg: float, count: int) -> None:
    """Friction just holds it without a drive on the steep one."""
    runs = []
    for k in range(2):
        x = np.random.default_rng(k).normal(0.0, NOISE, T.size)
        x += 4.0 * NOISE * np.searchsorted([0.8, 1.8], T, side="right")
        runs.append(Run(str(k), T, np.zeros(T.size), {"x": x}, slope_deg=slope_deg))
    assert len(found(runs)[1]) == count


def test_a_pendulum_rests_by_its_weight_as_well() -> None:
    """Beside the angle at which friction just holds it without a drive, no jump is sure."""
    bench = Robot(
        {"mass": 0.02, "gravity": 9.81},
        {
            "sensor.position_noise": NOISE,
            "surface.coulomb_force": 0.03,
            "bench.kind": "rotary",
            "bench.gravity_torque": 0.5,
        },
    )
    for angle, count in ((0.0, 4), (0.055, 0)):
        runs = []
        for k in range(2):
            x = angle + np.random.default_rng(k).normal(0.0, NOISE, T.size)
            x += 4.0 * NOISE * np.searchsorted([0.8, 1.8], T, side="right")
            runs.append(Run(str(k), T, np.zeros(T.size), {"x": x}))
        problem = Problem(bench, runs, 1)
        (fit,) = evaluate(problem, start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))))
        assert len(stepped_readings(problem, fit, fit)[1]) == count


def test_the_place_of_a_jump_is_as_uncertain_as_it_is_taken_to_be() -> None:
    random = np.random.default_rng(2)
    jump, count = 0.7, 400
    steps = jump * (np.arange(count) >= count // 2)
    middle = np.arange(1, count)
    off = []
    for _ in range(2000):
        sums = np.cumsum(random.standard_normal(count) + steps)
        apart = sums[:-1] / middle - (sums[-1] - sums[:-1]) / (count - middle)
        off.append(middle[np.argmax(apart**2 * middle * (count - middle))] - count // 2)
    within = np.mean(np.abs(off) <= reading_steps._PLACE / jump**2)
    assert within == pytest.approx(0.95, abs=0.02)
