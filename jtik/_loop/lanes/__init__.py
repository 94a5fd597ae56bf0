"""Searches in lanes: several targets, or several starts, side by side in the registers of one processor."""
