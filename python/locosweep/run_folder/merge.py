"""Merge run folders of one sweep, as machines that share no folder fill one each."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep.errors import DataFileError, InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.begin import make_run, prepare
from locosweep.run_folder.commit import sync_folders, write_file
from locosweep.run_folder.log import Log
from locosweep.run_folder.log_lines import Done
from locosweep.run_folder.manifest import LOGS, NAME, read
from locosweep.run_folder.name import check_run_name
from locosweep.run_folder.run import Run
from locosweep.run_folder.state import State, altered, keeping
from locosweep.run_folder.writer import about

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Sequence

    from locosweep.run_folder.manifest import Manifest


def merge(
    sources: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    progress: Callable[[int, int, float], object] | None = None,
) -> Run:
    """Copy finished chunks of runs of one sweep into a folder, and return it opened.

    Parameters
    ----------
    sources : sequence of path-like
        Run folders of the same sweep and the same chunks, complete or not.
    out : path-like
        A new folder, or one of the same sweep; what is there stays. May be copied into again.
    progress : callable, optional
        Receives copied and all chunks to copy, and 0.

    Raises
    ------
    InputError
        No source, or one with another sweep, other chunks or other bits.
    DataFileError
        A chunk of a source was altered; nothing altered is copied.
    """
    if not sources:
        raise InputError("nothing to merge: name at least one run folder")
    folder = check_run_name(out)
    found = {Path(source): read(Path(source)) for source in sources}
    first, whole = next(iter(found.items()))
    if (folder / NAME).exists():
        found = {folder: read(folder), **found}
        first, whole = next(iter(found.items()))
    for source, manifest in found.items():
        _check_same(source, manifest, first, whole)
    states = {source: State(source, manifest) for source, manifest in found.items()}
    there = {chunk for theirs in states.values() for chunk in theirs.done}
    for source, theirs in states.items():
        for chunk, what in theirs.damaged.items():
            if chunk not in there:
                raise DataFileError(altered(source, chunk, what))
    make_run(folder, whole)
    prepare(folder, whole)
    state = State(folder, whole)
    have = set(state.done)
    work: list[tuple[Path, State, int]] = []
    for source, theirs in states.items():
        new = [chunk for chunk in sorted(theirs.done) if chunk not in have]
        have.update(new)
        work += [(source, theirs, chunk) for chunk in new]
    log = Log(folder / LOGS, about(0, merged=True))
    with keeping(folder, whole):
        for number, (source, theirs, chunk) in enumerate(work, 1):
            log.append([_copy(source, theirs, folder, chunk)])
            if progress is not None:
                progress(number, len(work), 0.0)
    log.close()
    return Run(folder)


def _check_same(source: Path, manifest: Manifest, first: Path, whole: Manifest) -> None:
    """Refuse what does not belong together."""
    reason, advice = None, ""
    if manifest.spec_sha256 != whole.spec_sha256:
        reason = "another sweep"
    elif (manifest.numerics_version, manifest.probe) != (whole.numerics_version, whole.probe):
        reason, advice = "other bits", " (computed by another version)"
    elif manifest.plan != whole.plan:
        reason, advice = "other chunks", " (give all of them the same --chunk)"
    elif manifest.store != whole.store:
        reason, advice = "other descriptions of its arrays", " (written by another version)"
    if reason is not None:
        raise InputError(
            f"{source} has {reason} than {first}{advice}: allowed are runs of one sweep"
        )


def _copy(source: Path, theirs: State, folder: Path, chunk: int) -> Done:
    """Copy the files of a chunk, held against their hashes."""
    key = theirs.manifest.plan.key(chunk)
    files = {}
    for name in theirs.array_names:
        path = source / arrays.STORE / name / key
        try:
            content = path.read_bytes()
        except OSError as error:
            raise DataFileError(f"{path}: {error.strerror or error}") from None
        digest = hashlib.sha256(content).hexdigest()
        if digest not in theirs.hashes(chunk, name):
            raise DataFileError(altered(source, chunk, f"{path} was altered"))
        write_file(folder / arrays.STORE / name / key, [content])
        files[name] = (digest, len(content))
    sync_folders(folder / arrays.STORE / name for name in theirs.array_names)
    known = theirs.done[chunk][0]
    return Done(chunk, files, known.counts, known.seconds)
