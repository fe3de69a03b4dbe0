"""The experiments in the report: tables, figures and contact sheets, from a stored record alone."""
