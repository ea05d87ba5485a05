"""Operators, one file each, and their common parts: the modal run, polls."""
