"""Experiment design: which run would tell apart what the data leave open."""
