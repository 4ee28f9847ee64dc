"""File systems without hard links: what is first there under a name stays all the same."""

from __future__ import annotations

import errno
import os
import threading
from typing import TYPE_CHECKING, Any, NoReturn

import pytest
from run_cases import CLOSED, data_files, partials

import locosweep as ls
from locosweep.run_folder import commit
from locosweep.run_folder.commit import write_first
from locosweep.run_folder.manifest import NAME

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

SPEC: dict[str, Any] = {**CLOSED, "chunk": 30}
WRITERS = 16


def refusing(number: int) -> Callable[..., NoReturn]:
    """Return an ``os.link`` of a file system that answers with this error."""

    def link(*_: object, **__: object) -> NoReturn:
        raise OSError(number, os.strerror(number))

    return link


@pytest.fixture
def no_links(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", refusing(errno.EPERM))


@pytest.mark.parametrize(
    "number", [errno.EPERM, errno.EACCES, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS]
)
def test_a_run_needs_no_links(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = data_files(ls.sweep(**SPEC, out=tmp_path / "links").folder)
    monkeypatch.setattr(os, "link", refusing(number))
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    assert run.complete
    assert data_files(run.folder) == wanted
    assert partials(run.folder) == []
    assert ls.sweep(**SPEC, out=run.folder).complete


def test_another_error_of_a_link_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", refusing(errno.ENOSPC))
    with pytest.raises(ls.InputError, match=r"manifest.json: cannot write .* No space left"):
        ls.sweep(**SPEC, out=tmp_path / "run")
    assert not (tmp_path / "run" / NAME).exists()
    assert partials(tmp_path) == []


@pytest.mark.usefixtures("no_links")
def test_of_many_writers_at_once_one_is_first_for_all(tmp_path: Path) -> None:
    for turn in range(20):
        path = tmp_path / f"first{turn}"
        gate, found = threading.Barrier(WRITERS), []

        def begin(i: int, path: Path = path, gate: Any = gate, found: Any = found) -> None:
            gate.wait()
            write_first(path, b"%d" % i * 1000)
            found.append(path.read_bytes())

        threads = [threading.Thread(target=begin, args=(i,)) for i in range(WRITERS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(found) == WRITERS
        assert set(found) == {path.read_bytes()}
    assert partials(tmp_path) == []


@pytest.mark.usefixtures("no_links")
def test_a_writer_that_died_in_its_turn_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commit, "_TURN_SECONDS", 0.1)
    folder = tmp_path / "run"
    folder.mkdir()
    turn = folder / f"{NAME}.turn.partial"
    turn.touch()
    with pytest.raises(ls.InputError, match=r"if none runs, remove .*manifest.json.turn.partial"):
        ls.sweep(**SPEC, out=folder)
    assert partials(tmp_path) == [turn.name]
    turn.unlink()
    assert ls.sweep(**SPEC, out=folder).complete
