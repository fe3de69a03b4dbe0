"""From answers to a label that is proved or not claimed."""
