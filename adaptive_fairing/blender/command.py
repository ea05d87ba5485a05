"""``blender -c adaptive_fairing INPUT -o OUTPUT ...``: the command line in an installed Blender.

The arguments, the messages and the exit codes are those of ``adaptive-fairing``, because the same
function handles them. The extension has to be enabled; a Blender started with
``--factory-startup`` needs ``--addons bl_ext.user_default.adaptive_fairing`` before ``-c``.
"""

from __future__ import annotations

import bpy

NAME = "adaptive_fairing"

# Handle that Blender returned on registering; it is needed to unregister.
_registered: list[object] = []


def run(arguments: list[str]) -> int:
    """Run the command line with `arguments`; return the exit code that Blender passes on."""
    # Imported late, because enabling the add-on must cost nothing.
    from ..cli import main as cli

    # Blender as a Python module has no program that could be started a second time.
    is_apart = bool(bpy.app.binary_path)
    return cli.main(arguments, worker_command=worker_command(), is_apart=is_apart)


def worker_command() -> list[str]:
    """Command that runs this Blender with this add-on, whatever its preferences say."""
    addon = __package__.rpartition(".adaptive_fairing.")[0]
    return [bpy.app.binary_path, "--addons", addon, "-c", NAME]


def register() -> None:
    """Make the command known to Blender."""
    _registered.append(bpy.utils.register_cli_command(NAME, run))


def unregister() -> None:
    """Withdraw the command."""
    while _registered:
        bpy.utils.unregister_cli_command(_registered.pop())
