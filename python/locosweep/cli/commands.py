"""All commands: where each is defined, what it does, and an example of it.

``locosweep --help`` reads them here and imports none, which would take twice as long.
"""

from __future__ import annotations

from importlib import import_module
from typing import NamedTuple

import click


class Entry(NamedTuple):
    """One command."""

    home: str
    """Module of this folder that defines it."""
    does: str
    """What it does: the first sentence of its own help."""
    example: str


COMMANDS: dict[str, Entry] = {
    "heatmap": Entry(
        "heatmap",
        "Sweep a QUANTITY over two parameters and draw it.",
        "locosweep heatmap mean_velocity --x slope_deg=0:25:100 --y mu_static=0.1:1:100 "
        "--set mu_coulomb=0.3 --best-over segments=2:64 --out map.png",
    ),
    "explore": Entry(
        "explore",
        "Write a page on which a sweep is looked at: two axes as a map, sliders for the others.",
        "locosweep explore mean_velocity --axis mu_static=0.3:0.6:31 --axis "
        "slope_deg=0:20:41 --axis segments=2:20 --set mu_coulomb=0.3 --out page.html",
    ),
    "sweep": Entry(
        "sweep",
        "Evaluate quantities on a grid and write a Parquet file or a run folder.",
        "locosweep sweep mean_velocity peak_power --axis segments=2:20 --axis "
        "slope_deg=0:20:41 --set mu_static=0.5 --set mu_coulomb=0.3 --out sweep.parquet",
    ),
    "status": Entry(
        "status",
        "Tell what of a run folder is done, by whom, and with which statuses.",
        "locosweep status run",
    ),
    "verify": Entry(
        "verify",
        "Read all files of a run folder and say which were altered; the exit code is then 1.",
        "locosweep verify run --repair",
    ),
    "merge": Entry(
        "merge",
        "Copy the finished chunks of run folders of one sweep into one.",
        "locosweep merge part0 part1 --out run",
    ),
    "export": Entry(
        "export",
        "Write the long table of a run folder: axes, outputs and statuses, a row for each cell.",
        "locosweep export run --out table.parquet",
    ),
    "simulate": Entry(
        "simulate",
        "Simulate one segment under a friction law and a drive.",
        "locosweep simulate --law stribeck --drive sine --set drive_amplitude=2 --set "
        "mu_static=0.5 --set mu_coulomb=0.3 --out motion.csv --plot motion.png",
    ),
    "gait": Entry(
        "gait",
        "Simulate one whole robot through its gait.",
        "locosweep gait examples/gait_wave.toml --out out/gait_wave",
    ),
    "init": Entry(
        "init",
        "Read a LOG as it was exported, and write what a diagnosis takes.",
        "locosweep init rig.csv --out rig --set mass=0.27 --set mu_coulomb=0.3",
    ),
    "screen": Entry(
        "screen",
        "Say which effects could explain a gap between measured RUNS and their model.",
        "locosweep screen gap/runs.csv --nominal gap/nominal.toml",
    ),
    "diagnose": Entry(
        "diagnose",
        "Say where measured RUNS leave their model, which effect causes it, how far it shrinks.",
        "locosweep diagnose gap/runs.csv --nominal gap/nominal.toml --out report",
    ),
    "distinguish": Entry(
        "distinguish",
        "Say before anything is measured which effects an experiment could tell apart.",
        "locosweep distinguish gap/nominal.toml --drive pulse --set drive_amplitude=0.8 "
        "--plot matrix.png",
    ),
    "friction": Entry(
        "friction",
        "Fit friction laws to measured motion and friction force, and choose one.",
        "locosweep friction measured.csv --unit x=mm --out friction",
    ),
    "blind-check": Entry(
        "blind_check",
        "Diagnose cases whose cause is withheld, and say how often that was right.",
        "locosweep blind-check --cases 4 --seed 1 --out check",
    ),
    "optimum": Entry(
        "optimum",
        "Find the best number of segments, and why the others lose.",
        "locosweep optimum --robot examples/locosnake.toml --set slope_deg=5",
    ),
    "propagate": Entry(
        "propagate",
        "Say how a quantity is distributed when parameters are known as distributions.",
        "locosweep propagate mean_velocity --axis segments=2:12 --set slope_deg=5 --set "
        "stroke=0.02 --unknown mu_static=0.4:0.6 --unknown mu_coulomb/mu_static=0.5:0.9 "
        "--need '>= 0.06'",
    ),
    "sensitivity": Entry(
        "sensitivity",
        "Say which unknown parameter makes how much of a quantity's variance: Sobol indices.",
        "locosweep sensitivity mean_velocity --set segments=5 --set mu_static=0.6 --unknown "
        "mu_coulomb=normal:0.3:0.03 --unknown slope_deg=normal:5:1",
    ),
    "plot": Entry(
        "plot",
        "Draw a result that was saved, or a run folder.",
        "locosweep plot sweep.parquet --x slope_deg --y segments --value peak_power --out "
        "power.svg",
    ),
    "reproduce": Entry(
        "reproduce",
        "Draw the paper's figures and check the numbers it states.",
        "locosweep reproduce all --out paper",
    ),
    "quantities": Entry(
        "registry_lists",
        "List the quantities, or tell everything about one.",
        "locosweep quantities mean_velocity",
    ),
    "parameters": Entry(
        "registry_lists",
        "List the parameters: unit, default, what is allowed, key in a robot file.",
        "locosweep parameters drive_limit",
    ),
    "laws": Entry(
        "laws",
        "List the friction laws, tell everything about one, or draw them.",
        "locosweep laws stribeck --out laws",
    ),
    "drives": Entry(
        "registry_lists",
        "List the drives of a simulation, or tell everything about one.",
        "locosweep drives sine",
    ),
    "effects": Entry(
        "registry_lists",
        "List the effects that a diagnosis may name, or tell everything about one.",
        "locosweep effects lubricant_buildup",
    ),
    "gaits": Entry(
        "registry_lists",
        "List the gaits that a whole robot can be simulated with.",
        "locosweep gaits --json",
    ),
    "methods": Entry(
        "registry_lists",
        "List the methods of simulation.",
        "locosweep methods",
    ),
    "reductions": Entry(
        "registry_lists",
        "List the ways to fold an axis away.",
        "locosweep reductions",
    ),
    "reasons": Entry(
        "registry_lists",
        "List the reasons for which a point has no value.",
        "locosweep reasons",
    ),
}
"""By name, in the order of their help."""


class Commands(click.Group):
    """The commands of `COMMANDS`, each imported when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return their names."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command; None if there is none of that name."""
        return command(cmd_name) if cmd_name in COMMANDS else super().get_command(ctx, cmd_name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write all names with what they do."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl([(name, entry.does.rstrip(".")) for name, entry in COMMANDS.items()])


def command(name: str) -> click.Command:
    """Import a command, and give its help the example at its end."""
    found: click.Command = getattr(
        import_module(f"locosweep.cli.{COMMANDS[name].home}"), name.replace("-", "_")
    )
    found.epilog = epilog(name)
    return found


def epilog(name: str) -> str:
    r"""Return the example of a command as its help shows it, in lines that are not filled anew.

    Examples
    --------
    >>> from locosweep.cli.commands import epilog
    >>> epilog("methods")
    '\x08\nExample:\n  locosweep methods'
    """
    lines, line = [], " "
    for word in COMMANDS[name].example.split(" "):
        # An option stays with its value.
        if len(line) + len(word) > 78 and word.startswith("--"):
            lines.append(f"{line} \\")
            line = "     "
        line += f" {word}"
    return "\n".join(["\b", "Example:", *lines, line])
