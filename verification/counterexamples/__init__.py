"""Counterexamples to the paper's claims: records in exact numbers, and what confirms each kind."""
