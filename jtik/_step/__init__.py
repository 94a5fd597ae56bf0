"""One update as one compiled function: the fused step, the symbolic problem, the active set, stopping. Not public."""
