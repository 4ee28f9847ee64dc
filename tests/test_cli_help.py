"""Help of commands: short, with an example that can be typed; lists of what the registry has."""

import json
import shlex
import subprocess
import sys

import click
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.cli.commands import COMMANDS, command


def help_of(name):
    found = command(name)
    context = click.Context(found, info_name=f"locosweep {name}", max_content_width=100)
    return found.get_help(context)


@pytest.mark.parametrize("name", COMMANDS)
def test_what_a_command_does_is_told_alike_by_the_whole_and_by_itself(name):
    found = command(name)
    assert found.name == name
    assert COMMANDS[name].does == found.get_short_help_str(200)


def test_the_help_of_the_whole_imports_no_command(capsys):
    assert main(["--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for name, entry in COMMANDS.items():
        assert f"{name} {entry.does.rstrip('.')}" in said
    code = (
        "import sys; from locosweep.cli import main; main(['--help']); "
        "sys.exit('locosweep.cli.options' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_a_screen_or_two_and_ends_with_an_example_that_is_understood(name):
    text = help_of(name)
    assert text.count("\n") < 80
    assert "Example:" in text
    shown = text[text.index("Example:") + len("Example:") :].split("\n\n")[0].replace("\\\n", " ")
    assert shlex.split(shown) == shlex.split(COMMANDS[name].example)
    arguments = shlex.split(COMMANDS[name].example)
    assert arguments[:2] == ["locosweep", name]
    with command(name).make_context(name, arguments[2:], obj=arguments[1:]):
        pass


def test_effects_are_listed_and_explained(capsys):
    assert main(["effects"]) == 0
    listed = capsys.readouterr().out
    assert all(effect.name in listed for effect in ls.effects())
    assert main(["effects", "drive_saturation"]) == 0
    one = capsys.readouterr().out
    for part in ("the drive gives no more than a limit", "F_max", "N", "largest drive force"):
        assert part in one
    assert main(["effects", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == [effect.name for effect in ls.effects()]


def test_gaits_are_listed(capsys):
    assert main(["gaits"]) == 0
    assert all(gait.name in capsys.readouterr().out for gait in ls.gaits()[:1])
    assert main(["gaits", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == [gait.name for gait in ls.gaits()]


def test_first_outputs_say_why_they_differ(tmp_path, capsys):
    robot = tmp_path / "robot.toml"
    robot.write_text("[robot]\nsegments = 4\n[surface]\nmu_static = 0.5\nmu_coulomb = 0.3\n"
                     "[drive]\nlimit = 0.85\n")  # fmt: skip
    assert main(["optimum", "--robot", str(robot)]) == 0
    best = " ".join(capsys.readouterr().out.split())
    assert "an inner segment is pushed by one joint and pulled by the next" in best
    assert "as a real number, which may lie below all whole ones" in best
    gait = tmp_path / "gait.toml"
    gait.write_text('format = "locosweep.gait/1"\n[gait]\nschedule = "single"\n'
                    'robot = "robot.toml"\ncycles = 2\ndwell = 0.05\nbreak_away = 0\n')  # fmt: skip
    assert main(["gait", str(gait), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out.splitlines()[-1]
    speed = float(ls.sweep("mean_velocity", robot=ls.load_robot(robot)).values)
    assert f"{1000 * speed:.4g} mm/s" in said
    assert "here an inner one has two, and no segment rests, here 0.05 s" in said
    assert said in (tmp_path / "out" / "summary.md").read_text()
