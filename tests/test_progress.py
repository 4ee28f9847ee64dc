"""Progress: one protocol for all long calls, a bar, lines in a log."""

import io
import itertools
import json
import sys
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

import locosweep as ls
from locosweep import progress
from locosweep.files.runs import Run
from locosweep.paper.reproduce import reproduce
from locosweep.progress import JsonLines, Meter, Steps, progress_of
from locosweep.replay import replay_runs

ROBOT = ls.Robot({"mass": 0.2, "mu_coulomb": 0.3, "gravity": 9.81, "segments": 4.0})
T = np.linspace(0.0, 1.0, 101)
DRIVE = np.where(T > 0.1, 0.5, 0.0)
STILL = np.random.default_rng(0).normal(0.0, 1e-5, T.size)
FORCE = 0.8 * np.sign(np.sin(9 * T)) + 100 * STILL


def reads(progress, _):
    ls.diagnose({"t": T, "drive": DRIVE, "x": STILL}, ROBOT, progress=progress)


def tells_apart(progress, _):
    pushes = {"push": (T, np.where(T < 0.5, 0.9, 0.0))}
    ls.distinguish(ROBOT, pushes, noise={"x": 1e-4}, progress=progress)


LONG = {
    "sweep": lambda p, _: ls.sweep("resistance", mu_coulomb=[0.1, 0.2], progress=p),
    "simulate": lambda p, _: ls.simulate(law="coulomb", mu_coulomb=0.3, drive_force=2, progress=p),
    "replay": lambda p, _: replay_runs(
        ROBOT, [Run("a", T, DRIVE, {"x": 0 * T, "v": 0 * T})], progress=p
    ),
    "friction": lambda p, _: ls.fit_friction(
        {"t": T, "v": np.sin(9 * T), "force": FORCE}, laws=["coulomb"], progress=p
    ),
    "propagate": lambda p, _: ls.propagate(
        "resistance", {"mu_coulomb": "0.1:0.2"}, samples=128, progress=p
    ),
    "sensitivity": lambda p, _: ls.sensitivity(
        "resistance", {"mu_coulomb": "0.1:0.2"}, samples=128, progress=p
    ),
    "diagnose": reads,
    "distinguish": tells_apart,
    "reproduce": lambda p, folder: reproduce(3, folder, progress=p),
}
SLOW = {"distinguish", "reproduce"}
CALLS = [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in LONG]


@pytest.mark.parametrize("name", CALLS)
def test_every_long_call_takes_a_callable_and_ends_at_its_total(name, tmp_path):
    calls = []
    LONG[name](lambda *state: calls.append(state), tmp_path)
    done, total, rate = calls[-1]
    assert done == total > 0
    assert rate >= 0
    assert all(0 <= a[0] <= a[1] for a in calls)


@pytest.mark.parametrize("name", CALLS)
def test_every_long_call_takes_true_false_and_none_and_refuses_the_rest(name, tmp_path, capsys):
    for nothing in (None, False):
        LONG[name](nothing, tmp_path)
    assert capsys.readouterr().err == ""
    LONG[name](True, tmp_path)
    shown = capsys.readouterr().err
    assert shown.splitlines()
    assert "\r" not in shown
    if name != "sweep":
        with pytest.raises(ls.InputError, match="progress is 3: allowed are True, False, None"):
            LONG[name](3, tmp_path)


def test_a_log_of_a_diagnosis_has_a_line_for_each_step(capsys):
    reads(True, None)
    assert capsys.readouterr().err.splitlines() == [
        "diagnose: reading", "diagnose: single effects", "diagnose: where the gap lies"
    ]  # fmt: skip


def test_steps_never_go_back_and_tell_names_to_those_who_listen():
    class Told(list):
        def say(self, name):
            self.append(name)

        def __call__(self, *state):
            self.append(state[:2])

    told = Told()
    step = Steps(told, ["a", "b", "c"])
    for name in ("a", "c", "b", "another"):
        step(name)
    step.end()
    assert told == [
        "a", (0, 3), "c", (2, 3), "b", (2, 3), "another", (2, 3), (3, 3)
    ]  # fmt: skip


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def seconds(monkeypatch):
    """Let some seconds pass between two looks at the clock."""

    def pass_by(step):
        ticks = itertools.count(0.0, step)
        clock = SimpleNamespace(perf_counter=lambda: next(ticks))
        monkeypatch.setattr(progress, "time", clock)

    return pass_by


