"""The paper's experiments again: simulated scenes and photographs, paired comparisons."""
