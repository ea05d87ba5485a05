"""Settings of a run as Blender properties: its computation and its result.

`SolverProperties` and `OutputProperties` are mix-ins. The operators have them as their own
properties, so that scripts, the redo panel and undo work; the scene keeps another set that the
panel edits, presets store and the file saves.
"""

from __future__ import annotations

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .choices import ALGORITHMS, DENOISE, EVOLUTION, LIVE, RESULTS, SCHEMES

CONTEXT = "Adaptive Fairing"
"""Translation context of texts that Blender would translate wrongly or too long."""


class SolverProperties:
    """The algorithm, and the fields of the core's two settings under the same names."""

    algorithm: EnumProperty(
        name="Algorithm",
        description="Algorithm that removes the noise",
        items=ALGORITHMS,
        default=DENOISE,
    )
    scheme: EnumProperty(
        name="Scheme",
        description="How the smoothing follows the density of the mesh",
        items=SCHEMES,
        default="TIMESTEP",
    )
    strength: FloatProperty(
        name="Strength",
        description=(
            "How much of the estimated noise to remove: raise it if noise is left, lower it if "
            "details disappear"
        ),
        default=1.0,
        min=0.01,
        soft_min=0.25,
        soft_max=4.0,
        max=99.0,
        step=5,
        precision=2,
    )
    features: EnumProperty(
        name="Edges",
        translation_context=CONTEXT,
        description="Whether the smoothing keeps sharp edges",
        items=(
            ("auto", "Automatic", "Decide for every part of the mesh"),
            ("sharp", "Keep Sharp", "The mesh has sharp edges, which are kept as far as possible"),
            ("smooth", "Smooth", "The mesh has no sharp edges: what looks like one is noise"),
        ),
        default="auto",
    )
    width: FloatProperty(
        name="Noise Size",
        description=(
            "Size of the noise in edges, up to 16: about half the size of its bumps, 1 if it "
            "differs from vertex to vertex. Below 1 it is estimated; noise of a given size is "
            "removed even from a mesh that looks clean"
        ),
        default=0.0,
        min=0.0,
        max=16.0,
        step=50,
        precision=1,
    )
    clean: EnumProperty(
        name="Clean Meshes",
        description="What happens to a mesh that looks like a model without noise",
        items=(
            ("keep", "Leave Alone", "Change nothing, and say why"),
            (
                "detail",
                "Keep Fine Detail",
                "Leave clean meshes alone, and also keep detail that looks like the smooth noise "
                "of a scanner",
            ),
            ("denoise", "Denoise", "Treat all roughness as noise"),
        ),
        default="keep",
    )
    radius: FloatProperty(
        name="Radius",
        description=(
            "Smoothing radius of all steps together, in local edge lengths: about 0.5 removes "
            "noise only, 3 and more removes shapes of that size as well"
        ),
        default=0.5,
        min=0.01,
        soft_min=0.2,
        soft_max=10.0,
        step=5,
        precision=2,
    )
    use_tau: BoolProperty(
        name="τ of the Paper",
        description=(
            "Give the timestep τ of the paper instead of the radius. Its effect depends on how "
            "dense the mesh is"
        ),
        default=False,
    )
    tau: FloatProperty(
        name="τ",
        description=(
            "Time of one step, with the mesh scaled to the box [-3, 3]³: "
            "larger values smooth over larger distances"
        ),
        default=0.016,
        min=0.0,
        soft_min=0.0001,
        soft_max=0.5,
        step=0.1,
        precision=4,
    )
    steps: IntProperty(
        name="Steps",
        translation_context=CONTEXT,
        description="How many steps to take; each one is kept",
        default=4,
        min=1,
        soft_max=20,
        max=1000,
    )
    density: EnumProperty(
        name="Measure",
        translation_context=CONTEXT,
        description="How the density of the mesh is measured",
        items=(
            ("EDGE", "Edge Length", "Mean length of the edges at a vertex"),
            (
                "AREA",
                "Area",
                "Area of the triangles around a vertex; the smoothing radius is then the same "
                "number of edges everywhere",
            ),
        ),
        default="EDGE",
    )
    density_passes: IntProperty(
        name="Passes",
        translation_context=CONTEXT,
        description="How often the measured density is smoothed before it is used",
        default=3,
        min=0,
        soft_max=10,
        max=100,
    )
    boundary: EnumProperty(
        name="Boundary",
        translation_context=CONTEXT,
        description="What happens to the boundary of an open mesh",
        items=(
            ("fixed", "Fixed", "Boundary vertices stay exactly where they are"),
            ("free", "Free", "The boundary is smoothed along with the surface, and may shrink"),
        ),
        default="fixed",
    )
    keep_volume: BoolProperty(
        name="Keep Volume",
        description=(
            "Move every closed part along its normals after each step, so that it keeps its volume"
        ),
        default=False,
    )
    max_deviation: FloatProperty(
        name="Max Deviation",
        description="No vertex moves further than this from where it started; 0 sets no limit",
        default=0.0,
        min=0.0,
        soft_max=10.0,
        step=1,
        precision=4,
        unit="LENGTH",
    )
    stop_curvature: FloatProperty(
        name="Stop at H",
        description=(
            "Stop once this fraction of the curvature energy H is left; 0 takes every step"
        ),
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=3,
    )
    stop_rate: FloatProperty(
        name="Stop at Rate",
        description=(
            "Stop once the fraction of the curvature energy H that is left changes by less than "
            "this per unit of time; 0 takes every step"
        ),
        default=0.0,
        min=0.0,
        soft_max=10.0,
        precision=3,
    )
    cg_tolerance: FloatProperty(
        name="Tolerance",
        description="Relative residual at which the linear system of a step counts as solved",
        default=1e-6,
        min=1e-12,
        max=0.1,
        precision=7,
        step=0.0001,
    )
    cg_max_iterations: IntProperty(
        name="Iterations",
        translation_context=CONTEXT,
        description="Give up a step after this many iterations of the linear solver",
        default=5000,
        min=1,
        soft_max=10000,
    )
    quadrature_tolerance: FloatProperty(
        name="Integration",
        description="Error of the integrals over the surface, relative to the largest one",
        default=1e-3,
        min=1e-6,
        max=0.1,
        precision=6,
        step=0.01,
    )
    normalize: EnumProperty(
        name="Scale To",
        translation_context=CONTEXT,
        description=(
            "Size that the mesh is scaled to if τ is given, so that τ does not depend on the "
            "size of the mesh"
        ),
        items=(
            ("BOX", "Box", "The box [-3, 3]³"),
            (
                "SPHERE",
                "Sphere",
                "A sphere of radius 3: a turned mesh gives the same result",
            ),
            ("NONE", "Nothing", "The mesh keeps its size: τ is in squared object units"),
        ),
        default="BOX",
    )


