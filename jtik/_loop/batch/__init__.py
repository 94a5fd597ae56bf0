"""Batches: their rows, their file, the processes and threads that solve them."""
