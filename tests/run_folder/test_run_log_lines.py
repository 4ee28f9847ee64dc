"""Lines of a log: read by their form or as JSON, they say the same."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

import pytest
from run_cases import CLOSED

import locosweep as ls
from locosweep.run_folder import log_lines
from locosweep.run_folder.log_lines import Done, Reader
from locosweep.run_folder.plan import Plan

if TYPE_CHECKING:
    from pathlib import Path

SPEC: dict[str, Any] = {**CLOSED, "chunk": 30}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"seconds":', b'"seconds": '),
        (b'"seconds":', b'"seconds":0'),
        (b'"seconds":', b'"seconds":-'),
        (b'"seconds":', b'"seconds":NaN,"s":'),
        (b'"seconds":', b'"counts":{},"seconds":'),
        (b'"counts":', b'"counts":{"peak_power":{"0":"x"}},"counts":'),
        (b'"counts":{', b'"counts":{"peak_power":{"0":1e400},'),
        (b'"counts":{', b'"counts":{,'),
        (b'"counts":{', b'"counts":{"\xff":{},'),
        (b'"chunk":', b'"chunk":0'),
        (b'"chunk":', b'"chunk":1' + b"0" * 5000),
        (b'"chunk":', b'"chunk":-'),
        (b'"mean_velocity":["', b'"mean_velocity":["X'),
        (b'"mean_velocity":["', b'"mean_velocity" :["'),
        (b'"mean_velocity_status":["', b'"mean_velocity_status":["\\u0030'),
        (b'"at":', b'"at":1e999,"at":'),
        (b'"at":', b'"at":1e9'),
    ],
)  # fmt: skip
def test_a_line_read_by_its_form_says_what_it_says_as_json(
    old: bytes, new: bytes, tmp_path: Path
) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    (log,) = (run.folder / "log").iterdir()
    names = run.state.array_names
    for line in log.read_bytes().splitlines():
        text = line.rpartition(b"\t")[0]
        for changed in {text, text.replace(old, new, 1)}:
            said = changed + b"\t%08x" % zlib.crc32(changed)
            # A reader of other arrays finds no line in the form that it knows.
            assert _told(Reader(names).read(said)) == _told(Reader([]).read(said))


def test_lines_as_they_are_written_need_no_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    (log,) = (run.folder / "log").iterdir()
    wanted = [one for one in map(Reader([]).read, log.read_bytes().splitlines()) if one]
    monkeypatch.setattr(log_lines, "_of_json", lambda _: {"at": 0.0})
    reader = Reader(run.state.array_names)
    found = [reader.read(line) for line in log.read_bytes().splitlines()]
    assert [_told(one) for one in found[1:]] == [_told(one) for one in wanted[1:]]
    assert isinstance(found[-1], Done)


def _told(said: Done | dict[str, Any] | None) -> object:
    if not isinstance(said, Done):
        return said
    return said.chunk, said.files, said.sizes, said.counts, said.seconds, said.at


@pytest.mark.parametrize("shape", [(), (1,), (7, 5), (6, 4, 9)])
def test_many_chunks_at_once_have_the_names_and_cells_of_each(shape: tuple[int, ...]) -> None:
    plan = Plan(shape, tuple(min(3, n) for n in shape))
    some = [*range(plan.count), 0]
    assert plan.keys(some) == [plan.key(chunk) for chunk in some]
    assert plan.cells_in(some) == sum(map(plan.cells, some))
    assert (plan.keys([]), plan.cells_in([])) == ([], 0)
