"""Triangles of uncommon classes are integrated together: all triangles once, the same integrals."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LoopSpace, TriangleTopology
from adaptive_fairing.core.loop import partition
from adaptive_fairing.core.loop.partition import chunk_triangles, triangle_slabs

N_TRIANGLES = 4 * partition.SMALL_SLAB


def classes(n_uncommon, n_each=40):
    """Classes of triangles: a common one, and uncommon ones all over the mesh."""
    class_of = np.zeros(N_TRIANGLES, dtype=np.int64)
    places = np.random.default_rng(0).permutation(N_TRIANGLES)[: n_uncommon * n_each]
    class_of[places] = 1 + np.arange(len(places)) % n_uncommon
    return class_of, np.bincount(class_of)


def test_every_triangle_is_in_one_chunk():
    class_of, sizes = classes(100)
    chunks = chunk_triangles(class_of, sizes)
    assert all(len(chunk) and (np.diff(chunk) > 0).all() for chunk in chunks)
    np.testing.assert_array_equal(np.sort(np.concatenate(chunks)), np.arange(N_TRIANGLES))


def test_uncommon_classes_have_chunks_of_their_own():
    class_of, sizes = classes(100)
    slabs = triangle_slabs(N_TRIANGLES)
    chunks = chunk_triangles(class_of, sizes)
    assert len(slabs) == 4
    for slab, chunk in zip(slabs, chunks, strict=False):
        own = np.arange(slab.start, slab.stop)
        np.testing.assert_array_equal(chunk, own[class_of[slab] == 0])
    first, second = chunks[4:]
    middle = slabs[2].start
    np.testing.assert_array_equal(first, np.flatnonzero(class_of[:middle]))
    np.testing.assert_array_equal(second, middle + np.flatnonzero(class_of[middle:]))


@pytest.mark.parametrize(
    ("n_uncommon", "n_each"),
    [(partition.FEWEST_UNCOMMON - 1, 40), (100, 4 * partition.UNCOMMON_PER_SLAB), (150, 80)],
    ids=["too few classes", "none is uncommon", "most triangles are uncommon"],
)
def test_otherwise_chunks_are_slabs(n_uncommon, n_each):
    class_of, sizes = classes(n_uncommon, n_each)
    for slab, chunk in zip(
        triangle_slabs(N_TRIANGLES), chunk_triangles(class_of, sizes), strict=True
    ):
        np.testing.assert_array_equal(chunk, np.arange(slab.start, slab.stop))


@pytest.mark.parametrize("largest_table", [0, 10**6], ids=["searched", "from a table"])
def test_matrices_do_not_depend_on_the_chunks(largest_table, monkeypatch):
    monkeypatch.setattr(partition, "SMALL_SLAB", 100)
    monkeypatch.setattr(partition, "FEWEST_UNCOMMON", 1)
    monkeypatch.setattr(
        "adaptive_fairing.core.linalg.symmetric_pattern.LARGEST_TABLE", largest_table
    )
    vertices, faces = meshes.random_closed(4, meshes.icosphere(3))
    topology = TriangleTopology(faces, len(vertices))
    timestep = np.linspace(1, 2, len(vertices))

    def everything(uncommon):
        monkeypatch.setattr(partition, "UNCOMMON_PER_SLAB", uncommon)
        space = LoopSpace(topology)
        system = space.step_system(vertices, timestep=timestep)
        measures = system.measures
        return len(space._chunks), (
            system.matrix.full().toarray(),
            system.load,
            np.array([measures.curvature_energy, measures.area, measures.volume]),
        )

    (n_slabs, apart), (n_chunks, together) = everything(0), everything(2)
    assert n_chunks > n_slabs >= 4
    for expected, found in zip(apart, together, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-13 * np.abs(expected).max())
