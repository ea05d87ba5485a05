"""Runs from input to output: of a file, an object, many frames, or in a worker process."""
