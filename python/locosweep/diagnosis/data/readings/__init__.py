"""Faults of readings, found before any model is fitted: a module for each kind of fault."""
