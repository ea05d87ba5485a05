"""Entry point of the Blender extension: Blender wants it beside the manifest.

Nothing is imported until Blender enables the extension, so that tools which see the repository
root as a package (pytest does) can load this file without Blender.
"""


def register() -> None:
    """Register the add-on with Blender."""
    from .adaptive_fairing import blender

    blender.register()


def unregister() -> None:
    """Take back everything that `register` did."""
    from .adaptive_fairing import blender

    blender.unregister()
