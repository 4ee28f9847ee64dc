"""Stratum of the blind check with bad readings: a drawn case, and one fault put into its columns.

A diagnosis may say that it finds nothing, or the true cause; what it must not do is to explain the
fault by a cause that is not there.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from locosweep.validation.case_files import runs_file, write_case
from locosweep.validation.cases import KINDS_OF_CASE, Case, draw_case
from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.random import Generator
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

FAULTS = ("spikes", "zeros", "holds", "frozen", "slip", "unit", "sign", "swapped", "noise")
"""Faults in turn: case `i` has fault `i` modulo their number."""
_KINDS = ("none", "one")
"""Kinds of cases that faults are put into: what is true of the others is harder to say."""
_ACCEPTED = {
    "spikes": {"spike", "dropout"},
    "zeros": {"dropout", "spike"},
    "holds": {"dropout", "frozen", "spike"},
    "frozen": {"frozen", "slip", "dropout"},
    "slip": {"slip"},
    "unit": {"unit"},
    "sign": {"sign"},
    "swapped": {"swapped", "unit", "sign"},
}
"""Kinds of findings that name a fault."""
_SURE = 0.5
"""Probability from which a false cause counts as confident."""


@dataclass(frozen=True)
class Spoilt:
    """Runs with one fault, and where it is."""

    frame: pl.DataFrame
    fault: str
    form: str
    """Which of the fault's forms: a unit, a column, a factor."""
    places: list[tuple[str, float, float]]
    """Run, first and last time of each stretch of bad readings."""
    samples: int


@dataclass(frozen=True)
class BadJudged:
    """What a diagnosis made of bad readings."""

    case: str
    fault: str
    form: str
    truth: str
    """The true effect, or none."""
    found: bool
    """A finding names the fault, in the right column, run and time."""
    kinds: tuple[str, ...]
    """Kinds of all findings."""
    status: str
    said: str
    probability: float
    right: bool
    """The verdict is that of the case without its fault."""
    false_cause: bool
    """A cause is named with confidence, and its class does not hold the true one."""
    seconds: float
    error: str = ""


def kind_of(seed: int, index: int) -> str:
    """Return the kind of a case of the blind check without drawing the rest of it."""
    rng = np.random.default_rng([seed, 0, index])
    return str(rng.choice(list(KINDS_OF_CASE), p=list(KINDS_OF_CASE.values())))


def draw_base(seed: int, index: int) -> Case:
    """Draw the case that fault `index` of a seed is put into."""
    chosen = [i for i in range(4 * index + 40) if kind_of(seed, i) in _KINDS]
    return draw_case(seed, chosen[index])


def spoil(
    frame: pl.DataFrame, fault: str, rng: Generator, *, deviation: float, rotary: bool
) -> Spoilt:
    """Put one fault into measured runs.

    Parameters
    ----------
    frame : polars.DataFrame
        Runs in the contract's long form.
    fault : str
        One of `FAULTS`.
    rng : numpy.random.Generator
        Draws its form, size and places.
    deviation : float
        Deviation of a reading of x.
    rotary : bool
        x is an angle.
    """
    if fault in ("unit", "sign", "swapped", "noise"):
        return _whole(frame, fault, rng, deviation, rotary=rotary)
    parts = frame.partition_by("run", maintain_order=True)
    travel = float(np.median([np.ptp(part["x"].to_numpy()) for part in parts]))
    size = travel * log_uniform(rng, 0.05, 2.0)
    share = log_uniform(rng, 2e-3, 2e-2) if fault == "spikes" else rng.uniform(0.01, 0.05)
    # Every run drops readings; it is one encoder that freezes or slips, now and then.
    hit = rng.random(len(parts)) < (0.5 if fault in ("frozen", "slip") else 1.0)
    hit[int(rng.integers(len(parts)))] = True
    spoilt, places, samples = [], [], 0
    for part, struck in zip(parts, hit.tolist(), strict=True):
        x = part["x"].to_numpy()
        new = _ONE_RUN[fault](x, rng, size, share) if struck else x
        bad = np.abs(new - x) > deviation
        samples += int(bad.sum())
        places += _places(part, bad)
        spoilt.append(part.with_columns(pl.Series("x", new)))
    form = f"{size / travel:.2g} of the travel" if fault in ("spikes", "slip") else f"{share:.1%}"
    return Spoilt(pl.concat(spoilt), fault, form, places, samples)


def _spikes(x: Floats, rng: Generator, size: float, share: float) -> Floats:
    at = rng.random(x.size) < share
    jumps = rng.choice([-1.0, 1.0], x.size) * size * rng.uniform(0.3, 1.0, x.size)
    found: Floats = x + at * jumps
    return found


def _zeros(x: Floats, rng: Generator, size: float, share: float) -> Floats:
    del size
    return np.where(rng.random(x.size) < share, 0.0, x)


def _holds(x: Floats, rng: Generator, size: float, share: float) -> Floats:
    del size
    held = rng.random(x.size) < share
    held[0] = False
    last = np.maximum.accumulate(np.where(held, 0, np.arange(x.size)))
    return x[last]


def _frozen(x: Floats, rng: Generator, size: float, share: float) -> Floats:
    del size, share
    first = int(rng.uniform(0.15, 0.7) * x.size)
    last = first + max(8, int(rng.uniform(0.03, 0.25) * x.size))
    new = x.copy()
    new[first:last] = x[first - 1]
    return new


def _slip(x: Floats, rng: Generator, size: float, share: float) -> Floats:
    del share
    new = x.copy()
    new[int(rng.uniform(0.15, 0.85) * x.size) :] += rng.choice([-1.0, 1.0]) * size
    return new


