"""What noise a mesh has: its level, its correlation, and what only looks like noise."""
