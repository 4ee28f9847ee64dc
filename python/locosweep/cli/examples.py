"""An example of every command, at the end of its help."""

from __future__ import annotations

EXAMPLES = {
    "heatmap": "locosweep heatmap mean_velocity --x slope_deg=0:25:100 --y mu_static=0.1:1:100 "
    "--set mu_coulomb=0.3 --best-over segments=2:64 --out map.png",
    "explore": "locosweep explore mean_velocity --axis mu_static=0.3:0.6:31 "
    "--axis slope_deg=0:20:41 --axis segments=2:20 --set mu_coulomb=0.3 --out page.html",
    "sweep": "locosweep sweep mean_velocity peak_power --axis segments=2:20 "
    "--axis slope_deg=0:20:41 --set mu_static=0.5 --set mu_coulomb=0.3 --out sweep.parquet",
    "status": "locosweep status run",
    "verify": "locosweep verify run --repair",
    "merge": "locosweep merge part0 part1 --out run",
    "export": "locosweep export run --out table.parquet",
    "simulate": "locosweep simulate --law stribeck --drive sine --set drive_amplitude=2 "
    "--set mu_static=0.5 --set mu_coulomb=0.3 --out motion.csv --plot motion.png",
    "gait": "locosweep gait examples/gait_wave.toml --out out/gait_wave",
    "init": "locosweep init rig.csv --out rig --set mass=0.27 --set mu_coulomb=0.3",
    "screen": "locosweep screen gap/runs.csv --nominal gap/nominal.toml",
    "diagnose": "locosweep diagnose gap/runs.csv --nominal gap/nominal.toml --out report",
    "distinguish": "locosweep distinguish gap/nominal.toml --drive pulse "
    "--set drive_amplitude=0.8 --plot matrix.png",
    "friction": "locosweep friction measured.csv --unit x=mm --out friction",
    "blind-check": "locosweep blind-check --cases 4 --seed 1 --out check",
    "optimum": "locosweep optimum --robot examples/locosnake.toml --set slope_deg=5",
    "propagate": "locosweep propagate mean_velocity --axis segments=2:12 --set slope_deg=5 "
    "--set stroke=0.02 --unknown mu_static=0.4:0.6 --unknown mu_coulomb/mu_static=0.5:0.9 "
    "--need '>= 0.06'",
    "sensitivity": "locosweep sensitivity mean_velocity --set segments=5 --set mu_static=0.6 "
    "--unknown mu_coulomb=normal:0.3:0.03 --unknown slope_deg=normal:5:1",
    "plot": "locosweep plot sweep.parquet --x slope_deg --y segments --value peak_power "
    "--out power.svg",
    "reproduce": "locosweep reproduce all --out paper",
    "quantities": "locosweep quantities mean_velocity",
    "parameters": "locosweep parameters drive_limit",
    "laws": "locosweep laws stribeck --out laws",
    "drives": "locosweep drives sine",
    "effects": "locosweep effects lubricant_buildup",
    "gaits": "locosweep gaits --json",
    "methods": "locosweep methods",
    "reductions": "locosweep reductions",
    "reasons": "locosweep reasons",
}
"""By the name of the command."""


def epilog(name: str) -> str | None:
    r"""Return the example of a command as its help shows it, in lines that are not filled anew.

    Examples
    --------
    >>> from locosweep.cli.examples import epilog
    >>> epilog("methods")
    '\x08\nExample:\n  locosweep methods'
    """
    if name not in EXAMPLES:
        return None
    lines, line = [], " "
    for word in EXAMPLES[name].split(" "):
        # An option stays with its value.
        if len(line) + len(word) > 78 and word.startswith("--"):
            lines.append(f"{line} \\")
            line = "     "
        line += f" {word}"
    return "\n".join(["\b", "Example:", *lines, line])
