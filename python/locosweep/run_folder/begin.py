"""Begin a run folder, or find what it is: the same sweep, by the same version, goes on."""

from __future__ import annotations

import hashlib
import math
import platform
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core, memory
from locosweep.errors import InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.cells import NUMERICS_VERSION
from locosweep.run_folder.commit import sync_folders, write_file, write_first
from locosweep.run_folder.faults import step
from locosweep.run_folder.manifest import LOGS, NAME, Manifest, read, store_files
from locosweep.run_folder.plan import HELD, Plan, cells_of_chunk, cut
from locosweep.run_folder.written_spec import spec_of
from locosweep.specs.sweep import Spec

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.run_folder.cells import Cells

_SHOWN = 100
"""Characters of a line of a sweep file in a message: an axis may have millions."""


def begin(
    folder: Path,
    cells: Cells,
    threads: int,
    *,
    chunk: int | None = None,
    memory_limit: int | None = None,
    allow_drift: bool = False,
) -> tuple[Manifest, bool]:
    """Return the manifest of a folder, made if there is none; and whether bits have drifted."""
    spec, drive = spec_of(cells)
    probe = cells.probe()
    if not (folder / NAME).exists():
        _check_new(folder)
        most = chunk or cells_of_chunk(cells.bytes_per_cell, cells.seconds_per_cell(threads))
        plan = cut(cells.shape, most)
        store = _described(arrays.metadata(cells, plan))
        # What these libraries take counts as well.
        _check_memory(plan, cells, memory_limit)
        new = Manifest(spec, NUMERICS_VERSION, probe, plan, store, drive, _versions())
        make_run(folder, new)
    # Of several that begin at once the first one's plan holds.
    found = read(folder)
    # Texts may differ where another version wrote them.
    same = found.spec == spec or Spec.from_toml(found.spec) == Spec.from_toml(spec)
    if not same or found.drive != drive:
        raise InputError(
            f"{folder} holds another sweep ({_difference(found, spec)}): name another folder"
        )
    _check_memory(found.plan, cells, memory_limit)
    if not allow_drift:
        refuse_drift(folder, found, probe)
    return found, _drifted(found, probe)


def make_run(folder: Path, manifest: Manifest) -> None:
    """Make a folder with this manifest, unless it has one."""
    if (folder / NAME).exists():
        return
    _check_new(folder)
    try:
        (folder / LOGS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make this folder: {error.strerror}") from None
    write_first(folder / NAME, manifest.to_json())


def _check_memory(plan: Plan, cells: Cells, limit: int | None) -> None:
    size = HELD * math.prod(plan.chunk) * cells.bytes_per_cell
    memory.check(size, limit, "chunks of the run", "give fewer cells a chunk (--chunk, chunk=)")


def refuse_drift(folder: Path, found: Manifest, probe: str) -> None:
    """Refuse a run whose chunks this version would compute with other bits."""
    if _drifted(found, probe):
        raise InputError(
            f"{folder} was begun by locosweep {found.versions.get('locosweep')} (numerics_version "
            f"{found.numerics_version}), which gives other bits than this one, {_core.version()} "
            f"(numerics_version {NUMERICS_VERSION}): name another folder, or allow it "
            "(--allow-drift)"
        )


def _drifted(found: Manifest, probe: str) -> bool:
    return (found.numerics_version, found.probe) != (NUMERICS_VERSION, probe)


def _check_new(folder: Path) -> None:
    try:
        foreign = folder.exists() and any(
            p.name != LOGS and not p.name.endswith(".partial") for p in folder.iterdir()
        )
    except NotADirectoryError:
        raise InputError(f"{folder}: a file is there: allowed is a folder") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot use this folder: {error.strerror or error}") from None
    # Another process may have begun just now.
    if foreign and not (folder / NAME).exists():
        raise InputError(f"{folder} is not empty and no run folder: name another folder")


def _difference(found: Manifest, spec: str) -> str:
    pairs = zip_longest(found.spec.splitlines(), spec.splitlines(), fillvalue="nothing")
    for there, here in pairs:
        if there != here:
            return f"there: {there[:_SHOWN]}, here: {here[:_SHOWN]}"
    return "with another drive"


def _versions() -> dict[str, str]:
    zarr = arrays.need("zarr")
    return {
        "locosweep": _core.version(), "zarr": zarr.__version__, "numpy": np.__version__,
        "python": platform.python_version(),
    }  # fmt: skip


def _described(files: dict[str, bytes]) -> dict[str, str]:
    return {
        path: content.decode()
        if path.endswith("zarr.json")
        else hashlib.sha256(content).hexdigest()
        for path, content in files.items()
    }


def prepare(folder: Path, manifest: Manifest) -> None:
    """Write what is missing of the store's metadata, coordinates and copies for people."""
    root = folder / arrays.STORE
    wanted = store_files(manifest)
    folders: list[Path] = []
    for name, content in wanted.items():
        path = root / name
        if not path.exists():
            try:
                step("metadata")
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise InputError(
                    f"{path.parent}: cannot make this folder: {error.strerror}"
                ) from None
            write_file(path, [content])
            folders += [path.parent, root, folder]
    if folders:
        sync_folders(folders)
