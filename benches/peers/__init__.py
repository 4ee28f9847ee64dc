"""The same work in locosweep and in what its users would write instead."""
