"""Timings of the library beside other solvers, all held to one gap by one judge."""
