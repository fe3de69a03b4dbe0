"""Checks: one file a kind of claim, each a function from a problem to observations."""