def test_a_bar_on_a_terminal_counts_from_the_begin_of_the_work(monkeypatch, seconds):
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    seconds(10.0)
    meter = Meter("laws", "pictures")
    meter(1, 4)
    first = terminal.getvalue()
    # One picture in ten seconds leaves three for thirty.
    assert "1/4 [00:10<00:30" in first
    meter(4, 4)
    assert "4/4" in terminal.getvalue()


def test_a_terminal_shows_the_name_of_a_step_and_how_many_are_done(monkeypatch):
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    step = Steps(progress_of(True, "diagnose"), ["reading", "rivals"])
    step("reading")
    step("rivals")
    assert "diagnose: rivals, 1 of 2 steps done [" in terminal.getvalue()
    step.end()


KEYS = ["event", "what", "unit", "step", "done", "total", "rate", "eta_s", "failures"]


@pytest.mark.parametrize("name", CALLS)
def test_every_long_call_takes_lines_of_json(name, tmp_path, capsys):
    LONG[name](JsonLines(name), tmp_path)
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert all(list(line) == KEYS and line["what"] == name for line in lines)
    assert lines[-1]["done"] == lines[-1]["total"] > 0
    assert lines[-1]["eta_s"] == 0.0


def test_lines_of_json_tell_rate_time_left_steps_and_failures(capsys, seconds):
    seconds(4.0)
    lines = JsonLines("check", "cases")
    lines.fail(2)
    lines(3, 9)
    lines(3, 9, 1.5)
    lines(0, 9)
    steps = JsonLines("diagnose", "steps")
    steps.say("reading")
    steps(1, 4)
    told = [list(json.loads(line).values())[3:] for line in capsys.readouterr().err.splitlines()]
    assert told == [
        [None, 3, 9, 0.75, 8.0, 2], [None, 3, 9, 1.5, 4.0, 2], [None, 0, 9, 0.0, None, 2],
        ["reading", None, None, None, None, None], ["reading", 1, 4, 0.25, None, None],
    ]  # fmt: skip


def test_lines_of_json_are_few(capsys, seconds):
    seconds(0.01)
    lines = JsonLines("verify", "chunks")
    for done in range(1, 101):
        lines(done, 100)
    told = [json.loads(line)["done"] for line in capsys.readouterr().err.splitlines()]
    assert len(told) < 30
    assert told[0] == 1
    assert told[-1] == 100


def test_a_log_gets_a_line_now_and_then(capsys, seconds):
    seconds(4.0)
    meter = Meter("sweep")
    for done in range(1, 11):
        meter(done, 10)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "sweep: 30% of 10 evaluations, 12.0 s, 28 s left"
    assert lines[-1] == "sweep: 100% of 10 evaluations, 40.0 s"
    assert len(lines) == 4


def test_a_notebook_gets_a_bar_although_its_error_stream_is_no_terminal(monkeypatch):
    class Shell:
        config: ClassVar = {"IPKernelApp": {}}

    class Module:
        get_ipython = staticmethod(lambda: Shell())

    bars = []

    class Bar:
        n, total, start_t, ncols = 0, 0, 0.0, 80

        def __init__(self, **_):
            bars.append(self)

        def update(self, count):
            self.n += count

        def close(self):
            pass

    monkeypatch.setitem(sys.modules, "IPython", Module)
    monkeypatch.setattr("tqdm.auto.tqdm", Bar)
    meter = Meter("sweep")
    meter(5, 10, 1.0)
    assert [bar.n for bar in bars] == [5]
    monkeypatch.setitem(sys.modules, "IPython", None)
    Meter("sweep")(5, 10, 1.0)
    assert len(bars) == 1
