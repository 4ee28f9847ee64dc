# ruff: noqa: S311, T201 -- cases are random but repeatable; the worst errors are printed
"""How exact simulated trajectories are: exact propagation against 50 digits, the
order of the methods with steps, and the energy ledger of all of them.
"""

from __future__ import annotations

import math
import random
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from numpy.typing import NDArray

import dynamics_scipy as reference
import locosweep as ls
from dynamics_exact import EPS, OUTPUTS, Case, random_case
from dynamics_laws import BRISTLE, DRY, SMOOTH, Plant, random_plant
from locosweep import _core

mp.mp.dps = 50
CASES = 600
ALLOWED = 1e-12
# Where cancellation makes a problem itself ill-conditioned: an error may be this
# many times what the exact answer moves by when every input is off by up to one
# rounding (the most of three draws), or a rounding of the terms of a difference
# that every run must take.
ROUNDINGS = 20
# Anything below may as well be 0: near the smallest number there is.
NOTHING = 1e-290

DRY_ORDER = ("stribeck", "static_viscous")

Runs = list[tuple[Case, dict[str, float]]]
Row = tuple[float, float, float, int]


@pytest.fixture(scope="module")
def exact_runs() -> Runs:
    rng = random.Random(1)
    cases = [random_case(rng) for _ in range(CASES)]
    return [(case, case.found()) for case in cases]


@pytest.fixture(scope="module")
def exact_errors(exact_runs: Runs) -> dict[str, list[Row]]:
    """Per output: error over what is allowed, relative error, condition, case."""
    out: dict[str, list[Row]] = {name: [] for name in OUTPUTS}
    for i, (case, found) in enumerate(exact_runs):
        want, terms = case.expected()
        shaken = [case.expected(random.Random(3 * i + k))[0] for k in range(3)]
        for name in OUTPUTS:
            value = want[name]
            if mp.isnan(value) or math.isnan(found[name]):
                same = mp.isnan(value) and math.isnan(found[name])
                # An arrival at the very end of the run is a matter of rounding.
                close = any(mp.isnan(other[name]) != mp.isnan(value) for other in shaken)
                out[name].append((0.0 if same or close else math.inf, 0.0, 0.0, i))
                continue
            error = abs(mp.mpf(found[name]) - value)
            moves = max(abs(other[name] - value) for other in shaken)
            moves = max(moves, terms.get(name, mp.mpf(0)) * EPS)
            allowed = max(ALLOWED * abs(value), ROUNDINGS * moves, mp.mpf(NOTHING))
            size = abs(value) or mp.mpf(1)
            out[name].append(
                (float(error / allowed), float(error / size), float(moves / size / EPS), i)
            )
    return out


class TestExactPropagation:
    @pytest.mark.slow
    @pytest.mark.parametrize("name", OUTPUTS)
    def test_against_fifty_digits(
        self,
        name: str,
        exact_errors: dict[str, list[Row]],
        exact_runs: Runs,
    ) -> None:
        rows = exact_errors[name]
        ratio, _, _, i = max(rows)
        plain = max((e for _, e, condition, _ in rows if condition < 100), default=0.0)
        failed = sum(row[0] > 1 for row in rows)
        print(
            f"\n{name}: worst relative error {plain:.1e} where well-conditioned,"
            f" {ratio:.2g} of what is allowed overall; {failed} of {len(rows)} beyond"
        )
        assert ratio <= 1, exact_runs[i][0]

    @pytest.mark.parametrize("way", [1, -1])
    @pytest.mark.parametrize("decays", [1e-9, 1e-3, 0.5, 2.0, 10.0, 40.0, 300.0, 700.0])
    def test_damping_alone_never_stops(self, decays: float, way: int) -> None:
        # v = v0 e^(-b t/m) fades but is never 0.
        given = {"mass": 1.0, "mu_coulomb": 0.0, "viscous": decays, "start_speed": 0.7 * way}
        found = Case("coulomb_viscous", "constant", given).found()
        with mp.workdps(50):
            speed = mp.mpf(0.7) * way * mp.exp(-mp.mpf(decays))
            heat = (mp.mpf(0.7) ** 2 - speed**2) / 2
        assert found["stick_phases"] == 0
        assert math.isclose(found["final_speed"], speed, rel_tol=ALLOWED)
        assert math.isclose(found["dissipated"], heat, rel_tol=ALLOWED)

    @pytest.mark.parametrize("decays", [10.0**k for k in range(-6, 3)] + [2e-3, 0.03, 0.3])
    def test_heat_of_the_film(self, decays: float) -> None:
        # Little damping takes little of the work: its heat has digits of its own.
        given = {"mass": 1.0, "gravity": 1.0, "mu_coulomb": 0.0, "viscous": decays}
        case = Case("coulomb_viscous", "constant", {**given, "drive_force": 2.0})
        want = case.expected()[0]["dissipated"]
        assert math.isclose(case.found()["dissipated"], want, rel_tol=ALLOWED)

    def test_no_heat_at_rest(self) -> None:
        given = {"mass": 1.0, "gravity": 1.0, "mu_coulomb": 0.5, "viscous": 3.0}
        found = Case("coulomb_viscous", "constant", {**given, "drive_force": 0.4}).found()
        assert (found["stuck_time"], found["dissipated"]) == (1.0, 0.0)
        assert found["energy_residual"] == 0.0

    def test_cases_are_worth_it(self, exact_runs: Runs) -> None:
        counts = [found["stick_phases"] for _, found in exact_runs]
        moved = [found["peak_motion"] > 0 for _, found in exact_runs]
        arrived = [not math.isnan(found["stroke_time"]) for _, found in exact_runs]
        assert sum(count > 0 for count in counts) > CASES / 8
        assert sum(moved) > CASES / 2
        assert sum(arrived) > CASES / 8


