"""The verdict of a report in one sentence."""

from __future__ import annotations

from typing import Any


def _said(name: str) -> str:
    return name.replace("_", " ")


def _near(nearest: dict[str, Any], candidates: list[dict[str, Any]]) -> str:
    """Say how much the nearest effects would take away, without calling them the cause."""
    sets = [nearest["effects"], *nearest["as_near"]]
    shown = " or, as well, ".join(" with ".join(map(_said, names)) for names in sets[:3])
    if len(sets) > 3:
        shown += f" or {len(sets) - 3} more"
    first = next(c for c in candidates if c["effects"] == nearest["effects"])
    much = ""
    if first["shrink"] is not None and nearest["shrink_without_worst"] is not None:
        much = f" would make it {first['shrink']:.0%} smaller"
        much += f" ({nearest['shrink_without_worst']:.0%} without the worst tenth of windows) but"
    return f"; {shown}{much} leaves more than noise, so none of them is named as its cause"


def summary(report: dict[str, Any]) -> str:
    """Return the verdict of a report as one sentence for a person."""
    verdict, gap = report["verdict"], report["gap"]
    sure = f"{verdict['probability']:.0%}"
    if verdict["status"] == "none":
        return f"The nominal model accounts for these runs: no gap beyond the noise ({sure} sure)."
    before = gap["before"] / gap["noise_floor"] if gap["noise_floor"] else float("nan")
    size = f"the gap in {gap['channel']} is {before:.3g} times the noise"
    if verdict["status"] == "unexplained":
        best = next((c for c in report["candidates"] if c["effects"]), None)
        near = ""
        if unlisted := verdict.get("unlisted"):
            names = " with ".join(map(_said, unlisted["effects"]))
            near = f"; {names} would do, and so would one force along the way"
        elif nearest := verdict.get("nearest"):
            near = _near(nearest, report["candidates"])
        elif "nearest" in verdict:
            near = "; none makes it surely smaller"
        elif best and best["shrink"] is not None:
            names = " with ".join(map(_said, best["effects"]))
            near = f"; nearest comes {names}, which leaves more than noise"
        return f"A gap is there that no known effect accounts for: {size}{near} ({sure} sure)."
    causes = [" or ".join(_said(n) for n in names) for names in verdict["equivalent"]]
    cause = " and ".join(f"({c})" if " or " in c and len(causes) > 1 else c for c in causes)
    text = f"The gap comes from {cause}"
    if verdict["law_mismatch"]:
        text = f"The gap may come from {cause}, by another law than the usual formula"
    if gap["shrink"] is not None:
        text += f": with it the error in {gap['channel']} falls by {gap['shrink']:.1%}"
        text += f" to {gap['after']:.2g} {gap['unit']} (noise {gap['noise_floor']:.2g})"
    if verdict["status"] == "ambiguous":
        text += "; these runs cannot tell which"
    return f"{text} ({sure} sure)."
