"""Loop's limit surface itself: refined meshes, exact normals and curvature, creases."""
