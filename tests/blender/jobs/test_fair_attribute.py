"""Attributes are faired as the core does it, and nothing else of the mesh changes."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere, noisy_ball
from support.objects import add_object, add_rich_object, corners, numbers

from adaptive_fairing.blender.data.mesh_arrays import (
    STORAGE,
    read_attributes,
    read_mesh_coordinates,
    read_triangles,
)
from adaptive_fairing.blender.data.shape_keys import write_absolute_keys
from adaptive_fairing.blender.data.vertex_groups import add_weights, group_weights
from adaptive_fairing.blender.jobs.fair_attribute import LEAST_WEIGHT, fair_attribute
from adaptive_fairing.core import FairingSettings, InputError, fair_values

pytestmark = pytest.mark.usefixtures("addon")

SETTINGS = FairingSettings(radius=2.0, steps=2)


@pytest.fixture
def obj():
    return add_object(*noisy_ball(2, 0.02))


def add_attribute(obj, kind, values, domain="POINT", name="carried"):
    attribute = obj.data.attributes.new(name, kind, domain)
    attribute.data.foreach_set(STORAGE[kind][0], np.ascontiguousarray(values, np.float32).ravel())
    obj.data.update()


def read(obj, name="carried"):
    (found,) = [each for each in read_attributes(obj.data) if each.name == name]
    return found.values.reshape(len(found.values), -1)


def faired(obj, values, settings=SETTINGS):
    """What the core makes of values at the vertices."""
    values = np.asarray(values, dtype=np.float64).reshape(len(obj.data.vertices), -1)
    positions = read_mesh_coordinates(obj.data).astype(float)
    return fair_values(positions, read_triangles(obj.data), values, settings)[-1]


def random(obj, width, seed=0):
    values = np.random.default_rng(seed).uniform(size=(len(obj.data.vertices), width))
    return np.float32(values)


@pytest.mark.parametrize("kind", ["FLOAT", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR"])
def test_values_at_points_become_those_of_the_core(obj, kind):
    values = 5.0 * random(obj, STORAGE[kind][1]) - 3.0  # colours may be any light
    add_attribute(obj, kind, values)
    shape = read_mesh_coordinates(obj.data)
    result = fair_attribute(obj, "carried", SETTINGS)
    assert result == (len(values), 0)
    assert np.abs(read(obj) - values).max() > 0.5
    assert np.array_equal(read(obj), np.float32(faired(obj, values)))
    assert np.array_equal(read_mesh_coordinates(obj.data), shape)


def test_the_surface_is_the_one_that_is_shown():
    vertices, faces = noisy_ball(2, 0.02)
    obj = add_object(vertices, faces)
    stretched = np.float32(vertices * [1.0, 1.0, 4.0])
    write_absolute_keys(obj, [stretched])
    values = random(obj, 1)
    add_attribute(obj, "FLOAT", values)
    fair_attribute(obj, "carried", SETTINGS)
    expected = fair_values(stretched, faces, values, SETTINGS)[-1]
    assert np.array_equal(read(obj), np.float32(expected))
    assert not np.allclose(read(obj), faired(add_object(vertices, faces), values), atol=1e-3)


def test_a_vertex_of_weight_0_keeps_its_value(obj):
    values = random(obj, 1)
    add_attribute(obj, "FLOAT", values)
    weights = np.ones(len(values))
    weights[:20] = 0.0
    fair_attribute(obj, "carried", SETTINGS, weights=weights)
    assert np.array_equal(read(obj)[:20], values[:20])
    assert (read(obj)[20:] != values[20:]).all()


class TestCornerColors:
    def test_corners_that_agree_are_faired_as_their_points(self, obj):
        values = random(obj, 4)
        at = corners(obj.data)
        add_attribute(obj, "FLOAT_COLOR", values[at], "CORNER")
        fair_attribute(obj, "carried", SETTINGS)
        assert read(obj) == pytest.approx(faired(obj, values)[at], abs=1e-6)
        for each in range(len(values)):  # they go on agreeing to the last bit
            assert (read(obj)[at == each] == read(obj)[at == each][0]).all()

    def test_a_seam_keeps_its_step(self, obj):
        at = corners(obj.data)
        values = np.random.default_rng(1).uniform(size=(len(at), 4))
        add_attribute(obj, "FLOAT_COLOR", values, "CORNER")

        def differences(colors):
            return [colors[at == each] - colors[at == each].mean(axis=0) for each in range(9)]

        before, was = differences(read(obj)), read(obj)
        fair_attribute(obj, "carried", SETTINGS)
        for now, then in zip(differences(read(obj)), before, strict=True):
            assert now == pytest.approx(then, abs=1e-6)
        means = np.array([was[at == each].mean(axis=0) for each in range(len(obj.data.vertices))])
        means_now = np.array([read(obj)[at == each].mean(axis=0) for each in range(len(means))])
        assert means_now == pytest.approx(faired(obj, means), abs=1e-6)


class TestLimits:
    settings = FairingSettings(radius=0.3)
    """Values go furthest past a step where diffusion spreads over less than an edge."""

    @pytest.fixture
    def step(self):
        """A sphere, and a sharp step from 0 to 1 at its equator."""
        vertices, faces = icosphere(3)
        return add_object(vertices, faces), (vertices[:, 2] > 1e-6).astype(np.float32)

    def test_byte_colours_stay_within_their_range_and_it_is_told(self, step):
        obj, values = step
        add_attribute(obj, "BYTE_COLOR", np.repeat(values[:, None], 4, axis=1))
        beyond = faired(obj, values, self.settings)
        assert beyond.min() < -0.01 and beyond.max() > 1.01  # there is no maximum principle
        result = fair_attribute(obj, "carried", self.settings)
        assert result.n_limited == 4 * ((beyond < -1e-3) | (beyond > 1.001)).sum()
        assert read(obj).min() == 0.0
        assert read(obj).max() == 1.0
        # A byte holds the code of the colour in 255 steps; 1/255 of code is at most 0.01 of light.
        assert np.abs(read(obj)[:, :1] - np.clip(beyond, 0, 1)).max() < 0.01

    def test_weights_of_a_group_too_and_neighbours_enter_it(self, step):
        obj, values = step
        group, other = (obj.vertex_groups.new(name=name) for name in ("half", "other"))
        inside = np.flatnonzero(values > 0)
        for each in (group, other):
            add_weights(each, inside, values[inside])
        expected = np.clip(faired(obj, values, self.settings)[:, 0], 0, 1)
        result = fair_attribute(obj, "half", self.settings)
        assert result.n_limited > 0
        weights = group_weights(obj, group)
        assert weights == pytest.approx(expected, abs=LEAST_WEIGHT)
        assert 0 < ((weights > 0) & (values == 0)).sum() < (values == 0).sum()
        assert np.array_equal(group_weights(obj, other), values)


def test_a_constant_stays_as_it_is(obj):
    add_attribute(obj, "FLOAT_COLOR", np.tile([0.1, 0.2, 0.3, 1.0], (len(obj.data.vertices), 1)))
    before = read(obj)
    fair_attribute(obj, "carried", SETTINGS)
    assert np.array_equal(read(obj), before)


def test_nothing_else_of_the_mesh_changes():
    obj = add_rich_object()
    before = {each.name: each for each in read_attributes(obj.data)}
    shape = read_mesh_coordinates(obj.data)
    fair_attribute(obj, "heat", SETTINGS)
    after = {each.name: each for each in read_attributes(obj.data)}
    assert before.keys() == after.keys()
    differs = {name for name in before if not np.array_equal(before[name][3], after[name][3])}
    assert differs == {"heat"}
    assert np.array_equal(read_mesh_coordinates(obj.data), shape)
    assert obj.data.attributes.active_color_name == "Paint"


class TestRefusals:
    def test_an_unknown_name_is_told_those_that_there_are(self):
        obj = add_rich_object()
        obj.vertex_groups.new(name="Weights")
        with pytest.raises(InputError) as caught:
            fair_attribute(obj, "Heat", SETTINGS)
        text = str(caught.value)
        assert text.startswith("there is no 'Heat' on the mesh, but ")
        assert set(text.partition("but ")[2].split(", ")) == {"'Paint'", "'heat'", "'Weights'"}

    def test_without_anything_that_is_said(self, obj):
        with pytest.raises(
            InputError, match="no 'Col' on the mesh, nor anything else that can be faired"
        ):
            fair_attribute(obj, "Col", SETTINGS)

    @pytest.mark.parametrize(
        ("kind", "domain", "reason"),
        [
            ("INT", "POINT", "only numbers, vectors and colors can be faired"),
            ("FLOAT", "FACE", "only values at vertices and colors of face corners can be faired"),
            (
                "FLOAT2",
                "CORNER",
                "only values at vertices and colors of face corners can be faired",
            ),
        ],
    )
    def test_what_cannot_be_faired_is_said(self, obj, kind, domain, reason):
        obj.data.attributes.new("carried", kind, domain)
        with pytest.raises(InputError, match=f"'carried': {reason}"):
            fair_attribute(obj, "carried", SETTINGS)

    def test_the_shape_itself_is_no_attribute_to_fair(self, obj):
        with pytest.raises(InputError, match="'position': only numbers"):
            fair_attribute(obj, "position", SETTINGS)

    def test_a_locked_group_stays(self, obj):
        obj.vertex_groups.new(name="half").lock_weight = True
        with pytest.raises(InputError, match="'half' is locked"):
            fair_attribute(obj, "half", SETTINGS)

    def test_without_faces_there_is_no_surface(self):
        obj = add_object([[0, 0, 0], [1, 0, 0]], [])
        add_attribute(obj, "FLOAT", [1.0, 2.0])
        with pytest.raises(InputError, match="no faces"):
            fair_attribute(obj, "carried", SETTINGS)

    def test_values_that_are_not_finite_are_left_as_they_are(self, obj):
        values = random(obj, 1)
        values[7] = np.nan
        add_attribute(obj, "FLOAT", values)
        with pytest.raises(InputError, match="1 vertices have values that are not finite"):
            fair_attribute(obj, "carried", SETTINGS)
        assert np.array_equal(numbers(obj.data, "carried")[:, None], values, equal_nan=True)

    def test_a_linked_mesh_is_left_alone(self, obj, tmp_path):
        add_attribute(obj, "FLOAT", random(obj, 1))
        path = str(tmp_path / "library.blend")
        bpy.data.libraries.write(path, {obj})
        bpy.data.objects.remove(obj)
        with bpy.data.libraries.load(path, link=True) as (source, target):
            target.objects = source.objects
        with pytest.raises(InputError, match="linked from another file"):
            fair_attribute(target.objects[0], "carried", SETTINGS)
