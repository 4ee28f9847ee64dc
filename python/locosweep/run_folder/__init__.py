"""Run folders: sweeps that are stored chunk by chunk, of any size, and resumed."""
