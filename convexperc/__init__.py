"""Convex multi-robot perception: certified recognition of an object from several robots' views."""
