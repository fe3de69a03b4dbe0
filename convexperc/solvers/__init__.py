"""One file a method; each answers a normalised problem and judges nothing."""
