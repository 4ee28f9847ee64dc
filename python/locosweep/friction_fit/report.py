"""A fit as plain data, as a short text, and as files in a folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from locosweep.files.atomic import write_text
from locosweep.files.folder import make_folder
from locosweep.files.strict_json import as_json, plain

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from locosweep.friction_fit.result import FittedLaw, FrictionFit

_ROWS = 10
"""Laws in the text table."""


def as_dict(fit: FrictionFit) -> dict[str, object]:
    """Return plain numbers and text; numbers that JSON cannot hold become None."""
    data = fit.data
    found: dict[str, object] = {
        "schema": "locosweep.friction/1",
        "verdict": {
            "status": fit.status,
            "law": fit.chosen.law,
            "equal": [law.name for law in fit.equal],
            "no_better": [law.name for law in fit.no_better],
            "summary": fit.summary,
        },
        "held_out": {
            "by": data.by,
            "runs": data.held_out,
            "rms": fit.chosen.held_out_rms,
            "shrink": fit.shrink,
            "left": fit.left,
        },
        "data": {
            "runs": [run.label for run in data.runs],
            "samples": sum(data.lengths),
            "breakaways": data.breakaways,
            "normal_force": data.normal,
            "rest_speed": data.rest_speed,
            "force_noise": data.force_noise,
            "velocity_error": data.speed_error,
        },
        "laws": [_law(law) for law in fit.laws],
        "skipped": fit.skipped,
        "notices": fit.notices,
        "provenance": fit.provenance,
    }
    return cast("dict[str, object]", plain(found))


def _law(law: FittedLaw) -> dict[str, object]:
    names = ("law", "load", "offset", "gain", "rms", "held_out_rms", "sigmas", "tied")
    described = ("value", "std", "interval", "unit", "bounded")
    return {
        **{name: getattr(law, name) for name in names},
        "samples_per_independent": law.memory,
        "settled": law.settled,
        "remarks": law.remarks,
        "parameters": {
            name: {key: getattr(parameter, key) for key in described}
            for name, parameter in law.parameters.items()
        },
    }


def as_text(fit: FrictionFit) -> str:
    """Return the verdict, the laws and the parameters for a terminal."""
    lines = [fit.summary, "", f"{'law':<44}{'held out':>10}{'fitted':>10}{'behind':>11}"]
    lines[-1] += f"{'numbers':>9}"
    for law in fit.laws[:_ROWS]:
        behind = "tie" if law.tied else f"{law.sigmas:.1f} s.d."
        mark = "*" if law is fit.chosen else " "
        lines.append(
            f"{mark} {law.name:<42}{law.held_out_rms:>8.3g} N{law.rms:>8.3g} N{behind:>11}"
            f"{len(law.parameters):>9}"
        )
    if len(fit.laws) > _ROWS:
        lines.append(f"  and {len(fit.laws) - _ROWS} more, in friction.json")
    lines += ["", f"{'parameter of ' + fit.chosen.law:<26}{'value':>12}{'95 % interval':>26}  unit"]
    for name, p in fit.chosen.parameters.items():
        if p.interval is not None:
            between = f"{p.interval[0]:.4g} to {p.interval[1]:.4g}"
        else:
            between = "at the end of its range" if p.bounded else "not determined"
        lines.append(f"{name:<26}{p.value:>12.4g}{between:>26}  {p.unit}")
    lines += [f"note: {remark}" for remark in fit.chosen.remarks]
    levels = [n for n in ("mu_coulomb", "mu_static") if n in fit.chosen.parameters]
    if levels and fit.chosen.load == "constant":
        newtons = f"{fit.data.normal:.4g} N"
        lines.append(f"coefficients count under a normal force of {newtons}")
    elif levels:
        lines.append("coefficients count under the load, and the preload where there is one")
    return "\n".join(lines)


def _markdown(fit: FrictionFit) -> str:
    lines = ["# Friction characteristic", "", "```", as_text(fit), "```", ""]
    for notice in fit.notices:
        lines.append(f"- {notice}")
    if fit.notices:
        lines.append("")
    lines += [f"Computed by locosweep {fit.provenance['locosweep']}.", ""]
    for title, name in (
        ("Friction force over velocity", "characteristic.png"),
        ("What the chosen law leaves", "residuals.png"),
        ("Laws on samples held out", "laws.png"),
        ("Force over time", "force.png"),
    ):
        lines += [f"![{title}]({name})", ""]
    return "\n".join(lines)


def save(
    fit: FrictionFit, folder: str | os.PathLike[str], *, command: str | None = None
) -> list[Path]:
    """Write the report and its pictures; every file appears whole or not at all."""
    from locosweep.friction_fit.picture import pictures
    from locosweep.plot.save import save_figure

    drawn = pictures(fit)
    text = as_json(as_dict(fit)) + "\n"
    folder, files = make_folder(folder), []
    for name, content in {"friction.json": text, "friction.md": _markdown(fit)}.items():
        write_text(folder / name, content)
        files.append(folder / name)
    for name, figure in drawn.items():
        save_figure(figure, folder / name, command=command)
        files.append(folder / name)
    return files
