"""The report: stored evidence and its verdicts as HTML, Markdown, JSON and JUnit. It computes nothing.

`write` writes all files of a report; `diff` compares two.
"""
