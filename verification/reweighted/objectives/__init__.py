"""Sums of losses of affine expressions, and certified optima of those that are convex."""
