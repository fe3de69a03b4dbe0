"""Bounds of F* in ball arithmetic, with as many bits as it takes, and exact witnesses."""
