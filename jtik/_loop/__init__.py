"""What runs around the compiled step: search, restarts, the loop in C, batches, tracking, diagnosis. Not public."""
