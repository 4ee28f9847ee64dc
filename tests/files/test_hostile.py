"""Mutated logs are read or refused in one line, whatever was done to them."""

import random

import pytest

from locosweep.errors import InputError
from locosweep.files.runs import load_runs
from locosweep.intake.log import read_log

ROWS = [f"{1764075181 + k * 0.01:.3f};{k % 5 / 2};{k / 7:.4f}".replace(".", ",") for k in range(40)]
BASES = [
    "# c\nZeit;Soll_N;Weg_mm\n" + "\n".join(ROWS),
    "run,t,drive,x,v\n" + "\n".join(f"{k // 20},{k * 0.1:.2f},{k % 3},{k},1" for k in range(40)),
    "t\tdrive\tx [mm]\nms\tN\t\n" + "\n".join(f"{k}\t0\t{k}" for k in range(30)),
    "time,cmd,pos\n" + "\n".join(f"2026-11-25T12:00:{k:02d}.5,1,{k}" for k in range(30)),
]
PIECES = [
    *(text.encode() for text in (
        '"', ";", ",", "\t", "\n", "\r", "#", "nan", "inf", "1e400", "-", "[mm]", "[kN]", "(s)",
        "2026-13-45T99:99:99Z", "2026-11-25T12:00:00+99:99", "9" * 30, "\x1b[2J", "//", "sep=;",
        "\ufeff", "µ", "0x1", "1_0", "٣", "run", "t", "x", "drive", "\x0b", "\u2028",
    )),
    b"\xff", b"\xfe\xff", b"\0", b"\x85",
]  # fmt: skip


def mutated(chance: random.Random) -> bytes:
    data = bytearray(chance.choice(BASES).encode())
    for _ in range(chance.choice([0, 1, 1, 2, 4])):
        at, kind = chance.randrange(len(data) + 1), chance.random()
        if kind < 0.5:
            data[at:at] = chance.choice(PIECES) * chance.choice([1, 1, 1, 2, 30])
        elif kind < 0.7:
            del data[at : at + chance.choice([1, 5, 40, 300])]
        elif kind < 0.85 and at < len(data):
            data[at] = chance.randrange(256)
        else:
            data[at:at] = data[chance.randrange(len(data) + 1) :][:200]
    return bytes(data)


@pytest.mark.parametrize("seed", range(4))
def test_mutated_logs(tmp_path, seed):
    chance, file = random.Random(seed), tmp_path / "log.csv"  # noqa: S311
    refused, taken = [], 0
    for _ in range(60):
        file.write_bytes(mutated(chance))
        for read in (load_runs, read_log):
            try:
                read(file)
                taken += 1
            except InputError as error:
                refused.append(str(error))
    assert taken > 5
    assert len(refused) > 5
    assert [text for text in refused if "\n" in text or len(text) > 3000] == []
