"""Data checks, noise, regimes and the validation split, before any model is fitted."""
