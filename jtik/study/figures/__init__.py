"""Figures of a study, one in each file: functions from a Comparison to a matplotlib figure."""
