"""Model selection: which set of effects the runs ask for, and how sure that is."""
