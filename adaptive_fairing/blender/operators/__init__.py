"""Operators, one file each, and what they share: the modal run, polls."""
