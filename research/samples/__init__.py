"""The project's own sample meshes, modelled as implicit shapes and meshed adaptively."""
