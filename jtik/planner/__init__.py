"""The interactive trajectory planner."""
