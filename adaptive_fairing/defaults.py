"""What the panel and the command line start with; the core's own defaults are in its settings."""

from __future__ import annotations

METHOD = "auto"
"""Method, by its name in `FairingSettings`."""
