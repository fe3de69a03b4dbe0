"""The verifier: problem families, an exact referee, and campaigns that judge `convexperc` and the paper."""
