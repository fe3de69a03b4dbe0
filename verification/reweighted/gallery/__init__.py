"""Reweighted loops of the literature in our words: objective, update as printed, what repairs it."""
