"""A loss and the weight that a loop uses for it: formulas, foreign functions, and libraries of them."""
