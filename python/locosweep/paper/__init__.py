"""The paper's figures, numbers and sim-to-real gap, reproduced."""