class OutputProperties:
    """Region of the smoothing, and kind of the result."""

    use_region: BoolProperty(
        name="Selection or Mask",
        description=(
            "In Edit Mode smooth the selected vertices only, if any are selected; in Sculpt Mode "
            "leave out the masked ones"
        ),
        default=True,
    )
    vertex_group: StringProperty(
        name="Vertex Group",
        translation_context=CONTEXT,
        description="Smooth by the weights of this group; empty for the whole mesh",
    )
    invert_vertex_group: BoolProperty(
        name="Invert",
        description="Smooth where the weights of the group are small instead",
        default=False,
    )
    hold_sharp: BoolProperty(
        name="Hold Sharp Edges",
        description="Vertices of edges that are marked sharp stay where they are",
        default=False,
    )
    from_original: BoolProperty(
        name="From Original",
        description=(
            "Start from the shape before the first run, and discard what the runs have done since; "
            "otherwise start from the shape that is shown"
        ),
        default=False,
    )
    result: EnumProperty(
        name="Result",
        description="What the object gets",
        items=RESULTS,
        default=LIVE,
    )
    output: EnumProperty(
        name="Steps As",
        description="What the object gets",
        items=(
            (
                EVOLUTION,
                "Evolution",
                "Every step as an absolute shape key: one slider runs through them",
            ),
            (
                "RELATIVE_KEYS",
                "Relative Shape Keys",
                "Every step as a relative shape key",
            ),
            ("FINAL_SHAPE", "Final Shape Only", "Move the vertices; no shape keys"),
        ),
        default=EVOLUTION,
    )
    existing_keys: EnumProperty(
        name="Other Keys",
        description="What to do with an object that has shape keys of its own",
        items=(
            ("COPY", "Work on a Copy", "Leave the object as it is, hide it, and fair a copy"),
            ("REFUSE", "Refuse", "Leave the object as it is and say so"),
        ),
        default="COPY",
    )
    store_density: BoolProperty(
        name="Density Attribute",
        description=(
            "Store the density of the mesh as fairing_density and fairing_density_color; "
            "Adaptive Fairing always does"
        ),
        default=False,
    )
