"""A raw nominal model fitted to a rig: friction, mass and gain become nominal values."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import parameters_of
from locosweep.diagnosis.estimate.least_squares import (
    Model,
    chi2_of,
    evaluate,
    fit_all,
    point_of,
    start_fits,
)
from locosweep.validation.planting import WAYS, Rig
from locosweep.validation.rig_problem import rms_of, see, weighed

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run
    from locosweep.validation.rig_problem import Seen

_FRICTION = ("coulomb_error", "viscous_friction")
_SIZES = ("payload_mass", "drive_gain_error")
_STARTS = {
    "coulomb_error": (-0.5, 0.0, 1.0),
    "viscous_friction": (0.0, 0.05, 0.2),
    "payload_mass": (-0.3, 0.0, 0.4),
    "drive_gain_error": (-0.2, 0.0, 0.2),
}
"""Starts in sizes of each parameter: coarse, as six of them are followed to their ends."""
_FOLLOWED = 6
_STEPS = 40
_FITS = 3
"""Fits at most. Each is made in the windows that `diagnose` cuts for the model of the one before: a
raw model that errs much gets short ones, in which friction and mass are hardly told apart. The
windows of the rigs in docs/blind-check.md are the same after the second fit (`locosweep blind-check
--rig RUNS --nominal NOMINAL.toml --calibrate --draw-only`)."""
_APART = 0.95
"""Share of the error with one of mass and gain that both together have to come below, to be told
apart. On runs that do not, one of them is as good as the other."""


def calibrate(runs: Sequence[Run], robot: Robot) -> tuple[Robot, dict[str, float]]:
    """Fit Coulomb level, viscous friction, mass and gain to runs, and make them nominal.

    Of mass and gain only one where the runs do not tell both apart. Runs are seen as `diagnose`
    sees them, in windows or whole; all take part. The uncertainties of the file are dropped.

    Parameters
    ----------
    runs : sequence of Run
        The measured runs.
    robot : Robot
        The raw nominal model.

    Returns
    -------
    robot : Robot
        The calibrated model.
    found : dict of str to float
        Its values by their keys, and ``rms_x`` before and after, in the unit of x, over what
        the last fit saw.
    """
    exact = {k: v for k, v in robot.other.items() if not k.startswith("uncertainty.")}
    raw = Rig(replace(robot, other=exact), tuple(runs))
    seen = see(raw)
    rig = _fitted(raw, seen)
    for _ in range(_FITS - 1):
        again = see(rig)
        if again.plan == seen.plan:
            break
        rig, seen = _fitted(rig, again), again
    keys = ("mass", "gain", "viscous", "coulomb_force", "mu_coulomb", "gravity_torque")
    found = {key: rig.nominal[key] for key in keys if key in rig.nominal}
    for name, model in (("rms_x_before", raw), ("rms_x_after", rig)):
        found[name] = see(model, like=seen).plain_errors["x"]
    return rig.robot, found


def _fitted(rig: Rig, seen: Seen) -> Rig:
    """Return a rig whose model has the values that fit its runs, as they are seen, best."""
    before = seen.plain_errors
    one = min((_best(seen, (*_FRICTION, name), before) for name in _SIZES), key=lambda f: f[1])
    both = _best(seen, (*_FRICTION, *_SIZES), before)
    fit, _ = both if both[1] < _APART * one[1] else one
    for name, given in fit.named().items():
        if name in _SIZES[1:]:
            gain = rig.nominal["gain"] * (1.0 + given["e"])
            parameters = {**rig.robot.parameters, "gain": gain}
            rig = Rig(replace(rig.robot, parameters=parameters), rig.runs)
        else:
            # Nothing is planted into the log, which a limit of the drive would forbid.
            rig = WAYS[name][0](rig, {key: -value for key, value in given.items()})
    return rig


def _best(seen: Seen, names: tuple[str, ...], units: Mapping[str, float]) -> tuple[Fit, float]:
    """Return the best joint fit of some effects, and its error over that of the raw model."""
    free = tuple(f for name in names for f in parameters_of(name, seen.scale, names))
    model = Model(names, free)
    rows = np.array([
        [np.clip(start * f.size, f.low, f.high) for start, f in zip(row, free, strict=True)]
        for row in product(*(_STARTS[name] for name in names))
    ])  # fmt: skip
    errors = dict(units)
    fits = start_fits(seen.nuisances, model, rows)
    # Once in units of the raw model's errors, and once more in those of what is left.
    for _ in range(2):
        own = weighed(seen, errors).problem
        tried = sorted(evaluate(own, fits, residuals=False), key=chi2_of)[:_FOLLOWED]
        ends = fit_all(own, [fit.unfitted() for fit in tried], steps=_STEPS)
        fit = min(ends, key=chi2_of)
        (errors,) = rms_of(own, [point_of(own, fit)])
        fits = [end.unfitted() for end in ends]
    return fit, float(np.sqrt(np.mean([(e / units[c]) ** 2 for c, e in errors.items()])))
