"""The paper's algorithm in every reading."""
