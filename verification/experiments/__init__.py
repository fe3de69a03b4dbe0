"""The paper's experiments again: simulated scenes and photographs, many readings, paired comparisons."""