_ONE_RUN: dict[str, Callable[[Floats, Generator, float, float], Floats]] = {
    "spikes": _spikes, "zeros": _zeros, "holds": _holds, "frozen": _frozen, "slip": _slip,
}  # fmt: skip


def _places(part: pl.DataFrame, bad: NDArray[np.bool_]) -> list[tuple[str, float, float]]:
    """Return run, first and last time of each stretch of bad readings."""
    at = np.flatnonzero(bad)
    if at.size == 0:
        return []
    t, label = part["t"].to_numpy(), str(part["run"][0])
    cuts = np.flatnonzero(np.diff(at) > 1)
    firsts, lasts = np.append(at[0], at[cuts + 1]), np.append(at[cuts], at[-1])
    return [(label, float(t[a]), float(t[b])) for a, b in zip(firsts, lasts, strict=True)]


def _whole(
    frame: pl.DataFrame, fault: str, rng: Generator, deviation: float, *, rotary: bool
) -> Spoilt:
    """Put a fault into the whole of a column."""
    column, form = "x", ""
    if fault == "unit":
        units = {"mm": 1e3, "inch": 1.0 / 0.0254, "percent": 1e2, "mN": 1e3}
        if rotary:
            units = {"deg": 180.0 / np.pi, "percent": 1e2, "mN": 1e3}
        form = str(rng.choice(list(units)))
        column = "drive" if form in ("percent", "mN") else "x"
        frame = frame.with_columns(pl.col(column) * units[form])
    elif fault == "sign":
        form = str(rng.choice(["x", "drive"]))
        frame = frame.with_columns(-pl.col(form))
    elif fault == "swapped":
        frame = frame.rename({"x": "drive", "drive": "x"})
    else:
        factor = float(rng.uniform(10.0, 30.0))
        form = f"{factor:.0f} times"
        noise = pl.Series(rng.normal(0.0, factor * deviation, frame.height))
        frame = frame.with_columns(pl.col("x") + noise)
    ends = [(part["run"][0], part["t"][0], part["t"][-1]) for part in frame.partition_by("run")]
    places = [(str(run), float(first), float(last)) for run, first, last in ends]
    return Spoilt(frame, fault, f"{column} {form}".strip(), places, frame.height)


def write_bad(out: Path, seed: int, index: int) -> str:
    """Draw a case with one fault into a folder, its truth beside those of a blind check.

    The truth gains `fault`: its name, form, places and number of samples. Returns the case's name.
    """
    fault = FAULTS[index % len(FAULTS)]
    name = f"bad_{index:04d}"
    case = draw_base(seed, index)
    write_case(case, name, out, [seed, 2, index])
    file, sealed = runs_file(out / name), out / "sealed" / name / "truth.json"
    frame = pl.read_csv(file) if file.suffix == ".csv" else pl.read_parquet(file)
    rig, sensors = case.experiment.rig, case.experiment.sensors
    spoilt = spoil(
        frame,
        fault,
        np.random.default_rng([seed, 3, index]),
        deviation=sensors.deviation("x"),
        rotary=rig.rotary,
    )
    (spoilt.frame.write_csv if file.suffix == ".csv" else spoilt.frame.write_parquet)(file)
    truth = json.loads(sealed.read_text())
    truth["fault"] = {
        "name": fault, "form": spoilt.form, "places": spoilt.places, "samples": spoilt.samples,
    }  # fmt: skip
    sealed.write_text(json.dumps(truth, indent=1, allow_nan=False))
    return name


def judge_bad(
    truth: dict[str, Any],
    report: dict[str, Any] | None,
    *,
    seconds: float = float("nan"),
    error: str = "",
) -> BadJudged:
    """Judge the report on a case with bad readings; `None` with an `error` where there is none."""
    fault, effects = truth["fault"], truth["effects"]
    name = "+".join(effect["name"] for effect in effects) or "none"
    common: dict[str, Any] = {
        "case": truth["case"], "fault": fault["name"], "form": fault["form"], "truth": name,
        "seconds": seconds,
    }  # fmt: skip
    if report is None:
        return BadJudged(
            **common, found=False, kinds=(), status="error", said="error", probability=0.0,
            right=False, false_cause=False, error=error or "no report",
        )  # fmt: skip
    verdict = report["verdict"]
    named = verdict["status"] in ("explained", "ambiguous", "partial")
    first = set(verdict["equivalent"][0]) if named and verdict["equivalent"] else set()
    true = {effect["name"] for effect in effects}
    true |= {names[0] for names in truth["accepted"] if len(names) == 1}
    holds = bool(first & true)
    probability = float(verdict["probability"] or 0.0)
    return BadJudged(
        **common,
        found=_found(fault, report),
        kinds=tuple(sorted({row["kind"] for row in report.get("readings", [])})),
        status=verdict["status"],
        said="+".join(verdict["effects"]) or verdict["status"],
        probability=probability,
        right=holds if effects else verdict["status"] == "none",
        false_cause=named and not holds and probability > _SURE,
    )


def _found(fault: dict[str, Any], report: dict[str, Any]) -> bool:
    """Return whether a finding, or for noise a warning, names the fault where it is."""
    if fault["name"] == "noise":
        return any("readings show noise" in said for said in report["warnings"])
    column = "drive" if fault["form"].startswith("drive") and fault["name"] == "unit" else "x"
    rows = [
        row for row in report.get("readings", [])
        if row["kind"] in _ACCEPTED[fault["name"]] and row["column"] == column
    ]  # fmt: skip
    return any(
        row["run"] == run and row["t0"] <= last and row["t1"] >= first
        for row in rows
        for run, first, last in fault["places"]
    )
