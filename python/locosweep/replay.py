"""Replays of measured runs, under the path that scripts of users import."""

from locosweep.simulation.replay import effect, effects, replay_runs

__all__ = ["effect", "effects", "replay_runs"]
