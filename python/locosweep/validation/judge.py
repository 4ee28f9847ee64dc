"""A verdict compared with its truth."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

from locosweep.simulation.replay import effect as record_of
from locosweep.simulation.replay import effects

NAMING = ("explained", "ambiguous", "partial")
"""Statuses of verdicts that name effects."""
OF_READINGS = ("reading_freezes", "reading_slips")
"""Disturbances of the readings alone: found before any fit, they leave no gap to explain."""
LOOKS = {
    **dict.fromkeys(("tether", "magnet", "wall", "cable_reel", "sagging_rail"), "place"),
    **dict.fromkeys(("periodic_push", "coloured_push", "gusts", "rocking", "mains_hum"), "time"),
}
"""Variables of the forces that some disturbances are."""
SURE_TWIN = 2.0
"""Standard deviations below which a rival is certainly indistinguishable from the truth."""

CONTAINS = {
    record.name: {wider.name for wider in effects() if record.name in wider.contains}
    for record in effects()
}
"""Wider effects that have the key as a limit: not rivals of it."""


@dataclass(frozen=True)
class Judged:
    """The outcome of one case.

    Attributes
    ----------
    case, kind, family : str
        Folder, kind of case, and what is true of it in a word (an effect's name,
        two joined by a plus, a disturbance, or none).
    mode : str
        Directions of the drive: forward, both or mixed.
    d, d_name : float
        Sizes of the gap and of its part that no other cause explains, in standard deviations.
    mismatch : bool
        The true effect has another functional form than the listed one.
    alone : bool
        The data leave the true effects as the only explanation.
    twin : bool
        A rival is indistinguishable.
    said : str
        The verdict in a word, in the same form as `family`.
    status : str
        Of the verdict; ``error`` where there was none.
    probability : float
        Stated by the verdict.
    right, one_right : bool
        The class of the verdict holds the truth, or at least one of its effects; outside the list
        the verdict names no cause, or one that copies the disturbance.
    as_reading : bool
        A fault of the readings was found as such, and no cause is named.
    looks_right : bool or None
        A cause outside the list is said to look like a force by its own variable; None of causes
        that are no force by one (`LOOKS`), and where a cause is named.
    exact : bool
        The verdict names the true effects, each alone in its class.
    named, single_name : bool
        The verdict names effects, or one effect alone in its class.
    site_right, window_share : bool or None, float or None
        Site of the first effect; share of the gap in the reported windows, relative to
        the best windows of the same length.
    parameters : tuple of float
        Relative errors of the true effect's parameters.
    claimed, interval, fresh : float or None
        Error reduction that the report claims, its interval, and that on fresh runs.
    stated, stated_interval : float or None
        Share of the gap that a `partial` verdict gives to its one cause, and its interval.
    seconds : float
        Processor time of the diagnosis.
    error : str
        Reason for a missing report.
    next_resolves, next_possible : bool or None
        The proposed run, or any run of the menu, separates the true effect from its
        rivals; None where that was not tried.
    times : float
        Size of the gap over that of the background; NaN without one.
    reached : (float, float) or None
        Error reductions that the true effect itself makes over a background, on the measured
        runs and on the fresh ones.
    """

    case: str
    kind: str
    family: str
    mode: str = "both"
    d: float = 0.0
    d_name: float = 0.0
    mismatch: bool = False
    alone: bool = True
    twin: bool = False
    said: str = "none"
    status: str = "none"
    probability: float = 0.0
    right: bool = False
    one_right: bool = False
    exact: bool = False
    named: bool = False
    single_name: bool = False
    site_right: bool | None = None
    window_share: float | None = None
    parameters: tuple[float, ...] = ()
    claimed: float | None = None
    interval: tuple[float, float] | None = None
    fresh: float | None = None
    stated: float | None = None
    stated_interval: tuple[float, float] | None = None
    seconds: float = float("nan")
    error: str = ""
    channels: tuple[str, ...] = ("x",)
    next_resolves: bool | None = None
    next_possible: bool | None = None
    times: float = float("nan")
    reached: tuple[float, float] | None = None
    as_reading: bool = False
    looks_right: bool | None = None

    @property
    def detected(self) -> bool:
        """True if the report tells of a gap, or of the bad readings that make it."""
        return self.status != "none" or self.as_reading


def _covers(classes: list[list[str]], names: list[str]) -> bool:
    """Return whether each name lies in a class of its own."""
    return len(classes) == len(names) and any(
        all(name in members for name, members in zip(order, classes, strict=True))
        for order in itertools.permutations(names)
    )


def _right(truth: dict[str, Any], verdict: dict[str, Any]) -> bool:
    names = [effect["name"] for effect in truth["effects"]]
    said, classes = verdict["effects"], verdict["equivalent"]
    status = verdict["status"]
    if truth["kind"] == "background":
        # Nobody is asked for the background: the first cause has to be the effect.
        first = {*said[:1], *(classes[0] if classes else ())}
        return bool(status in NAMING and first & set(truth["effects"][0]["accepted"]))
    if truth["kind"] == "none":
        return bool(status == "none")
    if status not in NAMING:
        return bool(truth["kind"] == "outside" and status == "unexplained")
    if truth["kind"] == "outside" and _one_of_a_class(truth["outside"]["name"], verdict):
        return True
    accepted = [sorted(a) for a in truth["accepted"]]
    if sorted(said) in accepted:
        return True
    return bool(names) and _covers(classes, names)


def _one_of_a_class(outside: str, verdict: dict[str, Any]) -> bool:
    """Return whether a verdict says that it cannot tell friction along the way from this force.

    Runs that never come back the same way show no difference between them.
    """
    variable = (verdict.get("unlisted") or {}).get("variable")
    return variable == LOOKS.get(outside) == "place" and all(
        record_of(name).variable == "place" for alike in verdict["equivalent"] for name in alike
    )


def _one_right(truth: dict[str, Any], verdict: dict[str, Any]) -> bool:
    found = set(verdict["effects"]).union(*map(set, verdict["equivalent"]))
    return any({e["name"], *e["accepted"]} & found for e in truth["effects"])


def _twin(truth: dict[str, Any], said: list[str]) -> bool:
    """Return whether a rival of the named effect, else of the true one, copies its gap."""
    if truth["kind"] != "one":
        return False
    effect = truth["effects"][0]
    name = said[0] if len(said) == 1 else effect["name"]
    wider = CONTAINS.get(name, set()) if truth["plan"]["mode"] != "forward" else set()
    return any(
        left is not None and left < SURE_TWIN and rival != name and rival not in wider
        for rival, left in effect["distances"].items()
    )


def _errors(truth: dict[str, Any], report: dict[str, Any]) -> tuple[float, ...]:
    """Relative errors of parameters, where the named effects are true in name and form."""
    names = sorted(e["name"] for e in truth["effects"])
    if not names or any(e["form"] not in ("law", "force") for e in truth["effects"]):
        return ()
    rows = [c for c in report["candidates"] if sorted(c["effects"]) == names]
    if not rows or sorted(report["verdict"]["effects"]) != names:
        return ()
    errors = []
    for effect in truth["effects"]:
        found = rows[0]["parameters"].get(effect["name"], {})
        known = effect["parameters"]
        # Of an effect's parameters data determine those that are judged.
        for name in (fit.name for fit in record_of(effect["name"]).fits if fit.judged):
            value = found.get(name, {}).get("value")
            if value is not None and known.get(name):
                errors.append(abs(value - known[name]) / abs(known[name]))
    return tuple(errors)


def window_share(truth: dict[str, Any], report: dict[str, Any]) -> float | None:
    """Share of the gap in the reported windows, relative to the best ones of their length."""
    cells = truth.get("gap_cells")
    windows = report["where"]["windows"]
    if not cells or not windows:
        return None
    # Cells are (run, start, end, squared gap); a window counts the part that it covers.
    held = covered = 0.0
    for run, start, end, square in cells:
        part = 0.0
        for window in windows:
            if window["run"] == run:
                part += max(0.0, min(end, window["t1"]) - max(start, window["t0"]))
        part = min(part, end - start)
        held += square * part / (end - start)
        covered += part
    best = time = 0.0
    for _, start, end, square in sorted(cells, key=lambda cell: -cell[3] / (cell[2] - cell[1])):
        part = min(end - start, max(0.0, covered - time))
        best += square * part / (end - start)
        time += part
    return held / best if best > 0.0 else None


def _reached(truth: dict[str, Any], channel: str) -> tuple[float, float] | None:
    """Return what the true effect takes away of a channel's error, measured runs before fresh."""
    found = truth.get("reached")
    if not found or channel not in found["runs"]:
        return None
    return float(found["runs"][channel]), float(found["check"][channel])


