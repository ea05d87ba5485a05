"""Our own method, which has no parameter."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import adaptive_fairing.core
from adaptive_fairing.core import DenoiseSettings, denoise
from tools.geometry.triangles import Faces, FloatArray

from .peers import Peer, Values


def denoised(vertices: FloatArray, faces: Faces) -> FloatArray:
    """Denoise; the boundary of an open mesh moves, as it does with the peers."""
    return denoise(vertices, faces, DenoiseSettings(boundary="free")).positions


@dataclass(frozen=True)
class OwnScheme(Peer):
    """A method of ours, of the version that the sources of the core have now."""

    @property
    def version(self) -> str:
        """Digest of the sources: any change of the core may change the result."""
        return core_digest()


@cache
def core_digest() -> str:
    """Name the state of the numeric core."""
    content = hashlib.sha256()
    for path in sorted(Path(adaptive_fairing.core.__file__).parent.rglob("*.py")):
        content.update(path.read_bytes())
    return content.hexdigest()[:12]


def _run(vertices: FloatArray, faces: Faces, sweep: Values) -> Iterator[FloatArray]:
    for _ in sweep:
        yield denoised(vertices, faces)


OURS = OwnScheme("Denoise", (), "strength", (1.0,), _run)
"""Denoise as a peer with a grid of one point."""
