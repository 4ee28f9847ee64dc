"""Another law of a cause, known from the other runs, and what only looks like one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from diagnosis_search import fit_of, fits_of, search_of
from diagnosis_small import tethered, uneven
from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    evaluate,
    fit_all,
    start_fits,
)
from locosweep.diagnosis.select import law_mismatch
from locosweep.diagnosis.select.force_law import force_law
from locosweep.diagnosis.select.law_mismatch import (
    best_with_other_law,
    formula_share,
    is_law_of,
    law_through,
    score_with_other_law,
    several_do_better,
    variables_of,
)
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.search import Collection, Search
from locosweep.diagnosis.select.thresholds import OTHER_LAW_SHARE
from locosweep.files.runs import Run
from test_diagnosis import ROBOT, drives, measured


def test_another_law_has_to_hold_in_the_runs_kept_from_the_fit() -> None:
    """The same law in all runs, and one run with a push of its own."""
    runs = drives(count=5)
    law = {"quadratic_drag": {"c2": 0.05}}
    frame = measured(law, runs)
    other = replace(runs[2], drive=runs[2].drive + 0.06 * np.sin(5.0 * runs[2].t))
    pushed = [*runs[:2], other, *runs[3:]]
    strange = measured(law, pushed).with_columns(
        drive=pl.Series(np.concatenate([r.drive for r in runs]))
    )
    found = []
    for one in (frame, strange):
        search, (fit,) = fits_of(ROBOT, one, "viscous_friction", held=(2,))
        found.append(score_with_other_law(search, fit) is not None)
    assert found == [True, False]


def test_what_the_other_runs_cannot_tell_is_no_contradiction() -> None:
    """The run that is kept is faster than any other: what its law is there, they do not know."""
    runs = drives(count=4)
    runs.append(replace(runs[0], label="fast", drive=1.3 * runs[0].drive))
    frame = measured({"quadratic_drag": {"c2": 0.02}}, runs)
    search, (fit,) = fits_of(ROBOT, frame, "viscous_friction", held=(4,))
    assert score_with_other_law(search, fit) is not None


def test_a_run_kept_from_the_fit_may_start_in_motion() -> None:
    runs = drives(count=5)
    whole = measured({"quadratic_drag": {"c2": 0.02}}, runs)
    frame = whole.filter((pl.col("run") != runs[4].label) | (pl.col("t") > 0.55))
    search, (fit,) = fits_of(ROBOT, frame, "viscous_friction", held=(4,))
    found = []
    for starting in ((), (4,)):
        starts = replace(search.problem.starts, moving=starting)
        moved = replace(search, problem=replace(search.problem, initial=starts))
        found.append(score_with_other_law(moved, fit) is not None)
    assert found == [False, True]


def test_a_law_far_off_by_its_own_formula_is_found_behind_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives())
    others = ("sensor_drift", "sensor_delay", "drive_lag", "drive_delay", "friction_drift")
    search, level = fits_of(
        ROBOT, frame, *others, "supply_sag", "position_dependent_friction", "viscous_friction"
    )
    found = best_with_other_law(search, level)
    assert found is not None
    assert found.fit.model.names == ("viscous_friction",)


def late(runs: list[Run], *, loaded: bool) -> pl.DataFrame:
    """Runs in which a load is picked up after 1.2 s, or friction rises then, told without it."""
    nominal = measured({}, runs, "v")
    real = []
    for run in runs:
        v = nominal.filter(pl.col("run") == run.label)["v"].to_numpy()
        less = 3e-4 * (run.drive - 0.05 * v) if loaded else 6e-4 * np.sign(v)
        real.append(replace(run, drive=run.drive - less * (run.t > 1.2)))
    told = pl.Series(np.concatenate([run.drive for run in runs]))
    return measured({}, real).with_columns(drive=told)


@pytest.mark.parametrize(
    ("name", "loaded", "may"),
    [
        ("friction_drift", True, False),
        ("supply_sag", True, False),
        # A load would be slower to turn round, too.
        ("friction_drift", False, True),
    ],
)
def test_what_changes_at_once_is_no_drift_where_it_may_be_a_load(
    name: str, loaded: bool, may: bool
) -> None:
    search, (fit,) = fits_of(ROBOT, late(drives(count=5), loaded=loaded), name)
    law = force_law(search.problem, search.none, VARIABLES[name])
    assert law is not None
    assert law.found is not None
    assert law.found.may_jump
    assert law_mismatch._goes_as_it_may(search, fit) == may


def test_no_effect_is_tried_twice_for_another_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits are refitted when they are tried, and the list of those to try next is bounded."""
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives())
    behind = ("sensor_drift", "sensor_delay", "drive_lag", "friction_drift", "supply_sag")
    search, level = fits_of(
        ROBOT, frame, "viscous_friction", *behind, "sensor_scale", "quadratic_drag"
    )
    tried = []

    def score(_: Search, fit: Fit) -> tuple[tuple[bool, bool, float] | None, list[str]]:
        tried.append(fit.model.names)
        return None, ["speed"]

    monkeypatch.setattr(law_mismatch, "_score_with_other_law", score)
    assert best_with_other_law(search, level) is None
    assert len(tried) == len(set(tried))
    assert ("quadratic_drag",) in tried


