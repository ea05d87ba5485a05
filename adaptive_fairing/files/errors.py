"""Errors of files that cannot be read or written."""

from ..core.errors import FairingError


class FileError(FairingError):
    """A file that cannot be read or written; the message is one line."""
