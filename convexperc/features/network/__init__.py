"""Features of a pretrained network: its weights, read without PyTorch, and its graph, run by OpenCV."""
