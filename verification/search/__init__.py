"""The search: checks on problems that Hypothesis draws, in shards that can be resumed and joined in any order."""
