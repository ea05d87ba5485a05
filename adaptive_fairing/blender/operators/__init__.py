"""Operators, one file each, and what they have in common: the modal run, polls."""
