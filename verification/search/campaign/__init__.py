"""Solvers on many problems: how many answers are certified, and is any proof false."""
