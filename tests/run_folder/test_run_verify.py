"""Nothing is read that was altered: `verify` finds it, reading refuses it, `repair` mends it."""

from __future__ import annotations

import json
import os
import random
import shutil
from typing import TYPE_CHECKING, Any

import pytest
from run_cases import CLOSED, data_files, same

import locosweep as ls
from locosweep.cli import main
from locosweep.run_folder import begin
from locosweep.run_folder.manifest import _digest
from locosweep.run_folder.verify import repair, verify

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

SPEC: dict[str, Any] = {**CLOSED, "chunk": 40}
ARRAY = "data.zarr/mean_velocity"
SECOND = 2
"""Number of the chunk c.1.0.0."""


@pytest.fixture(scope="module")
def pristine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pristine") / "run"
    ls.sweep(**SPEC, out=folder)
    return folder


@pytest.fixture
def folder(pristine: Path, tmp_path: Path) -> Path:
    shutil.copytree(pristine, tmp_path / "run")
    return tmp_path / "run"


def swap(a: Path) -> None:
    b = a.with_name("c.1.0.0")
    shutil.move(a, a.with_suffix(".x"))
    shutil.move(b, a)
    shutil.move(a.with_suffix(".x"), b)


def flip(path: Path, bit: int = 100) -> None:
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def zero(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5])


def link(path: Path) -> None:
    path.unlink()
    path.symlink_to(path.with_name("c.1.0.0"))


MUTATIONS: dict[str, Callable[[Path], None]] = {
    "swapped": swap, "flipped": flip, "zeroed": zero, "truncated": cut,
    "emptied": lambda path: path.write_bytes(b""), "gone": os.unlink, "linked": link,
}  # fmt: skip


@pytest.mark.parametrize("name", MUTATIONS)
@pytest.mark.parametrize("array", ["mean_velocity", "peak_power_status"])
def test_an_altered_chunk_is_found_refused_and_repaired(
    name: str, array: str, folder: Path
) -> None:
    wanted = data_files(folder)
    MUTATIONS[name](folder / "data.zarr" / array / "c.0.0.0")
    found = verify(folder)
    assert {fault.chunk for fault in found.faults} == ({0, SECOND} if name == "swapped" else {0})
    assert all(fault.file.startswith(f"data.zarr/{array}/c.") for fault in found.faults)
    with pytest.raises(ls.InputError, match=r"chunk \d+ is damaged.*verify \S+ --repair"):
        ls.open_run(folder).to_xarray()[array].to_numpy()
    with pytest.raises(ls.InputError, match="is damaged"):
        ls.open_run(folder).to_result()
    assert repair(folder, found) == len(found.faults)
    assert verify(folder).faults == ()
    assert data_files(folder) == wanted
    assert same(ls.open_run(folder), ls.sweep(**CLOSED))


def test_what_others_read_of_swapped_chunks_is_wrong(folder: Path) -> None:
    """Why the hash stands beside the number: a checksum within the file catches no place."""
    import xarray as xr

    before = xr.open_zarr(folder / "data.zarr")["mean_velocity"].to_numpy()
    swap(folder / ARRAY / "c.0.0.0")
    after = xr.open_zarr(folder / "data.zarr")["mean_velocity"].to_numpy()
    assert before.tobytes() != after.tobytes()
    assert verify(folder).faults


def test_random_flips_are_never_silent(folder: Path) -> None:
    chance = random.Random(5)  # noqa: S311 - places, not secrets
    files = [p for p in (folder / "data.zarr").rglob("*") if p.is_file()]
    for _ in range(150):
        path = chance.choice(files)
        bit = chance.randrange(8 * path.stat().st_size)
        flip(path, bit)
        (fault,) = verify(folder).faults
        assert folder / fault.file == path
        flip(path, bit)
    assert verify(folder).faults == ()


