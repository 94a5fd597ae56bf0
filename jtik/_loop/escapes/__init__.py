"""Escapes from saddle points and maxima, and Newton's method for levels of priority that are out of reach."""
