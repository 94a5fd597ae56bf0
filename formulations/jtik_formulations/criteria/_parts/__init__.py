"""What several criteria share: ranges of joints, rows of a task's Jacobian, checks of arguments."""
