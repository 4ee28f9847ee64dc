"""The proposed next experiment carried out in the reality.

Every run of the menu is simulated beside the runs of the case. It separates the true effect
from the others of its class where each of these, refitted, leaves at least `ALIKE`
deviations of what all runs together show, beside what the true effect's own law leaves. It
is carried out once, however often the report asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.design.menu import FORCE_NOISE, MENU
from locosweep.files.runs import Run
from locosweep.simulation.replay import effects
from locosweep.validation.cases import absent_of, draw_case, scale_of_runs
from locosweep.validation.experiment import COARSE, Drive, Experiment, Readings, World
from locosweep.validation.laws import CAUSES
from locosweep.validation.sizes import ALIKE, Nuisances, rival_distances

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.design.menu import Change
    from locosweep.validation.cases import Case
    from locosweep.validation.experiment import Effect


@dataclass(frozen=True)
class NextRun:
    """Outcome of the run that a report proposes; empty `proposed` where no run would do.

    It `resolves` a class if it separates the true effect from every other one of it; that is
    `possible` if any run of the menu does.
    """

    case: str
    proposed: str
    resolves: bool
    possible: bool


@dataclass(frozen=True)
class _Longer(Experiment):
    """Runs and one more, which changes one thing."""

    change: Change

    def read(self, worlds: Sequence[World], step: float, threads: int) -> list[list[Readings]]:
        """Run all drives in all worlds, the last one with its changes."""
        change = self.change
        mass = change.mass * self.rig.nominal["mass"]
        rig = replace(self.rig, nominal={**self.rig.nominal, "mass": mass})
        extra = Experiment(rig, self.drives[-1:], self.sensors)
        last = list(worlds)
        if change.turned:
            last = [replace(w, effects=tuple(map(_turned, w.effects))) for w in worlds]
        if change.mass != 1.0 and "mu_coulomb" in self.rig.nominal:
            more = (change.mass - 1.0) * self.rig.level
            last = [replace(w, effects=tuple(_loaded(e, more) for e in w.effects)) for w in last]
        before = Experiment(self.rig, self.drives[:-1], self.sensors).read(worlds, step, threads)
        after = extra.read(last, step, threads)
        if change.added:
            for runs in before:
                for run in runs:
                    run[change.added] = np.zeros_like(run["x"])
        return [[*a, *b] for a, b in zip(before, after, strict=True)]


def _turned(effect: Effect) -> Effect:
    """Return an effect as it is on a robot that was turned round."""
    name, form, values = effect
    if name != "slope_error":
        return effect
    return name, form, {k: -v if k == "d_alpha_deg" else v for k, v in values.items()}


def _loaded(effect: Effect, more: float) -> Effect:
    """Return an effect as it is where a payload makes the Coulomb level higher.

    Levels of friction are given at the known mass: what they add to it stays.
    """
    name, form, values = effect
    levels = {level for record in effects() if record.name == name for level in record.levels}
    return name, form, {k: v + more if k in levels else v for k, v in values.items()}


def _longer(case: Case, change: Change) -> _Longer | None:
    """Return the runs of a case with one more of the menu; None where it has no meaning."""
    experiment = case.experiment
    rig, sensors = experiment.rig, experiment.sensors
    if (rig.rotary and change.on_slope) or change.added in sensors.channels:
        return None
    read = experiment.read([case.world], COARSE, 1)[0]
    far = int(np.argmax([np.ptp(run["x"]) for run in read]))
    drive = experiment.drives[far]
    pattern = Run("next", drive.t, drive.command, {"x": read[far]["x"]}, drive.slope_deg)
    run = change.of(pattern, rig.nominal["slope_deg"])
    slope = drive.slope_deg if run.slope_deg is None else run.slope_deg
    new = Drive(run.since_start, run.drive, slope, (drive.start[0], 0.0), drive.seed, True)
    if change.added:
        largest = float(np.abs(drive.command).max()) * rig.nominal["gain"]
        sensors = replace(
            sensors, channels=(*sensors.channels, change.added), force_noise=FORCE_NOISE * largest
        )
    return _Longer(rig, (*experiment.drives, new), sensors, change)


def _nearest(case: Case, change: Change, rivals: Sequence[str]) -> float:
    """Distance of the nearest rival over the runs so far and one more, in deviations.

    Where the true effect follows another law than its name's, that name leaves something
    as well: what rivals leave more counts.
    """
    longer = _longer(case, change)
    if longer is None:
        return 0.0
    shifts = case.world.shifts
    nuisances = Nuisances(longer, scale_of_runs(case.experiment, shifts), World(shifts), 1)
    gap = nuisances.differences([case.world.effects])[0]
    true, form, _ = case.world.effects[0]
    another_law = form not in ("law", "force")
    asked = {*rivals, true} if another_law else {*rivals}
    absent = {*absent_of(case.experiment.rig), *CAUSES} - asked
    found = rival_distances(nuisances, gap, absent=sorted(absent))
    own = found[true] if another_law else 0.0
    nearest = min((found[rival] for rival in rivals if rival in found), default=0.0)
    return float(np.sqrt(max(nearest**2 - own**2, 0.0)))


def carried_out(name: str, seed: int, index: int, report: dict[str, Any]) -> NextRun | None:
    """Carry out the proposed run for an ambiguous verdict on one effect.

    Where it does not resolve the class, the rest of the menu is carried out until a run does.
    None without a class to separate, or where it lacks the true effect.
    """
    verdict, planned = report["verdict"], report["next_experiment"]
    if verdict["status"] != "ambiguous" or len(verdict["equivalent"]) != 1:
        return None
    case = draw_case(seed, index)
    true = [effect for effect, _, _ in case.world.effects]
    members = verdict["equivalent"][0]
    if len(true) != 1 or true[0] not in members or len(members) < 2:
        return None
    rivals = [member for member in members if member != true[0]]
    proposed = planned["menu"][0]["run"] if planned.get("possible") else ""
    runs = sorted(MENU, key=lambda run: run.name != proposed)
    resolving = (run.name for run in runs if _nearest(case, run, rivals) >= ALIKE)
    first = next(resolving, None)
    return NextRun(name, proposed, first is not None and first == proposed, first is not None)
