"""The report: stored evidence and its verdicts as HTML, Markdown, JSON and JUnit. It computes nothing.

`write.files` renders all files of a report, `write.store` stores them; `diff` compares two.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
