"""One run of the verifier: everything that a judgement needs."""
