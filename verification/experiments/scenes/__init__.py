"""The pictures of the experiments: simulated scenes and photographs, and what obstructs them."""
