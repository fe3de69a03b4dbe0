"""What is measured on the pictures, under one interpretation and over all of them."""
