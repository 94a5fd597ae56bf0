"""Figures of a study: one a file, each a function from a Comparison to a matplotlib figure."""
