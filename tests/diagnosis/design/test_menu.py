"""Runs that may be proposed: each changes what it says, and nothing else."""

import numpy as np
import pytest

from locosweep.diagnosis.design.menu import MENU
from locosweep.files.runs import Run

T = np.arange(0.0, 2.0, 0.01)
RUN = Run("a", T, np.sin(3.0 * T), {"x": 0.1 * T}, None)
CHANGES = {change.name: change for change in MENU}


def changed(name, run=RUN, slope=2.0):
    return CHANGES[name].of(run, slope)


def test_every_run_has_a_name_of_its_own_and_a_sentence():
    assert len(CHANGES) == len(MENU)
    assert all(change.what for change in MENU)


@pytest.mark.parametrize("name", CHANGES)
def test_times_rise_and_drives_stay_within_the_largest(name):
    run = changed(name)
    assert run.t.shape == run.drive.shape
    assert (np.diff(run.t) > 0.0).all()
    assert np.abs(run.drive).max() <= np.abs(RUN.drive).max() * (1.0 + 1e-12)


def test_reverse_has_the_opposite_drive():
    np.testing.assert_array_equal(changed("reverse").drive, -RUN.drive)


def test_a_turned_robot_has_the_opposite_slope():
    assert changed("turn round").slope_deg == -2.0
    assert changed("turn round", Run("a", T, RUN.drive, {}, 7.0)).slope_deg == -7.0


def test_an_incline_is_steeper_by_five_degrees():
    assert changed("incline").slope_deg == 7.0


def test_slower_takes_three_times_as_long():
    assert changed("slower").t[-1] == pytest.approx(3.0 * T[-1])


def test_dwell_pauses_four_times():
    rests = changed("dwell").drive == 0.0
    begins = np.flatnonzero(np.diff(rests.astype(int)) == 1)
    assert begins.size == 4
    assert changed("dwell").t.size == T.size + 4 * (T.size // 10)


def test_back_goes_the_same_way_twice():
    run = changed("back")
    np.testing.assert_array_equal(run.drive, [*RUN.drive, *-RUN.drive])
    assert run.t[-1] == pytest.approx(2.0 * T[-1], rel=0.01)


def test_later_waits_as_long_as_the_run_takes():
    np.testing.assert_array_equal(changed("later").drive, [*np.zeros(T.size), *RUN.drive])


def test_payload_and_force_sensor_repeat_the_run():
    assert changed("payload") is RUN
    assert changed("force sensor") is RUN
