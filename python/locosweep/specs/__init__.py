"""Sweeps, simulations and gaits as TOML files that read back to the same bits."""
