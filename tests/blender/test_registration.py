"""Enabling and disabling the add-on: cheap, complete, repeatable."""

import subprocess
import sys
import textwrap
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[2]


def in_a_fresh_blender(script):
    """Run Python with bpy in a process of its own and give what it prints.

    A script that registers must unregister, as Blender does when it quits: else bpy 4.2 and 4.5
    crash at exit.
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip().splitlines()


def test_enabling_imports_neither_scipy_nor_the_core():
    printed = in_a_fresh_blender(
        """
        import sys, bpy
        import adaptive_fairing.blender as addon
        addon.register()
        heavy = [n for n in sys.modules if n.startswith(("scipy", "adaptive_fairing.core"))]
        print(heavy)
        addon.unregister()
        """
    )
    assert printed[-1] == "[]"


def test_blender_has_nothing_to_warn_of_even_in_debug_mode():
    """Blender 5.2 wants groups of properties to have no attributes of their own."""
    script = "import bpy; bpy.app.debug = bpy.app.debug_python = True\n"
    script += "import adaptive_fairing.blender as addon\naddon.register()\naddon.unregister()"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=True
    )
    warnings = [line for line in done.stderr.splitlines() if "warning" in line.lower()]
    assert warnings == []


def test_disabling_takes_everything_back_twice():
    printed = in_a_fresh_blender(
        """
        import bpy
        import adaptive_fairing.blender as addon

        def footprint():
            handlers = bpy.app.handlers
            menus = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh_vertices", "VIEW3D_MT_sculpt")
            drawn = [getattr(getattr(bpy.types, m).draw, "_draw_funcs", []) for m in menus]
            keys = bpy.context.window_manager.keyconfigs.addon.keymaps
            items = [item for keymap in keys for item in keymap.keymap_items]
            return (
                [i.idname for i in items if "fairing" in i.idname],
                {n for n in dir(bpy.types) if "fairing" in n.lower()},
                [h for h in handlers.load_post if "fairing" in h.__module__],
                [h for h in handlers.load_pre if "fairing" in h.__module__],
                [f for fs in drawn for f in fs if "fairing" in f.__module__],
                hasattr(bpy.types.Scene, "adaptive_fairing"),
                hasattr(bpy.types.Object, "adaptive_fairing"),
                [p for p in bpy.utils._preset_path_registry if "fairing" in p],
            )

        for _ in range(2):
            addon.register()
            assert all(footprint()), footprint()
            addon.unregister()
            print(footprint())
        """
    )
    assert printed[-2:] == [str(([], set(), [], [], [], False, False, []))] * 2


def test_without_scipy_it_registers_and_the_operator_says_what_to_do():
    printed = in_a_fresh_blender(
        """
        import sys
        sys.modules["scipy"] = None
        import bpy
        import adaptive_fairing.blender as addon
        addon.register()
        bpy.ops.mesh.primitive_monkey_add()
        try:
            bpy.ops.object.adaptive_fairing(algorithm="FAIR")
        except RuntimeError as error:
            print("SAID", str(error).strip())
        addon.unregister()
        """
    )
    (said,) = [line for line in printed if line.startswith("SAID")]
    assert "scipy is missing: install" in said


@pytest.mark.usefixtures("addon")
class TestNames:
    def classes(self):
        return [getattr(bpy.types, name) for name in dir(bpy.types) if "adaptive_fairing" in name]

    def test_every_operator_is_described_and_belongs_to_the_add_on(self):
        operators = [each for each in self.classes() if issubclass(each, bpy.types.Operator)]
        assert operators
        for operator in operators:
            assert operator.bl_idname.startswith(("object.adaptive_fairing", "OBJECT_OT_adaptive"))
            assert operator.bl_description
            assert not operator.bl_description.endswith(".")

    def test_every_property_has_a_name_and_a_tooltip(self):
        for name in (
            "adaptive_fairing",
            "adaptive_fairing_compare",
            "adaptive_fairing_loop_subdivide",
            "adaptive_fairing_view",
        ):
            for found in getattr(bpy.ops.object, name).get_rna_type().properties:
                if found.identifier != "rna_type":
                    assert found.name, (name, found.identifier)
                    assert found.description, (name, found.identifier)
                    assert not found.description.endswith("."), (name, found.identifier)
