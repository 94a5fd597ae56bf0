"""What an operator can ask for: edits, their JSON, and what each does."""
