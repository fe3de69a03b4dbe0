"""What checks a step: real arithmetic, polynomials, matrices, propositional formulas."""
