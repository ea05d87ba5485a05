"""Our own methods: auto, which has no parameter, and the paper's schemes over a grid of radii."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import adaptive_fairing.core
from adaptive_fairing.core import DenoiseSettings, FairingSettings, denoise, fair_steps
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale, suggest_tau
from tools.samples.triangles import Faces, FloatArray

from .peers import Peer, Values, spread

STEPS = 4
"""Steps of the paper's schemes, as in its figures."""

RADII = spread(0.2, 4, 16)


def auto(vertices: FloatArray, faces: Faces) -> FloatArray:
    """Denoise with method "auto"; the rim of an open mesh moves, as it does with the peers."""
    return denoise(vertices, faces, DenoiseSettings(boundary="free")).positions


def paper_scheme(
    vertices: FloatArray, faces: Faces, sweep: Values, method: str, density: str = "edge_length"
) -> Iterator[FloatArray]:
    """Run one of the paper's schemes; the sweep is its smoothing radius in local edges."""
    settings = FairingSettings(method=method, density=density, steps=STEPS)
    scale = radius_scale(vertices, faces, settings)
    for radius in sweep:
        options = vars(settings) | {"tau": suggest_tau(scale, radius, STEPS)}
        for step in fair_steps(vertices, faces, FairingSettings(**options)):
            positions = step.positions
        yield positions


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


PAPER_SCHEMES: Sequence[Peer] = tuple(
    OwnScheme(
        f"ours, {name}",
        (),
        "radius",
        RADII,
        paper_scheme,
        {"": {"method": method, "density": density}},
        starts_at_least=False,
        goes_on=False,
    )
    for name, method, density in (
        ("uniform", "uniform", "edge_length"),
        ("timestep, edge length", "adaptive_timestep", "edge_length"),
        ("timestep, area", "adaptive_timestep", "area"),
        ("tensor, area", "adaptive_tensor", "area"),
    )
)
"""The schemes of the paper."""


def _run_auto(vertices: FloatArray, faces: Faces, sweep: Values) -> Iterator[FloatArray]:
    for _ in sweep:
        yield auto(vertices, faces)


OURS = OwnScheme("ours, auto", (), "strength", (1.0,), _run_auto)
"""Method "auto" as a peer with a grid of one point."""
