"""The method derived a second time, over the rationals and in balls, with no formula of the library."""
