"""The arguments, checked once for all tests of a process: that takes seconds, and depends on nothing."""

from functools import cache

from verification.proofs.arguments import all_arguments

checked_once = cache(all_arguments)
