"""A mesh made ready for a solve: the prepared tables, and what is wrong with the mesh."""
