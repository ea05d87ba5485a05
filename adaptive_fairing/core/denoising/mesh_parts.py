"""Connected parts of a mesh, each with its own noise and its own best filters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.sparse import csgraph

from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray, RealArray
from ..runtime.threads import side_by_side
from .mixture import Mixture, least_risk_coefficients
from .noise.clean_detail import CleanDetail
from .noise.contrast import Contrast
from .noise.level import MEDIAN_ERROR, scan_level, variance_law
from .noise.noisy_surface import NoisySurface
from .noise.spikes import is_impulsive
from .noise.unevenness import unevenness
from .noise_model import VarianceLaw, certainty
from .parameters import parameters
from .triangle_surface import TriangleSurface


class NoiseFound(NamedTuple):
    """Noise of a mesh.

    Attributes
    ----------
    level : (n,)
        Standard deviation in local edge lengths; 0 where there is none, or none was judged.
    impulsive : (n,) bool
        Where the noise is that of single vertices.
    roughness : (n,)
        Level from the roughness alone; 0 where it was not judged.
    notes : tuple of str
        Reason why there is nothing to do, if so.
    unevenness : (n,), optional
        Factor in `level` of noise that is stronger in one place than in another.
    certainty : (p,) or float
        How certainly that is noise in each part, 0 to 1: so much of it is removed.
    """

    level: FloatArray
    impulsive: BoolArray
    roughness: FloatArray
    notes: tuple[str, ...] = ()
    unevenness: FloatArray | None = None
    certainty: FloatArray | float = 1.0


class MeshParts:
    """Connected parts that are judged separately; small ones are judged together.

    Parameters
    ----------
    frame : TriangleSurface
        Slightly smoothed surface.
    is_still : (n,) bool
        Vertices from which nothing is judged.

    Attributes
    ----------
    is_counted : (n,) bool
        Vertices to judge from.
    may_move : (n,) bool
        Counted vertices, and those on boundaries.
    """

    def __init__(self, frame: TriangleSurface, is_still: BoolArray) -> None:
        tuned, topology = parameters(), frame.topology
        self.may_move = ~(is_still | topology.is_loose)
        self.is_counted = self.may_move & ~topology.on_boundary
        size = frame.spread(np.log(frame.spacing), tuned.averaging_passes)
        _, label = csgraph.connected_components(topology.adjacency(), directed=False)
        n_counted = np.bincount(label, self.is_counted)
        own = n_counted >= tuned.fewest_to_tell
        order = np.argsort(label, kind="stable")
        each = np.split(order, np.cumsum(np.bincount(label))[:-1])
        members = [each[index] for index in np.flatnonzero(own)]
        rest = [each[index] for index in np.flatnonzero(~own)]
        self._n_own = len(members)
        if rest:
            members.append(np.concatenate(rest))
        # A slice saves copies of the largest arrays where there is one part.
        self._members: list[slice | IndexArray] = [slice(None)] if len(members) == 1 else members
        self._part: IntArray = np.zeros(topology.n_vertices, np.int32)
        self._weights: RealArray = np.zeros((tuned.most_classes, topology.n_vertices), np.float32)
        for part, some in enumerate(self._members):
            classes = density_classes(size[some], self.is_counted[some])
            self._part[some], self._weights[: len(classes), some] = part, classes

    def noise(self, surface: NoisySurface, *, keeps_clean: bool = True) -> NoiseFound:
        """Estimate the noise, and note if there is nothing to do.

        Parameters
        ----------
        surface : NoisySurface
            With at least `fewest` to judge from.
        keeps_clean : bool
            Whether a part that looks clean has no noise; otherwise all roughness is noise.
        """
        tuned = parameters()
        clean = tuned.clean_roughness
        n_counted = int(np.count_nonzero(self.is_counted))
        noise, level, told = np.zeros((3, len(self.is_counted)))
        impulsive = np.zeros(len(level), dtype=bool)
        detail = CleanDetail(surface, self.is_counted)
        models, certainties = [], np.ones(len(self._members))
        for part, members in enumerate(self._members):
            counted = np.zeros(len(level), dtype=bool)
            counted[members] = self.is_counted[members]
            # As in a mesh of so few vertices nothing can be judged: specks do not change.
            if np.count_nonzero(counted) < tuned.fewest:
                continue
            level[counted], law = _level(surface, surface.roughness, counted)
            if np.median(level[counted]) <= clean:
                continue
            # Nor in small parts together: crumbs of a clean model are shapes of a few vertices.
            is_left_over = part == self._n_own > 0
            if keeps_clean and is_left_over and not (noise.any() or impulsive.any()):
                continue
            # Not all are needed on every surface, but side by side they cost little.
            of_hinges, stands_out, fades, is_contour, copies = side_by_side(
                partial(_by_hinges, surface, counted),
                partial(is_impulsive, surface, level, counted),
                partial(surface.fading.fades, counted),
                partial(detail.is_contour, counted),
                partial(detail.copies, counted),
            )
            # The steps of contoured voxels stand out as well, but fade; single vertices do not.
            if stands_out and not fades:
                impulsive[members] = self.may_move[members]
            if not keeps_clean:
                noise[counted] = level[counted]
                continue
            # Every kind of contrast is an upper bound: shape only adds.
            rough = level[counted]
            least = told[counted] = rough if is_contour else np.minimum(rough, of_hinges)
            # The fading of the roughness tells nothing where shape has raised it.
            is_raised = np.median(least) < tuned.clearly_less * np.median(rough)
            is_detail = not is_raised and detail.fades(counted)
            if not (is_detail or is_contour):
                signs, reason = (1.0, copies) if copies else detail.shape(counted, told)
                is_detail = signs >= 1
                if is_detail:
                    models.append(reason)
                else:
                    certainties[part] = certainty(np.array(signs))
            if not is_detail and np.median(least) > clean:
                # What part of it clean meshes have, the roughness tells.
                spacing = surface.frame.spacing[counted]
                noise[counted] = least * law.noise(spacing) / law.level(spacing)
        is_any = noise.any() or impulsive.any()
        if is_any and n_counted < tuned.fewest_to_tell and keeps_clean:
            return NoiseFound(0 * noise, np.zeros_like(impulsive), level, (self.too_few(),))
        uneven = unevenness(surface, noise, self.is_counted)
        noise = noise if uneven is None else noise * uneven
        notes = () if noise.any() else (self.why_nothing(level, models),)
        return NoiseFound(noise, impulsive, level, notes, uneven, certainties)

    def too_few(self) -> str:
        """Note that there are too few vertices to judge from."""
        return (
            f"only {np.count_nonzero(self.is_counted)} vertices inside the surface: too few to "
            "tell noise from shape; nothing was changed"
        )

    def why_nothing(self, level: FloatArray, models: Sequence[str] = ()) -> str:
        """Note why there is nothing to do, from the roughness (n,) and signs of models."""
        if models:
            return f"looks like a clean low-poly model: {models[0]}; nothing was changed"
        typical = float(np.median(level[self.is_counted]))
        is_clean = typical <= parameters().clean_roughness
        what = "clean meshes are" if is_clean else "the detail of clean meshes is"
        return (
            f"no noise found: the surface is rough by {typical:.2g} of the local edge length, as "
            f"{what}; nothing was changed"
        )

    def best_mixtures(
        self,
        removed: Sequence[RealArray],
        divergence: Sequence[RealArray],
        variances: FloatArray,
    ) -> list[Mixture]:
        """Mix the filters for the least risk in every part.

        The risk follows from the part that each of k filters removes, (n,) each, and from its
        divergence.  There is one mixture for each of several variances (s, n) of the noise; the
        first is that of the noise as it is.
        """
        n_parts, n_classes = len(self._members), len(self._weights)
        chosen = np.zeros((len(variances), n_parts, n_classes, len(removed)))
        for part, members in enumerate(self._members):
            weights = self._weights[:, members] * self.is_counted[members]
            used = np.flatnonzero(weights.any(axis=1))
            if len(used):
                chosen[:, part, used] = least_risk_coefficients(
                    [row[members] for row in removed],
                    [row[members] for row in divergence],
                    variances[:, members],
                    weights[used],
                )
        return [Mixture(each, self._weights, self._part) for each in chosen]

    def clustering(
        self, before: TriangleSurface, after: TriangleSurface, noise: FloatArray
    ) -> FloatArray:
        """Correlate the displacements of vertices with those of their neighbours, (p,).

        Noise is as strong everywhere as its model says.  So large displacements by removed noise do
        not lie beside other large ones.  Displacements by removed shape do: they are large at
        corners, creases and slivers, and small on faces.

        Parameters
        ----------
        before, after : TriangleSurface
            The same vertices before and after noise was removed.
        noise : (n,)
            Standard deviation in local edge lengths.
        """
        removed = np.abs(after.along_normal(before.positions - after.positions))
        is_judged = self.is_counted & (noise > 0)
        # The logarithm lets a few large ones not decide for all.
        size = np.where(is_judged, np.log1p(removed / np.where(is_judged, noise, 1)), 0)
        part_beside = after.mean @ is_judged.astype(float)
        beside = after.mean @ size / np.maximum(part_beside, np.finfo(float).tiny)
        return self._correlation(size, beside, is_judged & (part_beside > 0))

    def likeness(
        self, before: TriangleSurface, after: TriangleSurface, noise: FloatArray
    ) -> FloatArray:
        """Correlate the displacements of vertices with the bending that stays there, (p,).

        Noise is independent of the surface below it. Of a shape, what bends most is removed most,
        and towards the same side.

        Parameters
        ----------
        before, after, noise
            As for `clustering`.

        Source: the noise of a method, A. Buades, B. Coll, J.-M. Morel, A review of image denoising
        algorithms, with a new one, 2005.
        """
        is_judged = self.is_counted & (noise > 0)
        removed = after.along_normal(before.positions - after.positions)
        bending = after.mean @ after.rises(after.positions)
        return self._correlation(removed / np.where(is_judged, noise, 1), bending, is_judged)

    def _correlation(
        self, first: FloatArray, second: FloatArray, is_judged: BoolArray
    ) -> FloatArray:
        """Correlate two values (n,) of some vertices, (n,) bool, in every part, (p,)."""
        first, second, part = first[is_judged], second[is_judged], self._part[is_judged]
        n_parts = len(self._members)
        count = np.maximum(np.bincount(part, minlength=n_parts), 1)

        def covariance(one: FloatArray, other: FloatArray) -> FloatArray:
            sums = [np.bincount(part, each, n_parts) for each in (one, other, one * other)]
            result: FloatArray = sums[2] / count - sums[0] * sums[1] / count**2
            return result

        spread = covariance(first, first) * covariance(second, second)
        return covariance(first, second) / np.sqrt(np.maximum(spread, np.finfo(float).tiny))

    def is_rough(self, surface: TriangleSurface) -> BoolArray:
        """Whether vertices (n,) are in the rough rest of their part, not in a smooth patch of it.

        A hole that was filled, or what was denoised before, is much smoother than most of a part.
        """
        tuned, rises = parameters(), surface.rises(surface.positions)
        around = surface.spread(np.abs(rises - surface.mean @ rises), tuned.averaging_passes)
        rough = np.ones(len(around), dtype=bool)
        for members in self._members:
            counted = around[members][self.is_counted[members]]
            if len(counted):
                rough[members] = around[members] >= tuned.smooth_patch * np.median(counted)
        return rough

    def counts(self, is_one: BoolArray | None = None) -> FloatArray:
        """Count the counted vertices of every part, (p,), among some vertices, (n,) bool."""
        return self.sums(self.is_counted if is_one is None else is_one)

    def sums(self, values: FloatArray | BoolArray) -> FloatArray:
        """Add up values (n,) at the counted vertices of every part, (p,)."""
        counted = np.where(self.is_counted, values, 0)
        return np.bincount(self._part, counted, len(self._members)).astype(np.float64, copy=False)

    def at_vertices(self, of_parts: BoolArray) -> BoolArray:
        """Pass flags (p,) of the parts on to their vertices, (n,)."""
        of_vertices: BoolArray = of_parts[self._part]
        return of_vertices


def _level(
    surface: NoisySurface, contrast: Contrast, counted: BoolArray
) -> tuple[FloatArray, VarianceLaw]:
    """Level (c,) of the noise of some vertices, (n,) bool, and its law, by one kind of contrast."""
    frame, law = surface.frame, variance_law(contrast, counted)
    level = law.level(frame.spacing[counted])
    if surface.cosines is None or np.median(level) <= parameters().clean_roughness:
        return level, law
    seen = scan_level(contrast, frame, counted, surface.cosines)
    # The noise of a scan does not grow with the edges, so none of it is a clean mesh's.
    return seen[counted], VarianceLaw(0.0, 1.0)


def _by_hinges(surface: NoisySurface, counted: BoolArray) -> FloatArray:
    """Level (c,) of some vertices, (n,) bool, by hinges; infinite where these tell nothing."""
    if not counted[surface.hinges.vertices].all(axis=1).any():
        return np.full(np.count_nonzero(counted), np.inf)
    level, _ = _level(surface, surface.hinges, counted)
    # One of two estimates is always lower: it must be by more than chance.
    bound = level * (1 + MEDIAN_ERROR / np.sqrt(len(level)))
    # Noise that turns triangles over leaves nothing in their hinges.
    return np.where(level > parameters().coarse_noise, np.inf, bound)


def density_classes(size: FloatArray, is_counted: BoolArray) -> FloatArray:
    """Membership (c, n) of vertices in overlapping classes from dense to coarse; sums are 1.

    Parameters
    ----------
    size : (n,)
        Logarithm of the local edge length.
    is_counted : (n,) bool
        Vertices whose distribution decides the classes.
    """
    tuned = parameters()
    n_counted = int(np.count_nonzero(is_counted))
    n_classes = int(np.clip(n_counted // tuned.fewest_to_tell, 1, tuned.most_classes))
    parts = np.linspace(tuned.class_margin, 1 - tuned.class_margin, n_classes)
    knots = np.quantile(size[is_counted], parts) if n_counted else []
    # On an even mesh there is nothing to tell apart.
    if n_classes == 1 or not np.all(np.diff(knots) > 0):
        return np.ones((1, len(size)))
    return np.stack([np.interp(size, knots, unit) for unit in np.eye(n_classes)])
