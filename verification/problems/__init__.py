"""Problems by family, from seeded numbers or from Hypothesis."""
