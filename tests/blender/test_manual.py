"""The code on the manual's pages that needs Blender runs, and changes the active mesh."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, shown_positions
from support.pages import blocks

EXAMPLES = [block for block in blocks("python") if "import bpy" in block.text]


@pytest.mark.parametrize("block", EXAMPLES, ids=str)
def test_an_example_runs(addon, block):
    vertices, faces = icosphere(3)
    noise = np.random.default_rng(3).normal(0.0, 0.02, len(vertices))
    obj = add_object(vertices * (1.0 + noise[:, None]), faces)
    obj.select_set(True)
    before = shown_positions(obj)
    exec(compile(block.text, str(block), "exec"), {})
    assert not np.array_equal(shown_positions(bpy.context.active_object), before)
