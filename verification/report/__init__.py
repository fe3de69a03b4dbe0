"""The report: stored evidence and its verdicts as HTML, Markdown, JSON and JUnit. It computes nothing.

`write.files` renders all files of a report, `write.store` stores them; `diff` compares two.
"""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
