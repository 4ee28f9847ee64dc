"""Dynamics of friction-driven bodies in what users would pick instead of locosweep."""
