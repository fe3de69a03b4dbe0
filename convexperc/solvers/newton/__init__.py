"""Proximal Newton on the reduced problem."""
