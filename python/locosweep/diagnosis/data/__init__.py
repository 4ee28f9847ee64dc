"""What a diagnosis reads off the runs before any model is fitted."""
