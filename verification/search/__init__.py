"""The search: checks on problems that Hypothesis draws, in shards that can be resumed in any order."""
