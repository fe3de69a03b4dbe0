"""Bounds of F* in float64, rounding included, at any point from anywhere; knows no solver."""
