"""Answers with their proof: one template, all templates of a set of views, intervals of the weights."""
