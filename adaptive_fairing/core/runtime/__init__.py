"""Runtime of the numerics: precision, threads, memory of the system."""
