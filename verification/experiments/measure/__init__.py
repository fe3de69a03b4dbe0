"""What is measured on the pictures under one configuration."""
