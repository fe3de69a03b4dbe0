"""The record of the experiments: judged from what was measured, written, and read back."""
