"""Simulated motion: trajectories of one segment, whole robots, replays of measured drives."""
