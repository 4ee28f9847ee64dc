"""Results of a bench as a file, for the tables of the documentation."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from pathlib import Path
from typing import Any

from common.machine import describe


def json_option(parser: argparse.ArgumentParser) -> None:
    """Let a bench write its numbers to a file."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers to FILE")


def write(file: Path | None, result: dict[str, Any]) -> None:
    """Write numbers with the command and the machine that they hold for, if a file is asked for."""
    if file is not None:
        command = shlex.join(["python", f"benches/{Path(sys.argv[0]).name}", *sys.argv[1:]])
        known = {"command": command, "machine": describe(["locosweep"])}
        text = json.dumps(known | result, indent=2)
        file.write_text(text + "\n", encoding="utf-8")
