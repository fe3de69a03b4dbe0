"""Arguments for the claims, step by step, each step checked by a machine or cited."""
