"""Kernels: plain functions that run interpreted or as machine code, to the same bits."""
