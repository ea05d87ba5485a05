"""The paper's figures, made again with the project's own meshes and its own solver."""
