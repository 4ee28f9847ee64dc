"""JSON without NaN and infinities: what it cannot hold becomes null."""

from __future__ import annotations

import json
import math
from typing import Any


def as_json(value: object) -> str:
    """Return indented JSON; the same value gives the same bytes."""
    return json.dumps(plain(value), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """Turn arrays and tuples into lists, and numbers that are not finite into None."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    # Arrays and scalars of NumPy, which this does not import.
    return plain(value.tolist()) if hasattr(value, "tolist") else value