def test_another_law_starts_from_where_a_formula_ends() -> None:
    """A search leaves fits that fall behind, far from their ends."""
    search, (end,) = fits_of(
        ROBOT, measured({"quadratic_drag": {"c2": 0.05}}, drives()), "viscous_friction"
    )
    (left,) = evaluate(search.problem, [end.unfitted(end.theta * 0.2)])
    assert left.chi2 > 2.0 * end.chi2
    found = best_with_other_law(search, [left])
    assert found is not None
    assert found.fit.chi2 == pytest.approx(end.chi2, rel=1e-3)


@pytest.mark.parametrize("held", [(), (3,)])
def test_several_causes_do_better_than_a_law_where_they_are_the_truth(
    held: tuple[int, ...],
) -> None:
    """Drag that grows with the square of the speed, and drag beside a drift."""
    pair = ("viscous_friction", "sensor_drift")
    both = {"viscous_friction": {"c": 0.1}, "sensor_drift": {"b": 4e-4}}
    found = []
    for effects in (both, {"quadratic_drag": {"c2": 0.05}}):
        search, (alone,) = fits_of(ROBOT, measured(effects, drives(count=5)), pair[0], held=held)
        model = search.model(pair)
        start = start_fits(search.nuisances, model, np.zeros((1, len(model.free))))
        found.append(several_do_better(search, alone, fit_all(search.problem, start, steps=20)))
    assert found == [True, False]


@pytest.mark.parametrize(("by_speed", "is_law"), [(130.0, True), (110.0, False)])
def test_a_formula_far_from_its_law_stands_where_no_other_variable_comes_near(
    by_speed: float, is_law: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction that bends by the speed, of which its formula takes next to nothing."""
    search, (fit,) = fits_of(
        ROBOT, measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5)), "viscous_friction"
    )

    def factor(_: object, variables: list[str], __: float) -> float:
        return by_speed if variables == ["speed"] else 100.0

    monkeypatch.setattr(law_mismatch, "formula_share", lambda *_: 0.1)
    monkeypatch.setattr(law_mismatch, "noise_level", lambda *_: 1.0)
    monkeypatch.setattr(NonparametricCorrection, "log_bayes_factor", factor)
    assert is_law_of(search, fit) == is_law


@pytest.mark.parametrize(
    ("name", "carrying", "is_law"),
    [
        ("supply_sag", ("sag", "time"), True),
        ("supply_sag", ("sag", "place"), False),
        # An encoder with play errs by place, too, and is no scale.
        ("sensor_scale", ("reading",), False),
    ],
)
def test_which_laws_stand_without_their_formula(
    name: str, carrying: tuple[str, ...], is_law: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Variables that carry 130 of chi2; the others carry 100."""
    search, (fit,) = fits_of(
        ROBOT, measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5)), name
    )

    def factor(_: object, variables: list[str], __: float) -> float:
        return 130.0 if variables[0] in carrying else 100.0

    monkeypatch.setattr(law_mismatch, "formula_share", lambda *_: 0.1)
    monkeypatch.setattr(law_mismatch, "noise_level", lambda *_: 1.0)
    monkeypatch.setattr(NonparametricCorrection, "log_bayes_factor", factor)
    assert is_law_of(search, fit) == is_law


def test_friction_and_a_drive_over_the_time_of_a_run_are_one_variable() -> None:
    alike = ["supply_sag", "friction_drift", "viscous_friction", "coulomb_error"]
    assert variables_of(alike[:2]) == {"time"}
    assert variables_of(alike) == {"time", "speed", "coulomb_error"}


def test_the_formula_of_a_cause_takes_most_of_its_gap_and_an_alien_one_little() -> None:
    """Drag by the square of the speed is near viscous friction; a drift of readings is not."""
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5))
    search, fits = fits_of(ROBOT, frame, "viscous_friction", "sensor_drift", held=(4,))
    near, far = (formula_share(search, fit) for fit in fits)
    assert near > 0.5
    assert far < OTHER_LAW_SHARE
    assert formula_share(search, search.none) == 0.0