class TestEnergy:
    """Work of the drive, heat, and what is stored: the ledger closes, and
    friction only takes.
    """

    def test_residual_of_exact_propagation(self, exact_runs: Runs) -> None:
        rows = [(abs(found["energy_residual"]), i) for i, (_, found) in enumerate(exact_runs)]
        worst, i = max(rows)
        beyond = sum(row[0] > 1e-11 for row in rows)
        print(f"\nenergy residual of exact propagation: {worst:.1e}; {beyond} beyond")
        assert worst <= 1e-11, exact_runs[i][0]

    def test_exact_friction_never_drives(self, exact_runs: Runs) -> None:
        for case, _ in exact_runs[:150]:
            given = dict(case.given)
            times = np.linspace(0.01, 1.0, 60) * given.pop("duration")
            heat = ls.sweep(
                "dissipated",
                law=case.law,
                drive=case.drive,
                table=case.table,
                duration=times,
                **given,
            ).values
            assert_rises(heat, case)

    @pytest.mark.parametrize("law", [*DRY, "directional", "modelica", *SMOOTH, "dahl"])
    def test_friction_never_drives(self, law: str) -> None:
        rng = random.Random(21)
        for _ in range(4):
            plant = random_plant(rng, law)
            given = dict(plant.given)
            times = np.linspace(0.01, 1.0, 40) * given.pop("duration")
            if plant.drive == "chirp":
                # The sweep rate depends on the duration.
                plant.drive = "sine"
                del given["drive_frequency_end"]
            options: dict[str, Any] = {"time_step": 1e-3, "tolerance": 1e-8}
            heat = ls.sweep(
                "dissipated", law=law, drive=plant.drive, duration=times, **options, **given
            ).values
            assert_rises(heat, plant, slack=1e-7 if law == "dahl" else 1e-9)

    @pytest.mark.parametrize("law", BRISTLE)
    def test_bristles_hold_what_they_do_not_lose(self, law: str) -> None:
        rng = random.Random(22)
        for _ in range(6):
            plant = random_plant(rng, law)
            for tolerance in (1e-5, 1e-7):
                residual, heat = outputs(
                    plant, "energy_residual dissipated", "rosenbrock", tolerance=tolerance
                )
                assert abs(residual) < 3 * tolerance, plant
                assert heat >= 0, plant

    @pytest.mark.parametrize(
        ("law", "method", "order"),
        [
            ("stribeck", "runge_kutta", 4),
            ("tanh", "runge_kutta", 4),
            ("lugre", "rosenbrock_fixed", 4),
        ],
    )
    def test_residual_falls_with_the_order(self, law: str, method: str, order: float) -> None:
        plants = group(law)
        steps = [0.008 / 2**k for k in range(6)]
        if law == "lugre":
            steps = [step / 4 for step in steps]
        sizes = []
        for step in steps:
            residuals = [outputs(p, "energy_residual", method, time_step=step)[0] for p in plants]
            sizes.append(math.sqrt(sum(r * r for r in residuals) / len(residuals)))
        slope = regress(steps, sizes)
        print(f"\nenergy residual of {law}: order {slope:.2f}, {sizes[0]:.1e} to {sizes[-1]:.1e}")
        assert slope > order - 0.3


def assert_rises(heat: NDArray[np.float64], case: object, slack: float = 1e-12) -> None:
    assert (heat >= -slack * np.abs(heat).max()).all(), case
    assert (np.diff(heat) >= -slack * np.abs(heat).max()).all(), case


