"""Semi-real cases: measured runs, a model calibrated on them, and one known thing withheld."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.effects.catalogue import candidates, families
from locosweep.errors import DataFileError
from locosweep.validation.planting import IMPOSSIBLE, WAYS, NotPlantable, Rig, plant, true_values
from locosweep.validation.rig_problem import (
    errors_of,
    refits,
    replayed,
    rms_of,
    see,
    weighed,
    with_effect,
)
from locosweep.validation.sizes import RISES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from locosweep.diagnosis.effects.catalogue import Family
    from locosweep.validation.rig_problem import Seen

_LEAST, _FACTOR = 1e-6, 2.0
"""Weakest magnitude that is tried, and the steps from there: a magnitude of 1 is about as strong
as the rig allows."""
_HALVINGS = 14
_CLOSE = 0.02
"""Relative error of a size that is close enough."""
_FAR = 1.25
"""Ratio to the wanted size up to which a case whose error jumps is still taken."""
_LEFT, _LEFT_SHARE = 1.25, 0.2
"""Error that the new model with the effect may leave, in what the calibrated model leaves and in
the size: what leaves more is no case of this effect."""
_CONTROLS = 6
"""Controls, at most."""


@dataclass(frozen=True, eq=False)
class Source:
    """A rig that cases are made from, and what its calibrated model leaves."""

    rig: Rig

    @cached_property
    def seen(self) -> Seen:
        """The log as fits see it."""
        return see(self.rig)

    @property
    def rest(self) -> dict[str, float]:
        """Error of the calibrated model, by channel."""
        return self.seen.plain_errors

    def error(self, rig: Rig) -> float:
        """Error in x of a planted log's model, in that of the calibrated one."""
        return see(rig, self.seen).plain_errors["x"] / self.rest["x"]


@dataclass(frozen=True, eq=False)
class Case:
    """A planted log and what is true of it."""

    rig: Rig
    truth: dict[str, Any]


def names_of(rig: Rig) -> list[str]:
    """List the effects that a case may have; all that have a meaning on the rig."""
    return candidates(rig.robot, {c for run in rig.runs for c in run.channels})[0]


def draw(source: Source, name: str, size: float, seed: list[int]) -> Case:
    """Plant one effect so strongly that the error in x is `size` times what it was.

    Raises
    ------
    NotPlantable
        With the reason, where the effect or the size cannot be reached.
    """
    if name not in WAYS:
        raise NotPlantable(IMPOSSIBLE[name])
    family = families(source.rig.scale)[name]
    rng = np.random.default_rng(seed)
    shapes = _shapes(family, rng)
    signs = list(family.signs) if rng.random() < 0.5 else list(family.signs)[::-1]
    reasons = []
    for way in range(len(WAYS[name])):
        for sign in signs:
            try:
                u, error = _strength(source, family, shapes, sign, size, way)
                asked = family.make(u, shapes)
                planted = plant(source.rig, name, asked, way)
                values = true_values(source.rig, name, asked)
                left = _left(source, planted, name, values, size)
            except NotPlantable as reason:
                reasons.append(str(reason))
                continue
            truth = {
                "effect": name, "size": size, "reached": error, "left": left, "way": way,
                "parameters": values, **same_answers(source, planted, name, values),
            }  # fmt: skip
            return Case(planted, truth)
    raise NotPlantable("; ".join(dict.fromkeys(reasons)))


def _shapes(family: Family, rng: np.random.Generator) -> dict[str, float]:
    """Draw the further parameters: one of the first values of fits, a third more or less."""
    found = {}
    for shape in family.shapes:
        start = float(rng.choice(shape.starts))
        if shape.log:
            found[shape.name] = float(
                np.clip(start * 1.35 ** rng.uniform(-1.0, 1.0), shape.low, shape.high)
            )
        else:
            # A phase is anywhere between its first values.
            span = float(np.ptp(shape.starts))
            found[shape.name] = start + span * rng.uniform(-0.2, 0.2)
    return found


def _strength(
    source: Source, family: Family, shapes: Mapping[str, float], sign: float, size: float, way: int
) -> tuple[float, float]:
    """Find the magnitude at which the error has a size, and the error there."""
    reason = ""

    def error(u: float) -> float:
        nonlocal reason
        try:
            return source.error(plant(source.rig, family.name, family.make(u, shapes), way))
        except (NotPlantable, DataFileError) as why:
            reason = str(why)
            return np.inf

    most = family.high if sign > 0.0 else -family.low
    low, high = 0.0, _LEAST
    weaker, at = 1.0, error(sign * high)
    while at < size and high < most:
        low, weaker, high = high, at, min(high * _FACTOR, most)
        at = error(sign * high)
    for _ in range(_HALVINGS if at > size else 0):
        if abs(at / size - 1.0) < _CLOSE:
            break
        middle = 0.5 * (low + high)
        found = error(sign * middle)
        if found < size:
            low, weaker = middle, found
        else:
            high, at = middle, found
    if at == np.inf:
        raise NotPlantable(f"{reason} (error {weaker:.3g} times)")
    if at > _FAR * size:
        raise NotPlantable(f"the error jumps from {weaker:.3g} to {at:.3g} times")
    if at < size / _FAR:
        raise NotPlantable(f"as strong as it may be, the effect is too weak (error {at:.3g} times)")
    return sign * high, at


def _left(
    source: Source, planted: Rig, name: str, values: Mapping[str, float], size: float
) -> float:
    """Error of the new model with the effect, in what the calibrated one leaves: 1 if all is well.

    A window begins in a measured state, which says nothing of a reading that is later than the
    window's lead.
    """
    problem = see(planted, source.seen).problem
    (errors,) = rms_of(problem, [with_effect(problem, name, values)])
    left = errors["x"] / source.rest["x"]
    if left > max(_LEFT, _LEFT_SHARE * size):
        raise NotPlantable(f"even with the effect the new model leaves {left:.3g} times")
    return left


def same_answers(
    source: Source, planted: Rig, name: str, values: Mapping[str, float]
) -> dict[str, Any]:
    """Say which effects are the same answer, measured on the gap alone, without what is left.

    The new model with the effect is replayed on the new log, in the same windows, and each other
    effect is refitted to that alone. What it leaves, added in squares to what the calibrated
    model leaves, has to raise the error of each channel by less than a tenth.
    """
    seen = weighed(see(planted, source.seen), source.rest)
    pure = replayed(seen, name, values)
    left = errors_of(pure, refits(pure))
    ratios = {
        other: max(float(np.hypot(1.0, e / source.rest[c])) for c, e in own.items())
        for other, own in left.items()
        if other
    }
    accepted = {name} | {other for other, ratio in ratios.items() if ratio < RISES}
    order = sorted(ratios, key=ratios.__getitem__)
    return {"accepted": sorted(accepted), "rises": {other: ratios[other] for other in order}}


def controls(source: Source) -> list[Case]:
    """Return logs with nothing planted: all runs, and different ones of them."""
    runs = source.rig.runs
    parts = [runs, runs[::2], runs[1::2], runs[1:], runs[:-1], runs[: (len(runs) + 1) // 2]]
    chosen = {tuple(run.label for run in part): part for part in parts if part}
    return [
        Case(Rig(source.rig.robot, part), {"effect": None, "size": 0.0, "accepted": []})
        for part in list(chosen.values())[:_CONTROLS]
    ]
