"""Runs that are named by their labels: those that take part, those that are kept from fits."""

from __future__ import annotations

from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from locosweep.files.runs import Run


def as_labels(name: str, asked: Iterable[Any] | None) -> list[str] | None:
    """Return labels as files have them, in which a run 2 is the text "2"; None passes.

    Examples
    --------
    >>> from locosweep.diagnosis.data.chosen import as_labels
    >>> as_labels("holdout", [2, "7", 3.0])
    ['2', '7', '3']
    """
    if asked is None:
        return None
    if isinstance(asked, str | bytes) or not hasattr(asked, "__iter__"):
        raise InputError(f"{name} is {asked!r}: allowed is a list of labels, for instance ['2']")
    return [_text(label) for label in asked]


def _text(label: Any) -> str:
    whole = isinstance(label, Integral) and not isinstance(label, bool)
    if whole or (isinstance(label, Real) and float(label).is_integer()):
        return str(int(label))
    return str(label)


def chosen(runs: Sequence[Run], labels: Sequence[str] | None) -> list[Run]:
    """Return the runs that have one of some labels, in their order; all without labels."""
    if labels is None:
        return list(runs)
    known = [run.label for run in runs]
    if not labels:
        raise InputError(f"labels (--runs) is empty: allowed are some of {', '.join(known)}")
    for label in labels:
        if label not in known:
            raise InputError(f"labels (--runs): no run {label}: there are {', '.join(known)}")
    return [run for run in runs if run.label in labels]
