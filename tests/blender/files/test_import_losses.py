"""Losses of importers are counted and told."""

import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.files.import_losses import import_notes
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.core import FairingSettings

OBJ = """
# a fan around vertex 1, some faces broken
v 0 0 0
v 1 0 0
v 0 1 0
v -1 0 0
v 0 -1 0.1
v 9 9 9
f 1 2 3
f 1 3 4
f 1/1/1 4/1/1 5/1/1
f 3 1 2
f 2 2 5
"""


def test_lost_vertices_and_faces_are_told(tmp_path):
    path = tmp_path / "bad.obj"
    path.write_text(OBJ)
    import_mesh(path)
    expected = [
        "Blender leaves out 1 vertices that no face uses and "
        "2 faces that repeat a vertex or another face"
    ]
    assert import_notes(path) == expected
    report = run_job(FairingJob(path, tmp_path / "out.obj", FairingSettings(steps=1)))
    assert report["notes"] == expected


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".blend"])
def test_whole_files_have_no_notes(tmp_path, suffix):
    path = tmp_path / f"good{suffix}"
    obj = add_object(*icosphere(1))
    if suffix == ".blend":
        from adaptive_fairing.blender.files.mesh_files import save_blend

        save_blend(path)
    else:
        export_mesh(obj, path, alone=True)
    import_mesh(path)
    assert import_notes(path) == []


def test_a_ply_with_a_repeated_face(tmp_path):
    path = tmp_path / "bad.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n3 0 1 2\n3 1 2 3\n"
    )
    import_mesh(path)
    assert import_notes(path) == ["Blender leaves out 1 faces that repeat a vertex or another face"]
