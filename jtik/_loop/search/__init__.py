"""The search: attempts, where they begin, where they end, and which arrival is returned."""
