"""Measured runs, under the path that scripts of users import."""

from locosweep.files.runs import CHANNELS, Run, load_runs, runs_from_frame

__all__ = ["CHANNELS", "Run", "load_runs", "runs_from_frame"]
