"""Tuned numbers of the automatic method, and the variation of one of them by a tool.

Functions read `parameters()` where they need a number.  `using` replaces the numbers for the code
inside its block, in the calling thread only: tasks of a thread pool must get them as arguments.
`python -m research.denoising.sensitivity` shows the effect of each number on the benchmark.

Lengths are in local edge lengths, times in squared edge lengths, angles in radians.  All numbers
together were chosen on the tuning shapes of `research/denoising`, for the most part with normal
noise of 0.2.  A comment says what a number means and what it was found on; "by hand" if no
measurement of it alone is recorded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass(frozen=True)
class DenoiseParameters:
    """Tuned numbers: those of several modules, then the others by the module that reads them."""

    # Several modules.
    # Fewer triangles are no face, curves of fewer vertices have no noise of their own, and fewer
    # spikes are not many. By hand.
    fewest: int = 12
    # In a mesh of fewer vertices, or in all small parts together if they have fewer, nothing can be
    # told. By hand.
    fewest_vertices: int = 50
    # In a mesh of fewer vertices that is rough, noise cannot be told from shape. Smaller parts,
    # such as the eyes of a head, go with the whole; a class of density has as many. By hand.
    fewest_to_tell: int = 300
    # Estimates of the noise are made from as many vertices: those of a connected part, or of a bin
    # of density. By hand; from 300 the least of two bins was 0.16 and 0.17 with noise of 0.2.
    own_estimate: int = 400
    # Rounds of what is done again until nothing changes: faces grow, spikes go back and settle,
    # folds open, and ways of turned triangles are halved: along the surface alone, then along the
    # normal too. On seven shapes the error of spikes was 0.90, 0.86, 0.85 and 0.85 of that without
    # settling after 3, 10, 20 and 40; folds were the same with 5 and 20.
    rounds: int = 8
    # Passes of averaging over the neighbours that make lengths even. By hand.
    averaging_passes: int = 3
    # The quantile of hinges and of bins from which the noise is read: features raise some, a flat
    # part or a boundary lowers others. On models of a CSG kernel up to 0.4 of the hinges are flat;
    # heights rounded to the size of their noise leave 0.2 flat.
    low_quantile: float = 0.3
    # Triangles do not tell what is further than so many local edges: such noise, such planes. With
    # one amplitude of 0.5 the error was 0.76 of that with limits everywhere on four shapes with
    # specks of tiny triangles; 0.7 or 1.5 gave the same.
    most_edges: float = 1.0

    # denoise: what the result says about creases. It does not change the positions.
    # Normals beside a crease differ by at least this angle. By hand.
    crease_angle: float = 0.6

    # flat_faces. On shapes of flat faces, with normal noise and one amplitude of 0.2, these changed
    # the error by 2 % and the angle by 5 % at most, if made larger or smaller by a third to a half,
    # unless something else is said.
    # Passes of the short smoothing of normals from which faces are found.
    face_passes: int = 10
    # A triangle is even if those around it turn away by no more than this. With 3° a dense ball
    # came out in facets (1.4 of the error).
    even_angle: float = math.radians(2)
    # Those that turn away further than this are beyond a crease.
    face_angle: float = math.radians(15)
    # The normals of a flat face differ from its plane's by this much in the mean. With 3° the
    # error was 4 % larger, because faces were missed; with 8° it was 1.07 on *lens* with one
    # amplitude of 0.5.
    most_uneven: float = math.radians(4)
    # The same with smooth noise, whose waves stay in the normals. On 13 shapes with flat faces the
    # error was 0.68 and 0.74 with 4°, 0.64 and 0.73 with 8° (depth camera, alike over four edges).
    most_uneven_if_smooth: float = math.radians(8)
    # Triangles that turn away from the plane by more than this are not taken.
    face_angle_at_border: float = math.radians(25)
    # Triangles with a vertex further from the plane than this are not taken.
    face_height: float = 0.35
    # With noise of less than `coarse_noise` the height is smaller in proportion, by this factor at
    # most.
    # With 1, faces that meet at 15° grow into each other where the rest is clean.
    least_face_height: float = 0.5
    # With a smaller part of the triangles on flat faces a mesh counts as round. On 7 organic shapes
    # it was 0.12 at most, on parts with flat sides 0.25 or more, on one between 0.15.
    least_flat: float = 0.2
    # The same after spikes, where the rest is clean. With 0 two organic shapes were worse, by 5 and
    # 13 %.
    least_flat_dented: float = 0.1
    # Fits of a plane: the second leaves outliers out. With four nothing was better.
    plane_fits: int = 2
    # Vertices that lie this many standard deviations off the plane do not count.
    plane_outlier: float = 4.0
    # A face is bent if a quadric fits it better than a plane by more than this F statistic.
    most_bend: float = 8.0
    # A vertex goes half of its way to planes at an angle of θ if θ² / 2 is this. By hand.
    parallel_planes: float = 0.003

    # filter_bank: times, orders and steps of the diffusions.
    # Times of the filters that every metric has; creases need these gentle ones. By hand.
    gentle_times: tuple[float, ...] = (0.25, 1.0, 4.0)
    # Order of accuracy of the gentle filters. By hand.
    gentle_order: int = 2
    # Times of the steep filters, for smooth shapes, whose waves end somewhere. By hand.
    steep_times: tuple[float, ...] = (0.5, 1.2, 3.0)
    # Order of accuracy of the steep filters. By hand.
    steep_order: int = 4
    # Steps of each gentle or steep filter. By hand.
    diffusion_steps: int = 4
    # Time, order and steps of the smoothing before the first metric of a surface. By hand.
    first_time: float = 0.5
    first_order: int = 2
    first_steps: int = 2
    # Relative residual of the filters' solves. A filter need not be exactly that of its formula,
    # because what it removes is measured. With 0.01 the results were no better.
    filter_tolerance: float = 0.05
    # Time of the step that fits a surface to normals. By hand.
    fit_time: float = 4.0
    # Relative residual of that step's solve. By hand.
    fit_tolerance: float = 1e-2
    # Fraction of the flux through the boundary that is not taken for bending. With 0 boundaries are
    # drawn inwards, with 1 their noise stays. Found on an open mesh with slivers on its boundary,
    # where 0 had an error larger by half.
    boundary_flux_fraction: float = 0.5
    # A vertex counts for at most this many times the others around it, and at least for one over
    # this. By hand.
    largest_weight: float = 8.0

    # filter_rounds: metrics and normals of the rounds.
    # Angle of the metrics of the second round, which see creases. By hand.
    wide_angle: float = 0.3
    # Angle of the metric of the third round, which keeps creases. By hand.
    narrow_angle: float = 0.035
    # Normals that turn further than this do not count, in the short smoothing. By hand.
    short_fit_angle: float = math.radians(30)
    # Passes of the short smoothing of normals, ascending. By hand.
    short_fit_passes: tuple[int, ...] = (2, 8)
    # Normals that turn further than this do not count, in the long smoothing. By hand.
    long_fit_angle: float = math.radians(60)
    # Passes of the long smoothing of normals, ascending. By hand.
    long_fit_passes: tuple[int, ...] = (1, 3, 8, 20)
    # Passes of the long smoothing of the noisy mesh's own normals. By hand.
    noisy_fit_passes: tuple[int, ...] = (20,)
    # Noise up to which the normals of the noisy mesh are used. With noise of 0.1 and 0.2 the angle
    # between the normals was 0.6 on shapes of flat faces with them, the error on others up to 1.11;
    # with 0.5, which turns triangles over, up to 1.8.
    most_noise_in_normals: float = 0.25
    # The last round is for meshes with more creases than this among their edges. Of 25 shapes the
    # smooth ones had at most 0.008 (one with slivers 0.027), those with creases 0.016 or more.
    fewest_creases: float = 0.01
    # The angles of the metrics are for this much noise or more. Less noise disturbs the normals
    # less, and smaller angles tell creases from it. By hand.
    # Normals with more noise count for less. With twice as much for that, or none, the angle of
    # nine uneven shapes with one amplitude of 0.2 was 1.1 times as large.
    coarse_noise: float = 0.2

    # lifted_metric
    # Fraction of the mass of linear elements that is moved to the diagonal. With 0 filters are
    # unstable at boundaries of slivers; with 1 the error was 4 % larger.
    lumped_fraction: float = 0.3

    # mesh_parts
    # Classes at most. By hand.
    most_classes: int = 3
    # This fraction of the vertices lies beyond the first and the last class's middle. By hand.
    class_margin: float = 0.05
    # Middles of classes differ by more than this in the logarithm of the edge length; a mesh where
    # they do not is even. By hand.
    least_class_distance: float = 0.02
    # Hinges tell the noise where they tell less than this part of what the roughness does: shape
    # has raised that.  Else the roughness does, which is measured at the vertices.
    clearly_less: float = 0.85

    # mixing
    # The risk is minimised for this multiple of the estimated noise. With 1 a little more noise is
    # left than looks and measures best, because the estimate is a lower bound. Found on meshes with
    # known noise.
    noise_factor: float = 1.1
    # Size of the probes: small against any noise, large against rounding. By hand.
    probe_size: float = 0.02
    # Responses to a probe are cut off this far from 1. They are about 1 at most, but leap where a
    # probe folds a triangle over. By hand.
    largest_response: float = 3.0
    # What is removed at a vertex correlates with what is removed beside it by no more than this
    # above the model's noise. With noise of ten kinds on 18 tuning shapes it did so by -0.14 to
    # 0.27. On 12 shapes, half of them decimated, with noise of 0.02 to 0.4: 0.28 to 0.67 where the
    # result was worse than the input.
    most_clustered: float = 0.3

    # normal_filter
    # 1 + cos of the angle of a turn is at least this: turns by nearly half a circle have no
    # shortest way. By hand.
    least_opening: float = 0.1

    # boundary_curves. On seven open tuning shapes with six kinds of noise.
    # Passes of averaging along a curve, ascending. By hand.
    curve_passes: tuple[int, ...] = (1, 2, 4, 8, 16, 32)
    # Half the width of confidence intervals in standard deviations. With 1 or 2 the distance to
    # the clean boundaries changed by 1 %.
    curve_certainty: float = 1.5

    # tangential_limit
    # Vertices go this fraction of their way along the surface. Found on meshes with known noise: it
    # was worth 4 % of the error and 7 % of the normals with noise of 0.05, 0 and 4 % with 0.2.
    sliding_fraction: float = 0.75
    # A triangle is upright if the cosine of its angle to the surface is more than this. By hand.
    upright_cosine: float = 0.2
    # An upright triangle is turned over if its cosine becomes less than this. By hand.
    turned_cosine: float = 0.1
    # Passes of averaging until noise and folds hardly disturb the normals. By hand.
    normal_passes: int = 5

    # noise/clean_detail: what looks like noise on a clean mesh.
    # A shape of more vertices is not taken for a low-poly model. Decimated and modelled shapes of
    # 400 to 3000 vertices were measured.
    low_poly: int = 3000
    # Neighbours in a model stand out alike by this correlation: white noise has 0, smooth shapes 1.
    # Models measured 0.65 to 0.95; with noise of 0.2 at most 0.58, but for slivers.
    least_bend_correlation: float = 0.6
    # Models are less rough. They measured up to 0.25; slivers with noise seem rough by 0.8.
    roughest_model: float = 0.4
    # What keeps less in differences of high order is smoother than the edges of a model allow.
    # By hand.
    least_kept: float = 0.75
    # This fraction of a clean mesh's vertices may be rougher than clean meshes are: those with much
    # shorter edges than others. By hand.
    rough_fraction: float = 0.1

    # noise/order_decay
    # Less roughness that fades is shape, which fades as well. Contoured voxels measure 0.13 to
    # 0.18.
    least_roughness: float = 0.11
    # Largest coefficient of the neighbours' mean in noise. Contoured voxels fade as with 0.55 to
    # 0.63, but the shape's own fading is in it.
    most_correlation: float = 0.56
    # What keeps less in differences of high order fades. White noise on many shapes keeps 0.92 to
    # 1.05, staircases 0.71 to 0.85.
    fading_kept: float = 0.9
    # Few vertices may keep less by chance, 1 / √n. They fade if they keep less than `white_kept`
    # minus `fading_deviations` / √n. By hand.
    white_kept: float = 0.97
    fading_deviations: float = 2.0

    # noise/face_noise
    # Flat faces are looked for with smooth noise of so many passes of averaging, and with its
    # standard deviation over that of white noise.
    assumed_passes: int = 8
    assumed_deviation: float = 0.19
    # A face is counted if so many vertices are well inside. By hand.
    fewest_on_face: int = 60
    # Noise is told on faces within these limits: so many vertices well inside faces, which are
    # this part of all; and the level.
    fewest_on_faces: int = 500
    least_on_faces: float = 0.15
    least_level_on_faces: float = 0.05
    # Rocks and wrinkles all over four flat-sided shapes were told as noise, of levels from 0.39 to
    # 0.75; noise of 0.3 alike over four edges measured up to 0.32.
    most_level_on_faces: float = 0.35

    # noise/level
    # Roughness that clean meshes have: they measure up to this in their quietest bin.
    clean_roughness: float = 0.04
    # This many vertices say as much as one would alone, because differences of neighbours have
    # noise in common. By hand.
    dependent_vertices: float = 3.0
    # Minus the logarithm of the likelihood of one vertex is at most this: what lies further out
    # than 2.4 standard deviations is a feature, whatever the noise. By hand.
    most_unlikely: float = 3.0
    # Gain of the logarithm of the likelihood within bins at which both noise models are as good.
    # Noise that grows with the edges reached 2 on 22 shapes, mostly less than 0.5; noise of one
    # amplitude 3 to 170, except on spheres of even rings, where it was 1 to 5.
    least_gain: float = 1.5
    # How sharply that gain decides. By hand.
    gain_factor: float = 2.0
    # The same gain from which the noise of a scan is as strong everywhere along the line of sight,
    # not along the normals. Such noise reached 10 to 117 on 26 shapes of 32, a laser's at most 9.
    least_gain_of_sight: float = 10.0

    # noise/line_roughness
    # A line from one neighbour to the opposite one passes its vertex at least this fraction of its
    # length from either end. By hand.
    line_margin: float = 0.2

    # noise/line_of_sight
    # Part of the gaps of parallelograms that is across the lines of sight, at most. Depth images
    # had 1e-15, those of near cameras (up to 34 degrees off the middle) 0.012, other meshes 0.43 or
    # more.
    most_off_sight: float = 0.05

    # noise/repeats: exact twins among triangles.
    # A model has a twin for this fraction of its triangles. Meshes with noise of 0.05 and more have
    # 0.000 to 0.001.
    least_repeated: float = 0.1
    # A model has this many times the pairs that chance explains. Scans with rounded coordinates
    # have more than chance makes: a real one had 143 times as many. With this number nothing
    # changes on 200 random models, clean or noisy.
    least_over_chance: float = 512.0
    # Contoured voxels have at most this many kinds of edges; marching cubes have 27.
    most_kinds_of_edges: int = 100
    # Contoured voxels have this many kinds of vertices for each kind of edges; models have fewer
    # kinds of vertices than of edges. By hand.
    least_kinds_of_vertices: float = 3.0
    # Contoured voxels face in this many directions, unlike boxes. By hand.
    least_directions: int = 9

    # wide_noise, given_width: noise whose width was told.
    # Edges that wide noise spans on the level where it is removed, at least.
    level_edges_of_width: float = 3.5
    # What a shape has in the band that is narrower than the noise, over what it has in the one as
    # wide, each relative to noise. Five clean shapes measured 0.2 to 0.56 for widths of 4 to 16.
    narrow_of_shape: float = 0.38
    # The noise has at least this part of the narrow band, also where shape would explain it all:
    # or else there would be nothing that more strength could remove. By hand.
    least_of_narrow: float = 0.3

    # bounds
    # Of n vertices none moves further than √(2 ln n) standard deviations of the noise, and this
    # many more.
    extra_deviations: float = 1.0

    # noise_verdict
    # Spikes are noise if the roughness that is left without them is at most this many times what
    # all contrasts allow for noise. By hand.
    most_unexplained: float = 2.0
    # They are many: at least this part of the vertices judged. By hand.
    least_spikes: float = 0.05
    # What is beside a spike is one by no more than this above their share. Spikes and heavy tails
    # on 18 tuning shapes had -0.1 to 0.03, one 0.08; corners of decimated shapes 0.03 to 0.4.
    most_clustered_spikes: float = 0.05
    # Smooth noise makes hinges between triangles; a model with less than this part of them has
    # none. A real scan of flat and round faces, fused from depth images, had 0.48.
    least_of_expected_hinges: float = 0.45

    # noise/smooth_noise
    # Passes of averaging over the neighbourhoods whose bands are compared. By hand.
    band_passes: int = 30
    # This fraction of the surface is quiet. By hand.
    quiet_fraction: float = 0.1
    # Evenness from which a surface may have smooth noise, and how far its bands may be from those
    # of noise, if all roughness counts as noise.
    least_evenness: float = 0.4
    most_misfit: float = 0.15
    # Evenness and level from which smooth noise is likely. Of 184 clean meshes 7 have both, 4 of
    # them with fine detail all over.
    likely_evenness: float = 0.75
    likely_level: float = 0.09
    # Coarse round shapes are as even as noise: a mesh of fewer vertices is no scan. By hand.
    fewest_of_scan: int = 4500
    # Where the bands fit noise worse, the narrowest one shows the edges of the mesh and does not
    # count. Noise alike over two edges had at most 0.05, over four edges 0.07 to 0.13.
    least_misfit_of_edges: float = 0.06
    # Smooth noise is told on as many vertices or more. By hand.
    fewest_to_tell_smooth: int = 1500
    # Evenness of the quiet part is that of the quietest `quiet_fraction` over this one.
    quieter_fraction: float = 0.3
    # How much stronger than noise the next wider band is, as a logarithm. Noise of depth cameras
    # has up to 0.53; fractal terrain, which has all other evidence for noise, 0.65 to 0.88, and a
    # held-out clean mesh of craters 0.60.
    told_excess: float = 0.55
    # Weights of misfit, evenness, outliers and lean in the evidence, its constant, and the least
    # with which noise is told. A logistic regression on 12 shapes with seven kinds of smooth noise
    # and 14 of detail, some too weak to be told; `research.denoising.smooth_evidence` judges them.
    evidence_weights: tuple[float, ...] = (-0.25, 4.4, -3.0, -0.62)
    evidence_constant: float = -5.96
    least_evidence: float = 0.85

    # noise/spikes
    # Quantile of the deviations from lines that is compared with their median, and that with the
    # same for normal noise on the same mesh. On 25 shapes normal noise of four kinds had 0.91 to
    # 1.16, but up to 2.24 on three with detail here and there; with heavy tails 1.33 to 1.76.
    tail_quantile: float = 0.99
    # That ratio at which noise begins to count as impulsive, and how far from there it surely is.
    normal_ratio: float = 1.2
    ratio_range: float = 0.1
    # The ratio of n values may be larger by this over √n. By hand.
    ratio_chance: float = 4.0
    # A spike stands out by this many times the median. By hand.
    spike_factor: float = 3.0


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
