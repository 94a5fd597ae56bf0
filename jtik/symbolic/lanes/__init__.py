"""Functions as C on vectors, one lane for each of several inputs: their operations, mathematics and source."""
