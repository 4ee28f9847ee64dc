"""A diagnosis with a known cause, for tests of what is shown: its runs are replayed,
its report is written by hand to fit them."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

import locosweep as ls
from locosweep.diagnosis import Diagnosis, Trace
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

NOMINAL = """# our robot, as built
[robot]
segments = 4
mass = 0.271   # kg, weighed

[surface]
mu_coulomb = 0.15

[drive]
gain = 1.0

[sensor]
position_noise = 5e-6
force_noise = 0.01
"""

EFFECTS = {"lubricant_buildup": {"k_b": 0.6}}
NOISE = {"x": 5e-6, "v": 1e-3, "force": 0.01, "x_rear": 5e-6}
CHANNELS = ("x", "force")
HOSTILE = ("<script>alert(1)</script>", "$x_{", 'a" onload="x', "\u202eevil\u0007 & <b>日本")
"""Names of runs that are code to a browser, to a formula, or turn text round."""


def drives(count: int, seconds: float = 3.0, step: float = 0.005):
    """Pulse trains of a gait, each run with another strength and period."""
    t = np.arange(0.0, seconds, step)
    for i in range(count):
        period, strength = 0.7 + 0.1 * i, 0.62 + 0.05 * i
        yield t, np.where((t % period > 0.05) & (t % period < 0.5 * period), strength, 0.0)


def regimes(v):
    """Kinds of motion, coarsely: a sample after rest breaks away."""
    kind = np.where(v > 1e-9, 2, np.where(v < -1e-9, 3, 0))
    begins = np.flatnonzero((kind[1:] != 0) & (kind[:-1] == 0)) + 1
    kind[begins] = 1
    return kind


def made(
    folder: Path, *, labels=("0", "1", "2", "3"), effects=None, channels=CHANNELS
) -> Diagnosis:
    """Return a diagnosis of runs that were replayed with `effects`."""
    effects = EFFECTS if effects is None else effects
    file = folder / "nominal_of_case.toml"
    file.write_text(NOMINAL, encoding="utf-8")
    nominal = ls.load_robot(file)
    augmented = Robot(dict(nominal.parameters), dict(nominal.other), dict(effects))
    runs = [Run(label, t, drive, {"x": np.zeros(t.size)})
            for label, (t, drive) in zip(labels, drives(len(labels)), strict=True)]  # fmt: skip
    random = np.random.default_rng(7)
    replays = [_fields(replay_runs(robot, runs), runs) for robot in (nominal, augmented)]
    traces = []
    for i, run in enumerate(runs):
        plain, true = replays[0][i], replays[1][i]
        measured = {c: true[c] + NOISE[c] * random.standard_normal(run.t.size) for c in channels}
        traces.append(Trace(run.label, run.t, run.drive, 0.0, measured, plain, true,
                            regimes(true["v"]), held_out=i == len(runs) - 1))  # fmt: skip
    details = {"noise": NOISE, "nominal_text": NOMINAL, "force_view": _views(traces)}
    return Diagnosis(_report(traces, effects, channels), tuple(traces), nominal, augmented, details)


def _fields(frame, runs):
    ends = np.cumsum([run.t.size for run in runs])[:-1]
    split = {c: np.split(frame[c].to_numpy(), ends) for c in ("x", "v", "x_rear", "force")}
    return [{c: split[c][i] for c in split} for i in range(len(runs))]


def _rms(values) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def _views(traces):
    found = {}
    for name, pick in (("v", lambda t: t.nominal["v"]), ("x", lambda t: t.measured["x"]),
                       ("t", lambda t: t.t), ("drive", lambda t: t.drive),
                       ("distance", lambda t: np.abs(t.measured["x"]))):  # fmt: skip
        values = np.concatenate([pick(trace) for trace in traces])
        centres = np.linspace(values.min(), values.max(), 9)
        found[name] = (centres, -0.02 * np.arange(9.0), np.full(9, 0.01))
    return found


def _law(name):
    at = [0.0, 0.01, 0.02]
    curve = {"at": at, "at_unit": "m", "value": at, "std": at, "by_formula": at, "unit": "N"}
    return {"effect": name, "variable": "distance swept", "parity": "odd", "share": None,
            "formula": "(1.00 ± 0.02) N/m of s", "curve": curve}  # fmt: skip


def _report(traces, effects, channels):
    before = {t.label: _rms(t.measured["x"] - t.nominal["x"]) for t in traces}
    after = {t.label: _rms(t.measured["x"] - t.augmented["x"]) for t in traces}
    kept = [t.label for t in traces if t.held_out]
    used = [t.label for t in traces if not t.held_out]
    b, a = before[kept[0]], after[kept[0]]
    names = list(effects)
    shrink = 1.0 - a / b
    units = {e.name: {p.name: p.unit for p in e.parameters} for e in ls.effects()}
    parameters = {n: {k: {"value": v, "std": 0.01 * abs(v), "unit": units[n][k]}
                      for k, v in table.items()} for n, table in effects.items()}  # fmt: skip
    windows = [{"run": used[0], "t0": 0.9, "t1": 1.8, "share": 0.4},
               {"run": kept[0], "t0": 1.9, "t1": 2.9, "share": 0.31}]  # fmt: skip
    status = "explained" if names else "none"
    rivals = [{"effects": [name], "probability": 0.01, "gap_after": 0.5 * b, "shrink": 0.5,
               "parameters": {}} for name in ("viscous_friction", "drive_lag")]  # fmt: skip
    return {
        "schema": "locosweep.diagnosis/2",
        "verdict": {
            "status": status,
            "effects": names,
            "probability": 0.97,
            "equivalent": [[name] for name in names],
            "alternatives": [],
            "law_mismatch": False,
            "contributions": [{"effects": [name], "share": shrink, "share_ci": [shrink - 0.01, 1.0],
                               "alone": shrink, "agrees_between_runs": None} for name in names],
            "remaining": {"share": a / b if names else 1.0, "rmse": a if names else b,
                          "noise_floors": (a if names else b) / 5.2e-6, "shape": []},
            "unlisted": None,
            "laws": [_law(name) for name in names[:1]],
            "summary": f"In run {kept[0]} the head stops short of where the model puts it.",
        },
        "gap": {
            "channel": "x",
            "unit": "m",
            "metric": "rmse, free-running simulation, held-out runs",
            "before": b,
            "after": a if names else b,
            "noise_floor": 5.2e-6,
            "shrink": shrink if names else 0.0,
            "shrink_ci": [shrink - 0.01, min(shrink + 0.001, 1.0)] if names else None,
            "explained": 1.0 if names else None,
            "horizons": [{"seconds": h, "before": b * h / 3.0 + 5e-6, "after": 5.4e-6}
                         for h in (0.1, 0.5, 2.0)],
            "held_out": kept,
            "used_for_fit": used,
        },
        "where": {
            "channels": [{"channel": c, "share": 1.0 if c == "x" else 0.0, "before": b, "after": a,
                          "unit": "m" if c == "x" else "N"} for c in channels],
            "runs": [{"run": r, "before": before[r], "after": after[r]} for r in before],
            "windows": windows,
            "origin": [{"run": used[0], "t0": 0.8, "t1": 1.1, "share": 0.5}],
            "regimes": [{"regime": "sliding_forward", "share": 0.9},
                        {"regime": "at_rest", "share": 0.1}],
            "site": "friction" if names else None,
        },
        "candidates": [{"effects": names, "probability": 0.97, "gap_after": a, "shrink": shrink,
                        "parameters": parameters}, *rivals],
        "not_visible": [{"effect": "direction_dependent_friction",
                         "why": "the head never moves backward in these runs"}],
        "next_experiment": {"separates": [], "suggestion": None},
        "readings": [],
        "warnings": ["no two runs have the same drive: the noise floor is the sensor's"],
        "provenance": {"locosweep": "0.1.0", "runs_sha256": hashlib.sha256(b"runs").hexdigest(),
                       "nominal_sha256": hashlib.sha256(NOMINAL.encode()).hexdigest(), "seed": 0},
    }  # fmt: skip
