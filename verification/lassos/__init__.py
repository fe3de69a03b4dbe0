"""Lasso-family problems drawn from a seed, an exact referee, and the campaign that judges certificates."""
