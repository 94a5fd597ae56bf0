"""Commit to an attempt: check it, time it, write it for a controller."""
