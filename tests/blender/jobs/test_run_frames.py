"""Frames in memory: one strength for all, what they share, and when a run of them ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.meshes import noisy_ball, random_closed
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import MeshData, read_mesh
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.blender.jobs.frame_sequence import Preparations, run_frames, same_strength
from adaptive_fairing.blender.jobs.solve import Solve
from adaptive_fairing.core import DenoiseSettings, FairingSettings, PreparedMesh, denoise, fair


def surface(vertices, faces):
    return MeshData(np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int32))


class TestSameStrength:
    def test_it_keeps_the_scale_and_the_time_of_the_first_frame(self):
        vertices, faces = random_closed(1)
        settings, scale = same_strength(surface(vertices, faces), FairingSettings())
        tau = fair(vertices, faces, FairingSettings()).steps[0].tau
        assert settings.tau == pytest.approx(tau, rel=1e-9)
        assert replace(settings, tau=None) == FairingSettings()
        assert scale == pytest.approx(6 / np.ptp(vertices, axis=0).max())

    def test_it_leaves_no_stopping_rule(self):
        data = surface(*random_closed(1))
        asked = FairingSettings(tau=0.016, steps=20, stop_curvature=0.86)
        settings, _ = same_strength(data, asked)
        n_steps = len(fair(data.vertices, data.triangles, asked).steps)
        assert 1 < n_steps < 20
        assert settings == replace(asked, steps=n_steps, stop_curvature=None)


class TestRunFrames:
    def solves(self, settings, n_frames=3):
        vertices, faces = noisy_ball()
        return [
            Solve(vertices * [1 + 0.1 * i, 1, 1], faces, settings, name=f"Frame {i}")
            for i in range(n_frames)
        ]

    @pytest.mark.parametrize("settings", [FairingSettings(steps=2), DenoiseSettings()])
    def test_of_each_frame_the_result_is_kept(self, settings):
        solves = self.solves(settings)
        for _ in run_frames(solves, one_strength=False):
            pass
        run = denoise if settings == DenoiseSettings() else fair
        for solve in solves:
            mesh = PreparedMesh(solves[0].vertices, solve.triangles)
            alone = run(solve.vertices, solve.triangles, settings, prepared=mesh)
            assert np.array_equal(solve.positions, alone.positions.astype(np.float32))
            assert (solve.denoised, solve.steps, solve.prepared) == (None, [], None)

    def test_denoise_mixes_all_frames_as_the_first(self):
        first, second = solves = self.solves(DenoiseSettings(), n_frames=2)
        for _ in run_frames(solves, one_strength=True):
            pass
        scale = PreparedMesh(first.vertices, first.triangles).own_scale
        mesh = PreparedMesh(first.vertices, first.triangles, scale=scale)
        plan = denoise(first.vertices, first.triangles, prepared=mesh).plan
        alone = denoise(second.vertices, second.triangles, prepared=mesh, plan=plan)
        assert np.array_equal(second.positions, alone.positions.astype(np.float32))

    def test_a_cancelled_run_begins_no_other_frame(self):
        solves = self.solves(DenoiseSettings())
        frames = run_frames(solves, one_strength=False)
        assert next(frames) is solves[0]
        for solve in solves:
            solve.is_cancelled = True
        assert list(frames) == []
        assert [solve.has_result for solve in solves] == [True, False, False]
        assert solves[1].progress.fraction_done == solves[2].progress.fraction_done == 0


class TestPreparations:
    @pytest.fixture
    def place(self, tmp_path):
        path = tmp_path / "a.ply"
        export_mesh(add_object(*random_closed(1)), path, alone=True)
        return path, None

    def test_frames_with_the_same_triangles_share_one(self, place):
        preparations = Preparations()
        settings = FairingSettings()
        data = read_mesh(import_mesh(place[0]).data)
        preparations.turn_to(place, None, settings, scale=None, keep_axes=True)
        first = preparations.of(data, settings, None)
        moved = data._replace(vertices=data.vertices * [1, 2, 3])
        preparations.turn_to(place, None, settings, scale=None, keep_axes=True)
        assert preparations.of(moved, settings, None) is first
        assert first.plan is None

    def test_denoise_takes_the_mixture_of_the_first_frame(self, place):
        """With one strength for all; otherwise every frame finds its own."""
        settings = DenoiseSettings()
        data = read_mesh(import_mesh(place[0]).data)
        plan = denoise(data.vertices, data.triangles, settings).plan
        one, own = Preparations(), Preparations()
        one.turn_to(place, None, settings, scale=1.0, keep_axes=True)
        own.turn_to(place, None, settings, scale=None, keep_axes=True)
        shared = one.of(data, settings, 1.0).plan.mixtures
        for mixture, expected in zip(shared, plan.mixtures, strict=True):
            assert np.array_equal(mixture.by_class, expected.by_class)
        assert own.of(data, settings, None).plan is None

    def test_other_triangles_get_one_of_their_own(self, place):
        preparations = Preparations()
        settings = FairingSettings()
        preparations.turn_to(place, None, settings, scale=None, keep_axes=True)
        other = surface(*random_closed(2))
        found = preparations.of(other, settings, None)
        assert np.array_equal(found.mesh.triangles, other.triangles)
        assert preparations.of(other, settings, None) is not found

    def test_without_a_sequence_nothing_is_kept(self):
        preparations = Preparations()
        data = surface(*random_closed(2))
        preparations.turn_to(None, None, FairingSettings(), scale=None, keep_axes=True)
        first = preparations.of(data, FairingSettings(), None)
        assert preparations.of(data, FairingSettings(), None) is not first
