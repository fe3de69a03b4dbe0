"""X, o, the modalities and the lambdas; F; exact scaling; what all templates of one set of views share."""