def test_altered_metadata_changes_nothing_that_we_read_and_is_repaired(folder: Path) -> None:
    wanted = data_files(folder)
    meta = folder / ARRAY / "zarr.json"
    meta.write_text(meta.read_text().replace("m/s", "km/h"))
    (folder / "data.zarr" / "mu_static" / "c.0").write_bytes(b"?")
    assert same(ls.open_run(folder), ls.sweep(**CLOSED))
    assert ls.open_run(folder).to_xarray()["mean_velocity"].attrs["units"] == "m/s"
    found = verify(folder)
    assert [fault.chunk for fault in found.faults] == [None, None]
    repair(folder, found)
    assert data_files(folder) == wanted


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: r | {"format": "locosweep.run/2"}, "format 'locosweep.run/2'"),
        (lambda r: r | {"spec": r["spec"].replace("0.3", "0.4")}, "altered or damaged"),
        (lambda r: {k: v for k, v in r.items() if k != "sha256"}, "not a manifest"),
        (lambda _: [1, 2], "not a manifest"),
        (lambda _: "text", "not a manifest"),
    ],
)
def test_an_altered_manifest_is_refused(
    change: Callable[[Any], Any], words: str, folder: Path
) -> None:
    path = folder / "manifest.json"
    path.write_text(json.dumps(change(json.loads(path.read_bytes()))))
    for use in (ls.open_run, verify, lambda f: ls.sweep(**SPEC, out=f)):
        with pytest.raises(ls.DataFileError, match=words):
            use(folder)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: r["plan"].update(chunk=[1]), "do not fit each other"),
        (lambda r: r["plan"].update(chunk=[0, 1, 1]), "do not fit each other"),
        (lambda r: r["plan"].update(shape=[9, 9, 9]), "do not fit each other"),
        (lambda r: r["plan"].update(shape="abc"), "a value in it is not of the kind"),
        (lambda r: r["store"].update({"../../evil/zarr.json": "{}"}), "do not fit each other"),
        (lambda r: r["store"].pop("zarr.json"), "do not fit each other"),
        (lambda r: r.update(spec="not TOML ["), "not a manifest"),
        (lambda r: r.update(spec=3), "a value in it is not of the kind"),
        (lambda r: r.update(store=3), "a value in it is not of the kind"),
        (lambda r: r.pop("probe"), "'probe' is missing"),
    ],
)
def test_a_manifest_made_by_hand_is_refused(
    change: Callable[[Any], Any], words: str, folder: Path
) -> None:
    """Its hash is right, so that only what it says can be wrong."""
    path = folder / "manifest.json"
    record = json.loads(path.read_bytes())
    change(record)
    record["sha256"] = _digest(record)
    path.write_text(json.dumps(record))
    with pytest.raises(ls.DataFileError, match=words):
        ls.open_run(folder)
    with pytest.raises(ls.DataFileError, match=words):
        verify(folder)
    assert not (folder.parent / "evil").exists()


def test_random_bytes_in_a_manifest_are_refused(folder: Path) -> None:
    path = folder / "manifest.json"
    whole = path.read_bytes()
    chance = random.Random(11)  # noqa: S311 - places, not secrets
    for _ in range(300):
        content = bytearray(whole)
        content[chance.randrange(len(whole))] = chance.randrange(256)
        end = len(whole) if chance.random() < 0.8 else chance.randrange(len(whole))
        path.write_bytes(content[:end])
        try:
            run = ls.open_run(folder)
        except ls.DataFileError:
            continue
        # A byte that means the same: a blank for another, or itself.
        assert run.manifest.spec == json.loads(whole)["spec"]


def test_bits_of_another_version_are_repaired_where_that_is_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = ls.sweep(**CLOSED, chunk=40, out=tmp_path / "run")
    file = next((run.folder / "data.zarr").rglob(run.manifest.plan.key(1)))
    file.write_bytes(b"\0" + file.read_bytes()[1:])
    monkeypatch.setattr(begin, "NUMERICS_VERSION", -1)
    command = ["verify", str(run.folder), "--repair"]
    assert main(command) == 2
    assert main([*command, "--allow-drift"]) == 0
    assert ls.open_run(run.folder).complete
