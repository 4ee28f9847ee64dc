"""Results of a bench as a file, for the tables of the documentation."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from common.machine import describe


def json_option(parser: argparse.ArgumentParser) -> None:
    """Let a bench write its numbers to a file."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers to FILE")


def write(file: Path | None, result: Mapping[str, Any]) -> None:
    """Write numbers with the machine that they hold for, where a file is asked for."""
    if file is not None:
        text = json.dumps({"machine": describe(["locosweep"]), **result}, indent=2)
        file.write_text(text + "\n", encoding="utf-8")
