"""Exit statuses of the program."""

DONE = 0
COULD_NOT = 1
"""Failure because of a file, a mesh or the solver."""

WRONG_ARGUMENTS = 2
INTERRUPTED = 130
