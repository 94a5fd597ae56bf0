"""Attempts: recorded, branched, measured and compared."""
