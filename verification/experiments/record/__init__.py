"""The record of the experiments: made, written, and read back."""
