"""A run from input to output: of a file, of an object, of many frames, in a worker process."""
