"""A class that is no strategy."""


class NoStrategy:
    """Neither a Strategy nor a Criterion nor a SecondaryTerm."""
