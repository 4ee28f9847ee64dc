"""What a sweep computes at every point: quantities, reductions and how they are simulated."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from locosweep import _core
from locosweep.errors import InputError
from locosweep.grid import number
from locosweep.registry import quantity as quantity_named

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    Samples = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Request:
    """What a sweep computes at every point, whatever its axes: made by `Request.of`.

    Attributes
    ----------
    quantities, reduce : tuple of str
        What, and how `over` is folded away; `reduce` is empty without `over`.
    outputs : tuple of (str, str or None, float or None)
        Quantity, reduction and quantile of each output.
    """

    quantities: tuple[str, ...]
    reduce: tuple[str, ...]
    outputs: tuple[tuple[str, str | None, float | None], ...]
    over: str | None = None
    q: float | None = None
    law: str | None = None
    drive: str | None = None
    gait: str | None = None
    method: str | None = None
    table: Samples | None = None

    @classmethod
    def of(
        cls,
        quantity: str | Sequence[str],
        reduce: str | Sequence[str] | None = None,
        *,
        q: float | None = None,
        table: tuple[ArrayLike, ArrayLike] | None = None,
        **choice: str | None,
    ) -> Self:
        """Check names and pairs; `choice` has over, law, drive, gait and method."""
        names = _names("quantity", quantity)
        how = [None] if reduce is None else _names("reduce", reduce)
        if not names or not how:
            raise InputError(f"{'quantity' if not names else 'reduce'} is empty: name at least one")
        if q is not None:
            if "quantile" not in how:
                raise InputError(f"q is {q!r}: allowed only together with reduce 'quantile'")
            q = number("q", q, "a number from 0 to 1")
        _check_choice(names, {**choice, "table": table})
        outputs = [(name, r, q if r == "quantile" else None) for name in names for r in how]
        if len(set(outputs)) < len(outputs):
            raise InputError("quantity or reduce names the same thing twice")
        folds = tuple(r for r in how if r is not None)
        return cls(
            tuple(names), folds, tuple(outputs), q=q, table=samples_of(table), **choice
        )  # fmt: skip

    def job(
        self,
        axes: Mapping[str, NDArray[np.float64]],
        fixed: Mapping[str, float],
        outputs: Sequence[int] | None = None,
        sample: Mapping[str, NDArray[np.float64]] | None = None,
    ) -> _core.Sweep:
        """Return the checked job on these axes, for some outputs by number or for all.

        A `sample` is a last axis along which several parameters take their values together.
        """
        wanted = self.outputs if outputs is None else [self.outputs[i] for i in outputs]
        return _core.Sweep(
            list(axes.items()),
            list(fixed.items()),
            list(wanted),
            self.over,
            law=self.law,
            drive=self.drive,
            gait=self.gait,
            method=self.method,
            table=self.table,
            sample=list((sample or {}).items()),
        )


def _names(key: str, given: str | Sequence[str | None]) -> list[Any]:
    """Return what was given as a list of names."""
    some = [given] if isinstance(given, str) else given
    if not isinstance(some, list | tuple) or not all(isinstance(n, str | None) for n in some):
        raise InputError(f"{key} is {given!r}: allowed is a name, or several")
    return list(some)


def _check_choice(names: Sequence[str], choice: Mapping[str, Any]) -> None:
    """Refuse how to simulate where nothing is simulated."""
    given = [key for key, value in choice.items() if value is not None and key != "over"]
    if given and not any(quantity_named(name).simulated for name in names):
        raise InputError(f"{given[0]} is given, but {', '.join(names)} is not simulated")


def how(job: _core.Sweep, table: Samples | None) -> dict[str, str]:
    """Tell how simulated quantities were found; empty for closed forms."""
    found = {}
    if job.choice is not None:
        found = dict(zip(("law", "drive", "method"), job.choice, strict=True))
    if job.gait is not None:
        found["gait"] = job.gait
    if table is not None:
        digest = hashlib.sha256(b"".join(part.tobytes() for part in table))
        found["table_sha256"] = digest.hexdigest()
    return found


def samples_of(
    table: tuple[ArrayLike, ArrayLike] | None,
) -> Samples | None:
    """Turn the samples of a drive into two arrays of numbers."""
    if table is None:
        return None
    try:
        times, values = (np.asarray(part, dtype=np.float64) for part in table)
    except (TypeError, ValueError):
        raise InputError("table is not two arrays of numbers: times and values") from None
    if times.ndim != 1 or values.ndim != 1:
        raise InputError(
            f"table has {times.ndim} and {values.ndim} dimensions: allowed is one each"
        )
    return times, values
