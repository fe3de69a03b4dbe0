"""Reweighted loops: their exact updates, what is decided of them, and the instances that show it."""
