"""A session: the loop that owns the solver, its state, and what it publishes."""
