"""Faults to plant on purpose: a verifier is worth what it catches."""
