"""Hash of the sweeps that a picture or table shows."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from locosweep.result import Result


def spec_hash(*results: Result) -> str:
    """Hash the requests of results, in order: axes, fixed values and outputs, not the values.

    Returns a SHA-256 over canonical JSON, 64 hexadecimal digits.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.provenance import spec_hash
    >>> def drive(limit):
    ...     return ls.sweep("peak_speed", mu_static=0.5, mu_coulomb=0.3, segments=[3, 4],
    ...                     drive_limit=limit)
    >>> spec_hash(drive(1)) == spec_hash(drive(1.0)) != spec_hash(drive(2))
    True
    """
    specs = [_spec(result) for result in results]
    text = json.dumps(specs, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _spec(result: Result) -> dict[str, object]:
    # Numbers as text: JSON has no infinity, and repr reads back to the same bits.
    spec: dict[str, object] = {
        "axes": [[name, [repr(float(v)) for v in axis]] for name, axis in result.axes.items()],
        "fixed": {name: repr(float(value)) for name, value in result.fixed.items()},
        "outputs": [[output.quantity, output.reduce] for output in result.outputs],
        "over": result.over,
        "rivals": None if result.rivals is None else [repr(float(v)) for v in result.rivals],
        "q": result.q,
    }
    return {**spec, "how": result.how} if result.how else spec
