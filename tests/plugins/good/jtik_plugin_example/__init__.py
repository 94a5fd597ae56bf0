"""An example of a plugin: a criterion, a strategy and a secondary term, found by jtik through entry points."""
