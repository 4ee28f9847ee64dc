"""What is true of a drawn case: sizes of its effects, and which others the runs cannot tell."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.validation.experiment import COARSE, World
from locosweep.validation.sizes import ALIKE, RISES, Nuisances, rival_distances

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.validation.cases import Case

    Floats = NDArray[np.float64]


def _verdict(own: float, distances: dict[str, float], name: str) -> dict[str, Any]:
    """Return the class of causes that the runs cannot tell from the true one.

    A rival belongs to it if it leaves no more than noise, or, for an effect of another
    functional form, no more than the listed form of its own name leaves.
    """
    bar = max(ALIKE, own)
    accepted = [name, *sorted(r for r, left in distances.items() if left < bar and r != name)]
    others = [left for r, left in distances.items() if r not in accepted]
    return {"accepted": accepted, "next_rival": min(others, default=float("inf"))}


def single(case: Case, nuisances: Nuisances, gap: Floats, absent: list[str]) -> Case:
    """Find size and rivals of the one effect of a case."""
    (name, form, parameters) = case.world.effects[0]
    d = nuisances.size(case.world.effects)
    distances = rival_distances(nuisances, gap, own=case.world.effects[0], absent=absent, most=d)
    law = form in ("law", "force")
    found = _verdict(0.0 if law else distances[name], distances, name)
    entry = {
        "name": name,
        "form": form,
        "parameters": parameters,
        "d": d,
        "d_name": min(d, found["next_rival"]),
        "accepted": found["accepted"],
        "distances": distances,
    }
    truth = {
        **case.truth,
        "status": "explained" if len(found["accepted"]) == 1 else "ambiguous",
        "effects": [entry],
        "mismatch": not law,
        "accepted": [[rival] for rival in found["accepted"]],
        "d": d,
    }
    return replace(case, truth=truth)


def pair(case: Case, nominal: Nuisances, absent: list[str]) -> Case:
    """Find size and rivals of each of two effects, the other one refitted."""
    effects, entries = case.world.effects, []
    whole = nominal.differences([effects])[0]
    singles = rival_distances(nominal, whole, absent=absent)
    accepted = [[rival] for rival, left in sorted(singles.items()) if left < ALIKE]
    for i, (name, form, parameters) in enumerate(effects):
        other = effects[1 - i]
        world = World(case.world.shifts, (other,))
        around = Nuisances(case.experiment, nominal.scale, world, nominal.threads)
        gap = around.differences([(effects[i],)])[0]
        world = World(case.world.shifts, ((other[0], other[1], _nudged(other[2])),))
        moved = case.experiment.read([world], COARSE, nominal.threads)[0]
        sensitivity = around.left(case.experiment.whitened(moved) - around.base)
        beside = [sensitivity] if np.linalg.norm(sensitivity) > 0.0 else []
        alone = gap - sum((b * (b @ gap) / (b @ b) for b in beside), 0.0)
        d = min(float(np.linalg.norm(alone)), around.size((effects[i],)))
        distances = rival_distances(
            around, gap, own=effects[i], beside=beside, absent=[*absent, other[0]], most=d
        )
        found = _verdict(0.0, distances, name)
        entries.append({
            "name": name, "form": form, "parameters": parameters, "d": d,
            "d_name": min(d, found["next_rival"]), "accepted": found["accepted"],
            "distances": distances,
        })  # fmt: skip
    classes = [entry["accepted"] for entry in entries]
    (first, *_), (second, *_) = effects
    accepted += [[a, b] for a, b in product(*classes) if a == first or b == second]
    plain = all(len(c) == 1 for c in classes) and not any(len(a) == 1 for a in accepted)
    truth = {
        **case.truth,
        "status": "explained" if plain else "ambiguous",
        "effects": entries,
        "mismatch": False,
        "accepted": accepted,
        "d": nominal.size(effects),
    }
    return replace(case, truth=truth)


def _nudged(parameters: dict[str, float]) -> dict[str, float]:
    """Move the first parameter, the one that carries most laws' strength, a little."""
    first = next(iter(parameters))
    return {**parameters, first: parameters[first] * 1.01}


def outside(case: Case, nuisances: Nuisances, gap: Floats, absent: list[str], d: float) -> Case:
    """Find what comes near a disturbance, of size `d`, that no effect of the list stands for."""
    ((name, _, parameters),) = case.world.effects
    distances = rival_distances(nuisances, gap, absent=absent, most=d)
    accepted = [[rival] for rival, left in sorted(distances.items()) if left < ALIKE]
    truth = {
        **case.truth,
        "status": "unexplained",
        "outside": {"name": name, "parameters": parameters, "d": d, "distances": distances},
        "accepted": accepted,
        "mismatch": False,
        "d": d,
        "d_name": min(d, *distances.values()),
    }
    return replace(case, truth=truth)


def over_background(
    case: Case, around: Nuisances, gap: Floats, absent: list[str], background: float
) -> Case:
    """Find size and rivals of an effect over a background that nobody is asked to name.

    `background` is the size of that. A rival is the same answer where what it leaves of the
    effect's gap, added in squares to the background, is less than a tenth more than that.
    """
    (name, form, parameters), *unlisted = case.world.effects
    d = float(np.linalg.norm(gap))
    distances = rival_distances(around, gap, own=case.world.effects[0], absent=absent, most=d)
    bar = max(ALIKE, background * float(np.sqrt(RISES**2 - 1.0)))
    accepted = [name, *sorted(r for r, left in distances.items() if left < bar and r != name)]
    others = [left for r, left in distances.items() if r not in accepted]
    d_name = min([d, *others])
    entry = {
        "name": name, "form": form, "parameters": parameters, "d": d, "d_name": d_name,
        "accepted": accepted, "distances": distances,
    }  # fmt: skip
    truth = {
        **case.truth,
        "status": "partial",
        "effects": [entry],
        "background": {"name": unlisted[0][0], "parameters": unlisted[0][2], "d": background},
        "mismatch": False,
        "accepted": [[rival] for rival in accepted],
        "d": d,
    }
    return replace(case, truth=truth)