def _looks_right(outside: str | None, verdict: dict[str, Any]) -> bool | None:
    """Return whether a cause outside the list looks like what it is."""
    if outside not in LOOKS or verdict["status"] != "unexplained":
        return None
    like = verdict.get("unlisted")
    return bool(like and like["variable"] == LOOKS[outside])


def judge(
    truth: dict[str, Any],
    report: dict[str, Any] | None,
    *,
    fresh: float | None = None,
    seconds: float = float("nan"),
    error: str = "",
) -> Judged:
    """Judge one report; `None` with an `error` where the diagnosis gave none."""
    names = [effect["name"] for effect in truth["effects"]]
    outside = truth.get("outside", {}).get("name")
    common: dict[str, Any] = {
        "case": truth["case"],
        "kind": truth["kind"],
        "family": outside or "+".join(names) or "none",
        "mode": truth["plan"]["mode"],
        "d": float(truth["d"]),
        "d_name": float(
            min([e["d_name"] for e in truth["effects"]], default=truth.get("d_name", 0.0))
        ),
        "mismatch": bool(truth.get("mismatch")),
        "alone": len(truth["accepted"]) == 1 and bool(names),
        "twin": _twin(truth, report["verdict"]["effects"] if report else []),
        "seconds": seconds,
        "channels": tuple(truth["channels"]),
        "times": float(truth["d"]) / truth["background"]["d"]
        if "background" in truth
        else float("nan"),
    }
    if report is None:
        return Judged(**common, said="error", status="error", error=error or "no report")
    verdict = report["verdict"]
    status, said = verdict["status"], verdict["effects"]
    named = status in NAMING
    site = None
    if names and named:
        sites = {record_of(name).site for e in truth["effects"] for name in e["accepted"]}
        site = report["where"]["site"] in sites
    interval = report["gap"]["shrink_ci"]
    causes = verdict["contributions"] if status == "partial" else []
    one = causes[0] if len(causes) == 1 else {"share": None, "share_ci": None}
    as_reading = outside in OF_READINGS and bool(report.get("readings")) and not named
    return Judged(
        **common,
        said="+".join(said) if named else status,
        status=status,
        probability=float(verdict["probability"] or 0.0),
        right=_right(truth, verdict) or as_reading,
        as_reading=as_reading,
        looks_right=_looks_right(outside, verdict),
        one_right=named and _one_right(truth, verdict),
        exact=sorted(said) == sorted(names) and all(len(c) == 1 for c in verdict["equivalent"]),
        named=named,
        single_name=named and len(said) == 1 and len(verdict["equivalent"][0]) == 1,
        site_right=site,
        window_share=window_share(truth, report) if truth["kind"] != "none" else None,
        parameters=_errors(truth, report),
        claimed=report["gap"]["shrink"] if named else None,
        interval=tuple(interval) if named and interval and None not in interval else None,
        fresh=fresh,
        reached=_reached(truth, report["gap"]["channel"] or "x"),
        stated=one["share"],
        stated_interval=tuple(one["share_ci"]) if one["share_ci"] else None,
        error=error,
    )
