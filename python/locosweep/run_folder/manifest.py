"""The manifest of a run: its spec, its plan and what its files are; written once."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from locosweep.errors import DataFileError, InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.cells import Cells
from locosweep.run_folder.plan import Plan
from locosweep.run_folder.written_spec import cells_of

NAME = "manifest.json"
LOGS = "log"
"""Folder of the logs."""
_FORMAT = "locosweep.run/1"
_MOST_FILE = 256 << 20
"""Bytes of a manifest that are read: an axis of ten million values that are no range."""


@dataclass(frozen=True)
class Manifest:
    """What `manifest.json` says.

    Attributes
    ----------
    spec : str
        The sweep file, its ranges and values to the last bit.
    numerics_version : int
        Of the version that began the run.
    probe : str
        SHA-256 of bits at some cells.
    plan : Plan
        Its chunks.
    store : dict of str to str
        Metadata of the arrays by path in ``data.zarr``, as text, and SHA-256 of coordinates.
    drive : str or None
        The samples of a drive, as CSV.
    versions : dict of str to str
        Of what began the run.
    """

    spec: str
    numerics_version: int
    probe: str
    plan: Plan
    store: dict[str, str]
    drive: str | None
    versions: dict[str, str]

    @property
    def spec_sha256(self) -> str:
        """Hash of spec and drive samples: two runs with the same one belong together."""
        return hashlib.sha256(f"{self.spec}\0{self.drive or ''}".encode()).hexdigest()

    @cached_property
    def cells(self) -> Cells:
        """What the spec describes."""
        return cells_of(self.spec, self.drive, NAME)

    def check(self) -> None:
        """Refuse plan and arrays that are not those of the spec."""
        plan, cells = self.plan, self.cells
        names = [*arrays.array_names(cells), *cells.axes]
        files = {"zarr.json", *(f"{n}/zarr.json" for n in names), *(f"{n}/c.0" for n in cells.axes)}
        fits = plan.shape == cells.shape and len(plan.chunk) == len(plan.shape)
        if not (fits and all(c >= 1 for c in plan.chunk) and files == set(self.store)):
            raise DataFileError(f"{NAME}: plan, arrays and spec do not fit each other")

    def to_json(self) -> bytes:
        """Return the file, with a hash of its own content."""
        record: dict[str, Any] = {"format": _FORMAT, **dataclasses.asdict(self)}
        record["spec_sha256"] = self.spec_sha256
        record["sha256"] = _digest(record)
        return json.dumps(record, indent=1).encode()


def _digest(record: dict[str, Any]) -> str:
    rest = {key: value for key, value in record.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def read(folder: Path) -> Manifest:
    """Read the manifest of a run folder; DataFileError if it is none, or altered."""
    path = folder / NAME
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_FILE + 1)
        if len(content) > _MOST_FILE:
            content = b""
        record = json.loads(content)
        form = record["format"]
    except FileNotFoundError:
        there = "no such folder" if not folder.exists() else f"no run folder: it has no {NAME}"
        raise DataFileError(f"{folder}: {there}") from None
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None
    except (ValueError, TypeError, KeyError, RecursionError):
        raise DataFileError(f"{path}: not a manifest of a run folder") from None
    if form != _FORMAT:
        raise DataFileError(f"{path}: format {form!r}: this version reads {_FORMAT!r}")
    if "sha256" in record and _digest(record) != record["sha256"]:
        raise DataFileError(f"{path}: altered or damaged since it was written (hash differs)")
    try:
        _ = record["sha256"]
        plan = Plan(*(tuple(int(n) for n in record["plan"][k]) for k in ("shape", "chunk")))
        found = Manifest(
            record["spec"], record["numerics_version"], record["probe"], plan, record["store"],
            record["drive"], record["versions"],
        )  # fmt: skip
        found.check()
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise DataFileError(f"{path}: not a manifest of a run folder: {_what(error)}") from None
    return found


def _what(error: Exception) -> str:
    """Say what is wrong with a manifest; Python's own words name no part of it."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, KeyError):
        return f"{error} is missing"
    return "a value in it is not of the kind that belongs there"


def store_files(manifest: Manifest) -> dict[str, bytes]:
    """Return the files of the store that are no chunks, the group's own last."""
    found = {
        path: text.encode() for path, text in manifest.store.items() if path.endswith("zarr.json")
    }
    for name, axis in manifest.cells.axes.items():
        parts = arrays.encode(axis, axis.shape, status=False)
        found[f"{name}/c.0"] = b"".join(bytes(part) for part in parts)
    found["zarr.json"] = found.pop("zarr.json")
    return found
