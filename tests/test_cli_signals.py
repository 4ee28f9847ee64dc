"""Commands that are told to end: exit codes, no orphans, nothing half-written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from locosweep.cli import main, signals

pytestmark = [
    pytest.mark.whole,
    pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no SIGHUP here"),
]
LONG = [
    "sweep", "mean_velocity", "--axis", "mu_static=0.31:1:400", "--axis", "slope_deg=0:20:400",
    "--axis", "viscous=0.1:2:40", "--axis", "segments=2:4001", "--over", "segments",
    "--reduce", "mean", "--set", "mu_coulomb=0.3", "--dtype", "float32", "--out", "r.parquet",
    "--threads", "1",
]  # fmt: skip


def _until_listening(process: subprocess.Popen[bytes]) -> None:
    """Wait until a process catches SIGHUP, as the kernel tells, and a moment for it to begin."""
    for _ in range(600):
        assert process.poll() is None
        status = Path(f"/proc/{process.pid}/status").read_text()
        caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
        if int(caught.split()[1], 16) >> (signal.SIGHUP - 1) & 1:
            break
        time.sleep(0.05)
    time.sleep(0.5)


def test_a_hung_up_sweep_leaves_nothing(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "locosweep", *LONG], cwd=tmp_path, stderr=subprocess.PIPE
    )
    _until_listening(process)
    process.send_signal(signal.SIGHUP)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 129
    assert err == b""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("module", ["commands", "registry_lists"])
def test_ctrl_c_while_the_command_is_imported_ends_it_in_one_line(
    module: str, tmp_path: Path
) -> None:
    script = (
        "import os, signal, sys; from locosweep.__main__ import main\n"
        "class Pressed:\n"
        "    def find_spec(self, name, *rest):\n"
        f"        if name == 'locosweep.cli.{module}': os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Pressed()); sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "quantities"], cwd=tmp_path, capture_output=True,
        timeout=60, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"locosweep: interrupted\n")


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_an_end_that_is_lost_in_a_library_comes_again(name: str, code: int, tmp_path: Path) -> None:
    """Raised while an object is given up, an exception is lost; cleaning up is not cut by it."""
    script = (
        "import click, os, signal, sys, time; from locosweep import cli\n"
        "class Lost:\n"
        f"    def __del__(self): os.kill(os.getpid(), signal.{name}); time.sleep(0.01)\n"
        "@click.command()\n"
        "def lose():\n"
        "    sys.unraisablehook = lambda _: None\n"
        "    try:\n"
        "        lost = Lost(); del lost\n"
        "        for _ in range(500): time.sleep(0.01)\n"
        "        print('to the end')\n"
        "    finally:\n"
        "        time.sleep(0.3); print('cleaned up', flush=True)\n"
        "cli.group.add_command(lose); sys.argv[1:] = ['lose']; sys.exit(cli.main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    said = "locosweep: interrupted\n" if code == 130 else ""
    assert (done.returncode, done.stdout, done.stderr) == (code, "cleaned up\n", said)


@pytest.mark.usefixtures("ctrl_c")
def test_a_command_gives_the_signals_back(capsys: pytest.CaptureFixture[str]) -> None:
    taken = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGALRM)
    before = [signal.getsignal(number) for number in taken]
    for arguments in (["reasons"], ["no-such-command"]):
        main(arguments)
        assert [signal.getsignal(number) for number in taken] == before
    capsys.readouterr()


@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 15), ("SIGHUP", 1)])
def test_a_signal_after_the_command_ends_the_process_by_itself(
    name: str, code: int, tmp_path: Path
) -> None:
    """Not by SIGALRM, of a timer that nobody heeds where the interpreter ends."""
    script = (
        "import atexit, os, signal, sys, time; from locosweep.cli import main\n"
        "class Slow:\n"
        "    def __del__(self): time.sleep(0.3)\n"
        f"signal.signal(signal.{name}, signal.SIG_DFL)\n"
        "sys.modules['slow'] = Slow()\n"
        f"atexit.register(lambda: (os.kill(os.getpid(), signal.{name}), time.sleep(0.2)))\n"
        "sys.argv[1:] = ['reasons']; sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (-code, "")


def test_what_ignores_hanging_up_goes_on(tmp_path: Path) -> None:
    """As under nohup."""
    script = (
        "import os, signal; signal.signal(signal.SIGHUP, signal.SIG_IGN);"
        "from locosweep.cli import main; from locosweep.cli.signals import listen;"
        "listen(); os.kill(os.getpid(), signal.SIGHUP); raise SystemExit(main(['quantities']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.usefixtures("ctrl_c")
def test_a_second_ctrl_c_does_not_cut_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    ended: list[int] = []
    monkeypatch.setattr(signals.os, "_exit", ended.append)
    signals.listen()
    assert not signals.pressed()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert signals.pressed()
    signal.raise_signal(signal.SIGINT)
    assert ended == []
    signal.raise_signal(signal.SIGINT)
    assert ended == [130]
    signals.listen()
    assert not signals.pressed()


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGKILL, -9)],
)
def test_a_blind_check_leaves_no_orphans(number: signal.Signals, code: int, tmp_path: Path) -> None:
    out = tmp_path / "check"
    # A session of its own: what is alive of it afterwards is an orphan.
    process = subprocess.Popen(
        [sys.executable, "-m", "locosweep", "blind-check", "--cases", "4", "--seed", "3",
         "--quiet", "--threads", "2", "--out", str(out)],
        cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True, text=True,
    )  # fmt: skip
    try:
        wait_for(lambda: len(list(workers(process.pid))) == 2)
        time.sleep(3.0)
        begin = time.perf_counter()
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        process.wait(timeout=20)
        ended = time.perf_counter() - begin
        wait_for(lambda: not list(workers(process.pid)))
    finally:
        left = list(workers(process.pid))
        for pid in left:
            os.kill(pid, signal.SIGKILL)
        process.kill()
    _, err = process.communicate(timeout=20)
    assert process.returncode == code
    assert ended < 4.0
    if number != signal.SIGKILL:
        assert err == ("locosweep: interrupted\n" if number == signal.SIGINT else "")


def workers(session: int) -> list[int]:
    """Return the processes of a session that were started by another one of it."""
    rows = subprocess.run(
        ["ps", "-ww", "-eo", "pid=,sid=,args="], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    found = [row.split(None, 2) for row in rows]
    return [int(pid) for pid, sid, text in found if sid == str(session) and "spawn_main" in text]


def wait_for(condition: object, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():  # type: ignore[operator]
            return
        time.sleep(0.1)
    raise AssertionError("did not come true")