def outputs(
    plant: Plant, names: str, method: str, *, locate: bool = True, **options: Any
) -> list[float]:
    """One point of a sweep, with or without search for events."""
    wanted = names.split()
    requests = [(name, None, None) for name in wanted]
    chosen: dict[str, Any] = {
        "law": plant.law,
        "drive": plant.drive,
        "method": method,
        "locate": locate,
    }
    given = {**plant.given, **options}
    job = _core.Sweep([], list(given.items()), requests, None, **chosen)
    arrays = [np.empty(()) for _ in wanted]
    job.run(list(enumerate(arrays)), 1, None, None, None, None, True)
    return [float(array) for array in arrays]


def group(law: str) -> list[Plant]:
    """The same segment under a sine at different phases, so that where in a step
    an event falls averages out.
    """
    given: dict[str, Any] = {
        "mass": 1.0,
        "gravity": 1.0,
        "viscous": 0.3,
        "mu_coulomb": 0.5,
        "mu_static": 0.8,
    }
    given |= {"drive_frequency": 1.0, "drive_amplitude": 1.6, "duration": 1.0}
    if law in DRY_ORDER:
        given |= {"drive_amplitude": 1.1, "drive_frequency": 1.5}
    if law == "stribeck":
        given["stribeck_speed"] = 0.15
    if law == "tanh":
        given |= {"stribeck_speed": 0.2, "transition_speed": 0.05}
    if law == "lugre":
        # Fast enough forward that it never turns: a smooth stretch.
        given |= {"stribeck_speed": 0.3, "bristle_stiffness": 200.0, "bristle_damping": 10.0}
        given |= {"start_speed": 0.9, "duration": 0.32}
    count = 6 if law == "lugre" else 24
    phases = [360.0 * (i + 0.37) / count for i in range(count)]
    return [Plant(law, "sine", {**given, "drive_phase_deg": phase}) for phase in phases]


def regress(steps: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def errors_over(
    law: str, method: str, key: str, values: list[float], *, locate: bool = True
) -> list[float]:
    """Root mean square of the errors of place and speed at each setting."""
    plants = group(law)
    if law in DRY_ORDER:
        runs = [reference.dry(plant) for plant in plants]
        assert sum(run.sticks for run in runs) >= len(runs)
    elif law == "tanh":
        runs = [reference.smooth(plant) for plant in plants]
    else:
        runs = [reference._through(plant, 1, plant.bristle, reference.TIGHT) for plant in plants]
    out = []
    for value in values:
        squares = []
        for plant, run in zip(plants, runs, strict=True):
            names = "final_position final_speed"
            x, v = outputs(plant, names, method, locate=locate, **{key: value})
            squares += [((x - run.x) / run.far) ** 2, ((v - run.v) / run.fast) ** 2]
        out.append(math.sqrt(sum(squares) / len(squares)))
    return out


class TestOrder:
    """Slopes of log error over log step, five halvings."""

    @pytest.mark.parametrize(
        ("law", "method", "locate", "order", "first"),
        [
            ("stribeck", "runge_kutta", True, 4, 0.03),
            # The jump from static to Coulomb friction, missed by up to a step.
            ("static_viscous", "runge_kutta", True, 4, 0.03),
            ("static_viscous", "runge_kutta", False, 1, 0.004),
            ("stribeck", "dormand_prince_fixed", True, 5, 0.04),
            ("static_viscous", "dormand_prince_fixed", True, 5, 0.1),
            ("static_viscous", "dormand_prince_fixed", False, 1, 0.004),
            ("tanh", "runge_kutta", True, 4, 0.016),
            ("lugre", "rosenbrock_fixed", True, 4, 0.0025),
        ],
    )
    def test_of_fixed_steps(
        self, law: str, method: str, locate: bool, order: float, first: float
    ) -> None:
        # Of small errors the reference's soon are the larger part.
        ratio = 1.5 if order == 5 or law == "lugre" else 2
        steps = [first / ratio**k for k in range(6)]
        errors = errors_over(law, method, "time_step", steps, locate=locate)
        slope = regress(steps, errors)
        print(
            f"\n{law}, {method}, locate={locate}: order {slope:.3f}", [f"{e:.1e}" for e in errors]
        )
        # Long stiff steps are better than their order.
        assert order - 0.15 < slope < order + (0.4 if method == "rosenbrock_fixed" else 0.15)

    @pytest.mark.parametrize(
        ("law", "method"),
        [
            ("lugre", "rosenbrock"),
            ("stribeck", "dormand_prince"),
            ("static_viscous", "dormand_prince"),
        ],
    )
    def test_of_adaptive_steps(self, law: str, method: str) -> None:
        tolerances = [10.0**-k for k in range(4, 10)]
        errors = errors_over(law, method, "tolerance", tolerances)
        slope = regress(tolerances, errors)
        print(f"\n{law}, {method}: error over tolerance {slope:.3f}", [f"{e:.1e}" for e in errors])
        assert slope == pytest.approx(1.0, abs=0.15)
        assert all(e < 3 * tolerance for e, tolerance in zip(errors, tolerances, strict=True))
