"""What is claimed, what is known of it, and the one rule between the two."""
