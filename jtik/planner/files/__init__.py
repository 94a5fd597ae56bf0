"""What is on disk: journals, snapshots, recovery, and the file of a plan."""
