"""Tuned numbers of the automatic method.

Functions read `parameters()` where they need a number.  `using` replaces the numbers inside its
block, in the calling thread only, so tasks of a thread pool must get them as arguments.
`python -m research.denoising.sensitivity` shows the effect of each number on the benchmark.

Lengths are in local edge lengths, times in squared edge lengths, angles in radians.  The numbers
were chosen together on the tuning shapes of `research/denoising`, mostly with normal noise of 0.2.
A comment says what a number means and what it was found on.  "By hand" means that no measurement of
this number alone is recorded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass(frozen=True)
class DenoiseParameters:
    """Tuned numbers: first those of several modules, then those of one module each."""

    # Several modules.
    # With fewer vertices no noise is estimated: in a mesh, in its small parts together, on one flat
    # face, or along a boundary curve. So many spikes are many. By hand; with 12 for curves and
    # spikes the results were the same.
    fewest: int = 50
    # From fewer vertices noise cannot be told from shape: in a rough mesh, a connected part, a bin
    # or a class of density, or well inside all flat faces. Smaller parts, such as eyes of a head,
    # take the verdict of the whole. With 400 for parts, bins and faces, errors and angles of 704
    # decimated shapes with noise were 1.002 and 1.001 times as large, others the same.
    fewest_to_tell: int = 300
    # Rounds of each loop that ends when nothing changes: spikes go back and settle, folds open, and
    # motion that turns triangles over is halved, first along the surface, then along the normal
    # too. On seven shapes spikes that settle in 3, 10, 20 and 40 rounds left 0.90, 0.86, 0.85 and
    # 0.85 of the error without settling. Folds were the same with 5 and 20.
    rounds: int = 8
    # Passes of averaging over the neighbours that smooth the local edge length, and normals until
    # noise and folds hardly disturb them. With 3 free boundaries kept 0.69 of their noise, with 5
    # 0.56. With 3 the angle of fused volumes was 1.08 times as large, with 5 the error of
    # staircases 1.01 times.
    averaging_passes: int = 4
    # Quantile of the hinges, and of the bins, that gives the noise. Features raise some of them, a
    # flat part or a boundary lowers others. On models of a CSG kernel up to 0.4 of the hinges are
    # flat. Heights rounded to the size of their noise leave 0.2 flat.
    low_quantile: float = 0.3
    # So many standard deviations are no chance. Spikes stand out by as many of the noise, and two
    # planes are nearer than one quadric by as many. Ratios of quantiles of n values, for heavy
    # tails and for fading, are apart by as many times 1 / √n: with none there, one amplitude of
    # 0.05 on flat faces counted as spikes after jitter of 0.0001 of an edge. By hand; 4 and 2.5
    # gave the same for these.
    clear_deviations: float = 3.0
    # What is below this part of its size in white noise is clearly less: the lower bounds against
    # the roughness, which shape has raised then, and the differences of high order against those of
    # low order, which fade then. White noise on many shapes kept 0.92 to 1.05 in high order,
    # staircases 0.71 to 0.85.
    clearly_less: float = 0.9

    # flat_faces. On shapes of flat faces, with normal noise and one amplitude of 0.2, a change of
    # one of these by a third to a half changed the error by at most 2 % and the angle by at most
    # 5 %, unless its comment says otherwise.
    # Turns within a flat face over those at its limits. Pieces of round surfaces have 0.07 to 0.3,
    # flat faces with white noise of 0.2 at most 0.09. With 0.14 polyhedra had 0.96 of the error
    # that they had with 0.1, brackets with noise of 0.4 1.1 times theirs.
    most_bent_within: float = 0.12
    # Part of the limits of a flat face beyond which it goes on as one quadric. With 0.5, holes of
    # brackets were faceted: 1.09 times the error.
    most_round_limits: float = 0.25
    # Triangles with a vertex further from the plane than this are not taken. Where the noise is
    # more than `coarse_noise` it is larger in proportion: on ten CAD shapes with one amplitude of
    # 0.2 the error was 0.98 of that with the same everywhere. Smooth noise is at most as strong:
    # clean decimated steps were taken for noise of 1.1, rocks and wrinkles all over four flat-sided
    # shapes for noise of 0.39 to 0.75, and noise of 0.3 that is alike over four edges for 0.32.
    face_height: float = 0.35
    # A mesh with a smaller part of its triangles on flat faces counts as round. From here to twice
    # as much, its faces count for more and more. Seven organic shapes had at most 0.12, parts with
    # flat sides at least 0.25, one shape between them 0.15.
    least_flat: float = 0.12

    # filters: times, orders and steps of the diffusions.
    # Times of the gentle filters, which every metric has. Creases need them. The last is also that
    # of the step that fits a surface to normals. With 1.0 between them nothing was better.
    gentle_times: tuple[float, ...] = (0.25, 4.0)
    # Order of accuracy of the gentle filters. By hand.
    gentle_order: int = 2
    # Times of the steep filters, for smooth shapes, which have no short waves. The first of them
    # also makes the slightly smoothed surface. By hand.
    steep_times: tuple[float, ...] = (0.5, 1.2, 3.0)
    # Order of accuracy of the steep filters. By hand.
    steep_order: int = 4
    # Steps of each gentle or steep filter. By hand.
    diffusion_steps: int = 4
    # Fraction of the flux through the boundary that does not count as bending. With 0 boundaries
    # are drawn inwards, with 1 their noise stays. Found on an open mesh with slivers on its
    # boundary, where 0 made the error larger by half.
    boundary_flux_fraction: float = 0.5

    # Metrics and normals of the rounds.
    # Angle of the metrics of the second round, which see creases. By hand.
    wide_angle: float = 0.3
    # Angle of the metric of the third round, which keeps creases. By hand.
    narrow_angle: float = math.radians(2)
    # Normals that turn further than this are beyond a crease: for flat faces, for the short
    # smoothing of normals, and where creases are counted. By hand.
    short_fit_angle: float = math.radians(30)
    # The long smoothing of normals leaves out those that turn further than this. By hand; with 30°,
    # brackets had 1.2 to 1.4 times the error.
    long_fit_angle: float = math.radians(60)
    # Passes of the smoothing of normals, ascending: the short one has all, the long one the last.
    # With 8 for the last errors with one amplitude of 0.5 were 1.02 times as large. The long one
    # was the same with 20, and with another filter after 3 of them.
    fit_passes: tuple[int, ...] = (2, 12)
    # The angles of the metrics are for this much noise or more. Less noise disturbs the normals
    # less, so smaller angles tell creases from it. Normals weigh less where their noise is large
    # against this; with twice as much, or with 0, the angle of nine uneven shapes with one
    # amplitude of 0.2 was 1.1 times as large. And up to this the normals and hinges of the noisy
    # mesh say something: noise of 0.5 turns triangles over, and with normals of the noisy mesh the
    # error was up to 1.8 times as large.
    coarse_noise: float = 0.25

    # lifted_metric
    # Fraction of the mass of linear elements that is moved to the diagonal. With 0 filters are
    # unstable at boundaries of slivers; with 1 the error was 4 % larger.
    lumped_fraction: float = 0.3

    # mesh_parts
    # Classes at most. By hand.
    most_classes: int = 3
    # Fraction of the vertices beyond the middle of the first class, and of the last. With a sixth
    # 395 meshes were the same in the mean, but one uneven shape lost 2 to 8 %.
    class_margin: float = 0.05
    # A patch with less than this part of the median roughness is smooth. Without it two noisy
    # shapes, a fifth of each smooth, were left as they were. By hand.
    smooth_patch: float = 0.5

    # mixture
    # Standard deviation by which the coefficients of a filter differ between the density classes,
    # before the risk tells. Errors and angles of 36 shapes with four kinds of noise are 0.996 and
    # 0.993 of those without it, up to 13 % less where few vertices are noisy by one amplitude or
    # along rays. With 0.1 smooth noise gained more, but the depth camera lost 1 %; with 0.32 about
    # half of the gain was left.
    class_deviation: float = 0.2

    # mixing
    # The risk is minimised for this multiple of the estimated noise. The estimate is a lower bound,
    # so 1 leaves a little too much noise. Found on meshes with known noise.
    noise_factor: float = 1.1
    # Size of a probe over that of the noise. With 0.1 jitter of 0.0001 of an edge changed nine
    # shapes by up to 2.8 and 9.7 % of what is removed, with this by up to 2.6 and 4.5 %: a small
    # probe divides the leaps of filters that choose by a small number.
    probe_size: float = 0.4
    # Vertices of all probes together, at least; four probes at most. With one probe, errors and
    # angles on ten shapes of 5,000 vertices with eleven kinds of noise were 1.002 and 1.007 times
    # those with four, and jitter changed nine shapes by 1.1 and 1.3 % in the mean, not 0.4 and 0.6.
    # From so many vertices on contrasts are compared with one noise, too, not with three.
    least_probed: int = 20_000
    # The correlation of what is removed at neighbours exceeds that of the model's noise by at most
    # this. With ten kinds of noise on 18 tuning shapes the excess was -0.14 to 0.27. On 12 shapes,
    # half of them decimated, with noise of 0.02 to 0.4, it was 0.28 to 0.67 where the result was
    # worse than the input. At 0.3 chance decided on a decimated gear: 0.291 or 0.309.
    most_clustered: float = 0.28
    # From so much on it may be detail, and a note says so: on 3 of 117 noisy meshes of 12 tuning
    # shapes. The detail of two decimated scans had 0.23 and 0.25.
    clustered_detail: float = 0.18
    # And with the bending that stays around it, it correlates by at most this. With 22 kinds of
    # noise on 19 tuning shapes that was at most 0.29 where it helped; 0.38 to 0.61 on a knurled
    # cylinder with noise of 0.02 to 0.1 and on decimated terrain with up to 0.05, which ended at
    # 2.7 to 6.7 times their noise.
    most_alike: float = 0.33

    # bounds
    # Vertices go this fraction of their way along the surface. On meshes with known noise that was
    # worth 4 % of the error and 7 % of the angle with noise of 0.05, 0 and 4 % with noise of 0.2.
    sliding_fraction: float = 0.75

    # noise/clean_detail: what looks like noise on a clean mesh.
    # Signs of shape from which on roughness is shape; from two thirds of this on less and less is
    # removed. They are the geometric mean of the edges that fit bends better than with noise, and
    # of the same plus how much less longer edges bend and how much fades. On 957 runs with
    # decimated shapes they find 32 of 44 that noise removal would harm; 9 of 838 that it would help
    # keep their noise, and one fused volume of 24. With a weighted sum of the edges, a deviation
    # for chance and the fading that was 30, 16 and none. With 0.135 decimated terrain with noise of
    # 0.02 ended at 1.8 times it.
    most_shape: float = 0.115

    # noise/contrast: fading in differences of high order.
    # Contours are rougher than this. Less roughness that fades in differences of high order is
    # shape, which fades as well. Contoured voxels have 0.13 to 0.18.
    least_roughness: float = 0.11
    # Coefficient of the neighbours' mean in the noise of contoured voxels, which fade as noise with
    # 0.55 to 0.63 would; but part of that is the fading of their shape.
    correlation_of_staircases: float = 0.56

    # noise/face_noise
    # Flat faces are looked for as if the noise were smoothed by this many passes of averaging.
    assumed_passes: int = 8

    # noise/level
    # Largest roughness of clean meshes in their quietest bin.
    clean_roughness: float = 0.04
    # Minus the logarithm of the likelihood of one contrast is at most this. What lies further out
    # than 2.4 standard deviations is a feature in any noise. Without it one amplitude of 0.1 stayed
    # on shapes with creases.
    most_unlikely: float = 3.0

    # noise/clean_detail: contours of voxels.
    # Contoured voxels have at least this many kinds of vertices for each kind of edges. Models have
    # fewer kinds of vertices than of edges. By hand.
    least_kinds_of_vertices: float = 3.0

    # Noise of a given width.
    # Wide noise is removed on a coarser mesh, where it spans at least this many edges.
    level_edges_of_width: float = 3.5
    # Standard deviation that noise of a given width usually has, and strength of a shape in the
    # band narrower than the noise, over its squared width, times √n of n vertices. Either may
    # differ by a factor of e. On 19 shapes with noise over 4 and more edges the second was 1.3 in
    # the median, with a deviation of 0.75 of the logarithm, which fell with ln n by 0.48. With 0.3
    # for the first, or 0.6 or 1.2 for the second, errors and angles for seven kinds of noise
    # changed by at most 1 and 2 %.
    usual_noise: float = 0.2
    usual_bend: float = 0.9

    # No vertex of n moves further than √(2 ln n) standard deviations of the noise plus this many.
    extra_deviations: float = 1.0

    # noise_verdict
    # The share of spikes among the neighbours of spikes exceeds that among all n vertices by at
    # most this, less 1 / √n for chance. Spikes and heavy tails on 18 tuning shapes had -0.1 to
    # 0.03, one 0.08, on small meshes at most 0.02. Corners of decimated shapes had 0.03 to 0.4,
    # those of two CSG models of 390 and 493 vertices 0.024 and 0.026.
    most_clustered_spikes: float = 0.06

    # And normal noise alone, put back in the same way, moves by at most this part of the squares:
    # its own tails stand out too. Heavy tails and spikes on six shapes had at most 0.07, noise of
    # one amplitude on two uneven ones, which had been taken for impulsive, 0.45 to 1.2, and a clean
    # CSG model 0.37 to 0.40. With 0.4 errors on 19 shapes with spikes were the same.
    most_explained: float = 0.2

    # noise/smooth_noise
    # Bands are compared over neighbourhoods of this many passes of averaging. By hand.
    band_passes: int = 30
    # This fraction of the surface is quiet. By hand.
    quiet_fraction: float = 0.1
    # Bands that fit noise worse are none, also where all roughness counts as noise. Without it one
    # shape of ten with noise of 0.05 ended at 4.9 times its error.
    most_misfit: float = 0.15
    # On fewer vertices coarse round shapes are as even as noise, so wide noise is removed on levels
    # of as many. With levels of 300 the errors of 19 shapes with noise over 6 to 16 edges were 1.05
    # to 1.17 times as large.
    fewest_to_tell_smooth: int = 1500
    # Noise is everywhere: so much of it, at least, is in hinges and in low bands, as a geometric
    # mean. On flat faces it was 0.65 or more with 66 of 68 noisy tuning shapes, and less with 41 of
    # 44 triply periodic walls whose bends had passed for noise on faces. A real depth image has
    # 0.68, coarse spheres whose facets were divided at most 0.2.
    least_presence: float = 0.65
    # On terrain the next wider band is stronger than noise by at most this, as a logarithm. Fractal
    # terrain, which all other evidence takes for noise, has 0.65 to 0.88. On objects the shape adds
    # to it: noise over two edges has up to 0.86, fused volumes 1.3.
    told_excess: float = 0.55
    # The evidence for smooth noise: weights of misfit, evenness, outliers and lean, a constant, and
    # the least value with which noise is told. Of 201 tuning meshes with seven kinds of smooth
    # noise they tell 73 where shape hides it, and 5 of 544 that have none: detail, depth images,
    # thin walls and decimated shapes with little white noise. Weights of a logistic regression told
    # 75 and 11. `research.denoising.smooth_evidence` judges them on shapes left out.
    evidence_weights: tuple[float, ...] = (-0.46, 3.1, -3.7, -0.53, -5.0)
    least_evidence: float = 1.0

    # noise/unevenness
    # Variance of the logarithm of the strength around vertices that even noise has, by chance and
    # by the shape. Chance alone makes 0.005; of 19 shapes with even noise of 0.1 most have less
    # than this, and 18 meshes with noise that grows from one end to the other 0.1 to 0.5.
    even_spread: float = 0.04

    # noise/spikes
    # This quantile of the deviations from lines is divided by their median, and the quotient by
    # that of normal noise on the same mesh. On 25 shapes four kinds of normal noise had 0.91 to
    # 1.16, but up to 2.24 on three with detail in places. Heavy tails had 1.33 to 1.76.
    tail_quantile: float = 0.99
    # Noise is impulsive from this ratio on.
    normal_ratio: float = 1.2
    # A vertex that stands out stays if its neighbours would come further off their own lines than
    # this many times what it comes nearer to its own. At a corner of three creases that is 1.5.
    # Without it errors of 27 shapes with spikes were 1.10 times as large. With 1 those with creases
    # lost a tenth more of theirs, but spikes side by side stayed on round shapes: up to 1.4 times.
    most_disturbed: float = 1.25


PARAMETERS = DenoiseParameters()
"""What every run uses."""

_current: ContextVar[DenoiseParameters] = ContextVar("denoise_parameters", default=PARAMETERS)


def parameters() -> DenoiseParameters:
    """Return the parameters of the present context: `PARAMETERS` outside of `using`."""
    return _current.get()


@contextmanager
def using(replacement: DenoiseParameters) -> Iterator[None]:
    """Run the block with other parameters, for experiments; unrelated threads do not see them."""
    token = _current.set(replacement)
    try:
        yield
    finally:
        _current.reset(token)
