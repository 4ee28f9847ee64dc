"""What the data cannot tell from a set of effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis_search import fit_of, search_for, search_of
from diagnosis_small import measured
from locosweep.diagnosis.estimate.least_squares import evaluate, start_fits
from locosweep.diagnosis.select.equivalence import classes_of, is_limit, rivals_of
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.score import total
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.stepwise import exchanged
from locosweep.diagnosis.select.thresholds import TIE

NAMES = ("viscous_friction", "back_emf", "sensor_drift", "drive_gain_error")
BOTH = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-3}}


def test_rivals_differ_by_one_effect_best_first() -> None:
    search = search_for(BOTH, *NAMES)
    known = singles(search)
    found, known = exchanged(search, known, fit_of(search, *BOTH))
    rivals = rivals_of(search, known, found)
    # Viscous friction and back-EMF are one force: either may come first.
    two = [set(found.model.names), set(rivals[0].model.names)]
    assert sorted(map(sorted, two)) == [["back_emf", "sensor_drift"], sorted(BOTH)]
    assert all(len({*fit.model.names} & {*found.model.names}) == 1 for fit in rivals)
    assert all(known.fits[frozenset(fit.model.names)] is fit for fit in rivals)
    classes, sets = classes_of(search, known, found, rivals, mismatch=False)
    assert {frozenset(alike) for alike in classes} == {
        frozenset({"viscous_friction", "back_emf"}),
        frozenset({"sensor_drift"}),
    }
    assert sets == []


def test_a_tie_is_one_of_all_runs_however_far_off_a_prediction_is() -> None:
    """Two names of one force: one of them from values that the fitted runs hardly know."""
    search = search_of(measured({"viscous_friction": {"c": 0.06}}), *NAMES[:2], held=(2,))
    found = fit_of(search, "viscous_friction")
    far = fit_of(search, "back_emf")
    theta = far.theta + 3.3 * np.sqrt(np.diag(far.covariance))
    (far,) = evaluate(search.problem, [far.unfitted(theta)])
    assert search.score(far) - search.score(found) < TIE
    assert total(search, far) - total(search, found) > TIE
    known = Collection({frozenset(fit.model.names): fit for fit in (search.none, found, far)})
    classes, _ = classes_of(search, known, found, [far], mismatch=False)
    assert classes == [["viscous_friction", "back_emf"]]
    # What is no other name of it stays apart.
    other = fit_of(search_of(measured({}), "drive_gain_error"), "drive_gain_error")
    (other,) = evaluate(search.problem, [other.unfitted()])
    assert classes_of(search, known, found, [other], mismatch=False)[0] == [["viscous_friction"]]


def test_a_law_that_gains_nothing_is_no_rival_of_its_limit_but_of_others() -> None:
    rows = {
        "transmission_backlash": (1e-3, 0.05),
        "transmission_compliance": (400.0, 1.0, 0.05),
        "coulomb_error": (0.05,),
        "friction_drift": (0.3, 1.0),
    }
    pairs = {
        "transmission_backlash": "transmission_compliance",
        "coulomb_error": "friction_drift",
    }
    found = {}
    for name, wider in pairs.items():
        search = search_of(measured({}), name, wider)
        starts = [
            start_fits(search.nuisances, search.model((own,)), np.array([rows[own]]))[0]
            for own in (name, wider)
        ]
        # As good as the other one, and no better.
        one, rival = (replace(fit, chi2=1000.0) for fit in starts)
        known = Collection({frozenset(fit.model.names): fit for fit in (search.none, one, rival)})
        (found[name],), _ = classes_of(search, known, one, [rival], mismatch=False)
    assert found == {
        "transmission_backlash": ["transmission_backlash", "transmission_compliance"],
        "coulomb_error": ["coulomb_error"],
    }


def test_only_a_shape_has_a_limit_that_is_another_effect() -> None:
    search = search_for({}, "drive_lag", "stribeck_friction")
    found = {}
    for name in search.names:
        model = search.model((name,))
        lowest = np.array([[f.low for f in model.free]])
        (fit,) = start_fits(search.nuisances, model, lowest)
        found[name] = is_limit(fit, name)
    # The shortest lag is next to nothing; a friction that falls at no speed is Coulomb's.
    assert found == {"drive_lag": False, "stribeck_friction": True}
