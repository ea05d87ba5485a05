"""What `auto` found and chose: for the user, and for other frames of the same surface."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..mesh.normals import triangle_normals, unit_vectors
from ..mesh.topology import TriangleTopology
from .filter_rounds import KEEPS_CREASES
from .local_frame import LocalFrame

FloatArray = NDArray[np.float64]

# Strengths relative to the chosen one, as factors of the estimated noise.
STRENGTHS = (0.5, 0.75, 1.0, 1.5, 2.0)
CHOSEN = STRENGTHS.index(1.0)

# An edge is a crease if the normals beside it differ by this many radians; and a mesh with creases
# has at least such a share of them.
CREASE_ANGLE = 0.6
CREASE_SHARE = 0.02


@dataclass(frozen=True)
class AutoPlan:
    """How the filters were mixed on one mesh, for other frames of the same surface.

    Attributes
    ----------
    noise : (n,)
        Level at the solver's vertices, in local edge lengths; 0 where it was not judged.
    pilots : sequence of (k, n), mixtures : (s, k, n)
        Shares of the filters so far at each vertex after each round but the last, and of all of
        them for each strength.
    kept : (s,)
        Share of the noise that each mixture keeps.
    """

    noise: FloatArray
    pilots: tuple[FloatArray, ...]
    mixtures: FloatArray
    kept: FloatArray


@dataclass(frozen=True)
class AutoEstimate:
    """What `auto` found and chose.

    Attributes
    ----------
    strength : float
        Factor of the estimated noise that the positions are meant for.
    noise : float
        Median standard deviation of the noise along the normals, in local edge lengths.
    noise_length : float
        The same in object units.
    radius : float
        Smoothing radius: of the Gaussian filter that keeps the same share of white noise, in local
        edge lengths.
    sharp_share : float
        Share of the filters that keep creases in what was removed, 0 to 1.
    crease_share : float
        Share of creases among the edges of the faired mesh, 0 to 1.
    is_sharp : bool
        Whether creases were asked for; or else whether the faired mesh has a share of them that
        smooth meshes do not have.
    is_chosen : bool
        Whether this is the strength that was asked for.
    plan : AutoPlan
        For other frames of the same surface.
    """

    strength: float
    noise: float
    noise_length: float
    radius: float
    sharp_share: float
    crease_share: float
    is_sharp: bool
    is_chosen: bool
    plan: AutoPlan = field(repr=False, compare=False)


def estimate_of(
    plan: AutoPlan,
    index: int,
    frame: LocalFrame,
    crease_share: float,
    *,
    strength: float,
    features: str,
) -> AutoEstimate:
    """Sum up what was found and chosen for STRENGTHS[index] times `strength`."""
    shares, kept = plan.mixtures[index], float(np.clip(plan.kept[index], 1e-6, 1))
    judged = plan.noise > 0
    level = plan.noise[judged] if judged.any() else np.zeros(1)
    length = level * frame.spacing[judged] if judged.any() else np.zeros(1)
    sharp = shares[KEEPS_CREASES] if len(shares) else shares
    total = float(shares.sum())
    sharp_share = float(sharp.sum()) / total if total > 0 else 0.0
    has_creases = crease_share > CREASE_SHARE
    # A Gaussian of standard deviation r keeps cell / (2 π r²) of white noise, with the area
    # √3/2 of a vertex's cell; the 1 makes the radius of doing nothing 0.
    radius = np.sqrt(np.sqrt(3) / (4 * np.pi) * (1 / kept - 1))
    return AutoEstimate(
        strength=STRENGTHS[index] * strength,
        noise=float(np.median(level)),
        noise_length=float(np.median(length)),
        radius=float(radius),
        sharp_share=sharp_share,
        crease_share=crease_share,
        is_sharp=has_creases if features == "auto" else features == "sharp",
        is_chosen=index == CHOSEN,
        plan=plan,
    )


def crease_share_of(topology: TriangleTopology, positions: FloatArray) -> float:
    """Share of the inner edges of a mesh that are creases."""
    normal = unit_vectors(triangle_normals(positions, topology.triangles))
    side = np.flatnonzero(topology.twin >= 0)
    cosine = np.einsum("ed,ed->e", normal[side // 3], normal[topology.twin[side] // 3])
    return float(np.mean(cosine < np.cos(CREASE_ANGLE))) if len(side) else 0.0
