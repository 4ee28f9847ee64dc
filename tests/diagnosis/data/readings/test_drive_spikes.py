"""Spikes in the drive column."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from locosweep.diagnosis.data.readings.drive_spikes import check_drives
from locosweep.files.runs import Run

T = np.arange(200) * 0.01
RUN = Run("2", T, np.sin(T), {"x": T})


def with_drive(at: slice | int, value: float) -> Run:
    drive = RUN.drive.copy()
    drive[at] = value
    return replace(RUN, drive=drive)


def test_a_spike_is_taken_as_the_command_before() -> None:
    kept, (found,) = check_drives([RUN, with_drive(slice(80, 82), -1e38)])
    assert (found.run, found.column, found.kind) == ("2", "drive", "spike")
    assert (found.t0, found.t1, found.samples) == (T[80], T[81], 2)
    assert kept[0] is RUN
    assert kept[1].drive[78:84].tolist() == np.sin(T[[78, 79, 79, 79, 82, 83]]).tolist()


def test_the_first_command_becomes_none() -> None:
    assert check_drives([with_drive(0, 99.0)])[0][0].drive[0] == 0.0


def test_commands_are_none() -> None:
    strong = replace(RUN, drive=10.0 * RUN.drive)
    for run in (strong, with_drive(slice(80, 84), 50.0), replace(RUN, drive=np.zeros(200))):
        kept, found = check_drives([RUN, run])
        assert found == []
        assert kept[1] is run
    assert check_drives([]) == ([], [])