def test_a_gap_below_the_doubt_about_the_noise_is_shared_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Noise taken for a tenth larger than it is would hide the whole gap."""
    monkeypatch.setattr(law_mismatch, "noise_level", lambda *_: 1.1)
    frame = measured({"quadratic_drag": {"c2": 0.0018}}, drives(count=5))
    search, fits = fits_of(ROBOT, frame, "viscous_friction", "sensor_drift")
    assert search.none.chi2 < 1.1 * np.count_nonzero(search.none.residual)
    near, far = (formula_share(search, fit) for fit in fits)
    assert near > 0.5
    assert far < OTHER_LAW_SHARE


def stepped(shares: np.ndarray, *, finer: int = 400) -> pl.DataFrame:
    """Readings of a drive in steps whose changes act late, each by its own share of a sample."""
    runs = [replace(run, drive=0.9 * np.sign(run.drive)) for run in drives(count=5)]
    inner, fine = np.arange(finer) / finer, []
    for run in runs:
        t = np.linspace(0.0, float(run.t[-1]), (run.t.size - 1) * finer + 1)
        before, after = np.roll(run.drive, 1), np.roll(run.drive, -1)
        changes = np.cumsum(run.drive != before) - 1
        own = np.where(run.drive != before, shares[changes % shares.size], 0.0)
        next_ = np.where(after != run.drive, shares[(changes + 1) % shares.size], 0.0)
        late = inner < own[:, None]
        early = inner >= 1.0 + np.minimum(next_, 0.0)[:, None]
        drive = np.where(late, before[:, None], np.where(early, after[:, None], run.drive[:, None]))
        fine.append(
            replace(run, t=t, drive=drive.ravel()[: t.size], channels={"x": np.zeros(t.size)})
        )
    frame = measured({}, fine)
    coarse = frame.filter(np.concatenate([np.arange(run.t.size) % finer == 0 for run in fine]))
    return coarse.with_columns(drive=pl.Series(np.concatenate([run.drive for run in runs])))


def test_changes_that_are_late_by_turns_are_another_law_of_a_delay() -> None:
    """What is late at random is no delay by its formula; what is early at times is none at all."""
    shares = np.random.default_rng(3).uniform(0.0, 0.05, 97)
    found = []
    for one in (shares, shares - 0.02):
        search, (fit,) = fits_of(ROBOT, stepped(one), "drive_delay")
        found.append(
            (search.is_noise(fit), score_with_other_law(search, fit), is_law_of(search, fit))
        )
    (white, score, is_law), (early_white, early_score, early) = found
    assert (white, early_white) == (False, False)
    assert score is not None
    assert early_score is not None
    assert (is_law, early) == (True, False)


def test_a_kept_run_without_a_gap_says_nothing_of_a_formula() -> None:
    runs = drives(count=5)
    runs[4] = replace(runs[4], drive=0.2 * runs[4].drive)
    frame = measured({"quadratic_drag": {"c2": 0.05}}, runs)
    search, (fit,) = fits_of(ROBOT, frame, "viscous_friction", held=(4,))
    assert formula_share(search, fit) > OTHER_LAW_SHARE


@pytest.mark.parametrize(("own", "stands"), [(0.99e3, True), (0.95e3, True), (0.85e3, False)])
def test_a_law_may_be_behind_by_what_knots_make_out(
    own: float, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 1000 for every other variable."""
    search, (fit,) = fits_of(
        ROBOT, measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5)), "viscous_friction"
    )

    def factor(_: NonparametricCorrection, variables: list[str], __: float) -> float:
        return own if variables == ["speed"] else 1e3

    monkeypatch.setattr(NonparametricCorrection, "log_bayes_factor", factor)
    monkeypatch.setattr(NonparametricCorrection, "log_bayes_factor_by_run", lambda *_: 0.0)
    assert (score_with_other_law(search, fit) is not None) == stands


def test_a_law_that_is_behind_comes_after_those_that_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5))
    search, level = fits_of(ROBOT, frame, "viscous_friction", "drive_lag")
    scored = {"viscous_friction": (False, True, 1.0), "drive_lag": (False, False, 2.0)}

    def score(_: Search, fit: Fit) -> tuple[tuple[bool, bool, float] | None, list[str]]:
        return scored.get("".join(fit.model.names)), []

    monkeypatch.setattr(law_mismatch, "_score_with_other_law", score)
    for least, name in ((2.0, "drive_lag"), (1.0, "viscous_friction")):
        found = best_with_other_law(search, level)
        assert found is not None
        assert (found.score, found.fit.model.names) == (least, (name,))
        del scored[name]


@pytest.mark.parametrize(("ahead", "name"), [(5.0, "viscous_friction"), (15.0, "drive_lag")])
def test_of_laws_that_tie_the_one_with_the_better_formula_is_meant(
    ahead: float, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5))
    search, level = fits_of(ROBOT, frame, "viscous_friction", "drive_lag")
    scored = {"viscous_friction": (False, False, ahead), "drive_lag": (False, False, 0.0)}

    def score(_: Search, fit: Fit) -> tuple[tuple[bool, bool, float] | None, list[str]]:
        return scored.get("".join(fit.model.names)), []

    monkeypatch.setattr(law_mismatch, "_score_with_other_law", score)
    monkeypatch.setattr(law_mismatch, "_is_hopeless", lambda *_: False)
    assert formula_share(search, level[0]) > formula_share(search, level[1])
    found = best_with_other_law(search, level)
    assert found is not None
    assert found.fit.model.names == (name,)


def test_a_force_by_place_is_a_slope_only_where_it_stays_near_its_mean() -> None:
    for runs, named in ((uneven(), ("slope_error",)), (tethered(), None)):
        search = search_of(runs, "slope_error", "viscous_friction")
        known = Collection({
            frozenset({name}): fit_of(search, name) for name in ("viscous_friction", "slope_error")
        })  # fmt: skip
        found = law_through(search, known, "terrain")
        assert (found.model.names if found else None) == named
        assert law_through(search, known, "acceleration") is None
