"""JSON without NaN and infinities: what it cannot hold becomes null."""

from __future__ import annotations

import json
import math
from pathlib import PurePath
from typing import Any


def as_json(value: object) -> str:
    """Return indented JSON; the same value gives the same bytes."""
    return json.dumps(plain(value), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """Return lists for arrays, text for paths, and None for numbers that are not finite."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, PurePath):
        return str(value)
    # Arrays and scalars of NumPy, which this does not import.
    return plain(value.tolist()) if hasattr(value, "tolist") else value
