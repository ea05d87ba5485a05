// SPDX-License-Identifier: GPL-3.0-or-later

// Flamenco job type: fair many meshes, or the frames of one surface, on a render farm.
//
// Every task fairs one share of the meshes (`--shard i/n`), and a last one sums them up. A task may
// be run again at any time: what is finished is skipped, and outputs appear whole or not.

// The Manager checks little of what it is sent: settings may be missing or of any value. So this
// script does; what it throws is a text, which users get to see as it is.

const MESH_SUFFIXES = [
    ".blend", ".obj", ".ply", ".stl", ".glb", ".gltf", ".fbx", ".usd", ".usda", ".usdc", ".usdz",
    ".abc",
];

const JOB_TYPE = {
    label: "Adaptive Fairing",
    description: "Remove noise from many meshes, or from the frames of a moving surface",
    settings: [
        {
            key: "kind", type: "string", required: true, default: "meshes",
            choices: ["meshes", "numbered frames", "animation"],
            description: "What the input is: single meshes, files that are frames of one surface, " +
                "or one file with an animated object",
        },
        {
            key: "input", type: "string", subtype: "file_path", required: true,
            visible: "submission",
            description: "Folder with mesh files, or a pattern such as /scans/*.ply; for an " +
                "animation its .blend, .abc or .usd file. The workers must see it under this path",
        },
        {
            key: "input_path", type: "string", visible: "web",
            eval: "str(abspath(settings.input))",
            description: "Input, without the // that stands for the folder of the .blend file",
        },
        {
            key: "mesh_count", type: "int32", default: 100, visible: "submission",
            // Names that an expression is given are unknown inside of its loops.
            eval: "sum(name.lower().endswith(" +
                `(${MESH_SUFFIXES.map(suffix => `'${suffix}'`).join(", ")})` +
                ") for name in __import__('glob').glob(str(abspath(settings.input)) if " +
                "__import__('glob').has_magic(settings.input) else " +
                "__import__('glob').escape(str(abspath(settings.input))) + '/**', recursive=True))",
            evalInfo: { showLinkButton: true, description: "Mesh files of the input" },
            description: "About how many meshes there are: decides the number of tasks. Unused " +
                "for an animation",
        },
        {
            key: "frames", type: "string", default: "", visible: "submission",
            eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
            evalInfo: { showLinkButton: true, description: "Scene frame range" },
            description: "Frames of an animation. Examples: '47', '1-30', '3, 5-10, 47-327'",
        },
        {
            key: "chunk_size", type: "int32", default: 10, visible: "submission",
            description: "Meshes or frames in a task",
        },
        {
            key: "output_dir", type: "string", subtype: "dir_path", required: true,
            label: "Output Folder", visible: "submission",
            description: "Folder for the results, which the workers see under this path",
        },
        {
            key: "output_path", type: "string", visible: "web",
            eval: "str(abspath(settings.output_dir))",
            description: "Output folder, without the // of the .blend file's folder",
        },
        {
            key: "format", type: "string", default: "",
            description: "Kind of the results, such as ply. Empty: that of the input; ply for an " +
                "animation",
        },
        {
            key: "object", type: "string", default: "",
            description: "Mesh object to fair, if a file holds several",
        },
        {
            key: "algorithm", type: "string", default: "denoise", choices: ["denoise", "fair"],
            description: "denoise estimates the noise and needs Strength only. fair is the " +
                "diffusion of the paper and needs Scheme, Radius, Steps and Density",
        },
        {
            key: "strength", type: "float", default: 1.0,
            description: "Of denoise: factor of the noise that it estimates",
        },
        {
            key: "scheme", type: "string", default: "timestep",
            choices: ["timestep", "tensor", "uniform"],
            description: "Of fair: the density sets the timestep, the diffusion tensor, or nothing",
        },
        {
            key: "radius", type: "float", default: 0.5,
            description: "Of fair: smoothing radius after all steps, in local edge lengths",
        },
        {
            key: "tau", type: "float", default: 0.0,
            description: "Of fair: time of a step, instead of Radius. 0 takes the radius",
        },
        {
            key: "steps", type: "int32", default: 4,
            description: "Of fair: number of steps",
        },
        {
            key: "density", type: "string", default: "edge", choices: ["edge", "area"],
            description: "Of fair: measure of the density, mean edge length or area around a vertex",
        },
        {
            key: "boundary", type: "string", default: "fixed", choices: ["fixed", "free"],
            description: "Whether boundaries of open meshes stay or move along",
        },
        {
            key: "same_strength", type: "bool", default: true,
            description: "Smooth every frame as the first one, so that nothing flickers. Unused " +
                "for single meshes",
        },
        {
            key: "keyed", type: "string", subtype: "file_path", default: "",
            label: "Keyed File", visible: "submission",
            description: "Frames only: a .blend file for one object that plays all of them",
        },
        {
            key: "keyed_file", type: "string", visible: "web",
            eval: "str(abspath(settings.keyed)) if settings.keyed else ''",
            description: "Keyed file, without the // of the .blend file's folder",
        },
        {
            key: "jobs", type: "int32", default: 1, label: "Worker Processes",
            description: "Processes that a task works with at a time",
        },
        {
            key: "memory", type: "string", default: "",
            description: "Memory that the processes of a task may hold together, such as 8G. " +
                "Empty: what is free",
        },
        {
            key: "fail_on_error", type: "bool", default: false,
            description: "Let the job fail if meshes have failed. Otherwise it succeeds, and " +
                "summary.json in the output folder and the log of the last task name them",
        },
        {
            key: "more_arguments", type: "string", default: "", visible: "submission",
            description: "More of the program's arguments, such as --stop-curvature 0.5",
        },
        {
            key: "addon", type: "string", default: "bl_ext.user_default.adaptive_fairing",
            visible: "hidden",
            description: "Module of the extension on the workers",
        },
    ],
};

function compileJob(job) {
    const settings = completeSettings(job.settings);
    checkSettings(settings);
    const shares = Math.ceil(meshCount(settings) / settings.chunk_size);
    const fairing = [];
    for (let share = 1; share <= shares; share++) {
        const task = fairingTask(settings, share, shares);
        fairing.push(task);
        job.addTask(task);
    }
    const merge = mergeTask(settings);
    for (const task of fairing) {
        merge.addDependency(task);
    }
    job.addTask(merge);
}

// Settings that were not sent have their defaults; paths that nobody has evaluated stand as given.
function completeSettings(sent) {
    const empty = { string: "", int32: 0, float: 0, bool: false };
    const settings = {};
    for (const { key, type, default: start } of JOB_TYPE.settings) {
        const values = [sent[key], start, empty[type]];
        settings[key] = values.find(value => value !== undefined && value !== null);
    }
    settings.input_path = settings.input_path || settings.input;
    settings.output_path = settings.output_path || settings.output_dir;
    settings.keyed_file = settings.keyed_file || settings.keyed;
    return settings;
}

function checkSettings(settings) {
    for (const { key, choices } of JOB_TYPE.settings) {
        if (choices) {
            check(choices.includes(settings[key]),
                `${nameOf(key)} is "${settings[key]}", it must be one of: ${choices.join(", ")}`);
        }
    }
    check(settings.input_path, "Input is missing: give a folder, a pattern or a file");
    check(settings.output_path, "Output Folder is missing");
    for (const key of ["chunk_size", "jobs", "steps"]) {
        check(settings[key] >= 1, `${nameOf(key)} must be at least 1`);
    }
    for (const key of ["radius", "strength"]) {
        check(settings[key] > 0 && isFinite(settings[key]), `${nameOf(key)} must be above 0`);
    }
    check(settings.tau >= 0 && isFinite(settings.tau), "Tau must be above 0, or 0 to take Radius");
    check(/^(\d+(\.\d+)?\s*[KMGT]?B?)?$/i.test(settings.memory),
        `Memory is "${settings.memory}": give a size such as 8G, or nothing`);
    const suffix = "." + settings.format.toLowerCase().replace(/^\./, "");
    check(suffix === "." || MESH_SUFFIXES.includes(suffix),
        `Format is "${settings.format}", it must be one of: ${MESH_SUFFIXES.join(" ")}`);
    if (isSequence(settings)) {
        check(suffix !== ".blend", "Format: frames are written as mesh files, not as .blend");
    }
    if (isAnimation(settings)) {
        check(settings.frames.trim(), "An animation needs Frames, such as 1-50");
        frameNumbers(settings);
    }
    if (settings.keyed_file) {
        check(isSequence(settings),
            "Keyed File is for frames: single meshes do not become one object");
        check(settings.keyed_file.toLowerCase().endsWith(".blend"),
            "Keyed File must be the name of a .blend file");
        check([".", ".ply"].includes(suffix), "Format must be ply, or nothing, with a Keyed File");
    }
}

function check(isGood, message) {
    if (!isGood) {
        throw message;
    }
}

// The name that Blender shows for a setting.
function nameOf(key) {
    const { label } = JOB_TYPE.settings.find(setting => setting.key === key);
    return label || key.split("_").map(word => word[0].toUpperCase() + word.slice(1)).join(" ");
}

function isAnimation(settings) {
    return settings.kind === "animation";
}

function isSequence(settings) {
    return settings.kind !== "meshes";
}

// Every frame of the list as a text, ascending. All of Flamenco's notations are understood.
function frameNumbers(settings) {
    try {
        return frameChunker(settings.frames, 1);
    } catch (error) {
        throw `Frames is "${settings.frames}": ${error.message || error}`;
    }
}

function meshCount(settings) {
    return isAnimation(settings) ? frameNumbers(settings).length : Math.max(settings.mesh_count, 1);
}

function fairingTask(settings, share, shares) {
    const task = author.Task(`fair-${share}-of-${shares}`, "blender");
    // Each finished mesh is a line that Flamenco counts as a step.
    const steps = Math.ceil(meshCount(settings) / shares);
    const options = [
        "--shard", `${share}/${shares}`,
        "--jobs", String(settings.jobs),
        // A broken mesh is not the worker's fault: another one would fail at it, too.
        "--allow-failures",
        "--flamenco",
    ];
    if (settings.memory) {
        options.push("--memory", settings.memory);
    }
    task.addCommand(blenderCommand(settings, options, steps));
    return task;
}

function mergeTask(settings) {
    const task = author.Task("merge", "blender");
    const options = ["--merge", "--report", path.join(settings.output_path, "summary.json")];
    if (settings.keyed_file) {
        options.push("-o", settings.keyed_file);
    }
    if (!settings.fail_on_error) {
        // Otherwise every worker would try the merge, fail, and be kept from this kind of task.
        options.push("--allow-failures");
    }
    task.addCommand(blenderCommand(settings, options, 1));
    return task;
}

function blenderCommand(settings, options, steps) {
    return author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: ["--addons", settings.addon],
        blendfile: "",
        // What follows -c belongs to the program.
        args: ["-c", "adaptive_fairing", settings.algorithm, settings.input_path].concat(
            commonOptions(settings), options),
    }, steps);
}

// Options that the tasks of a job must have in common, so that the last one finds what the others
// have made.
function commonOptions(settings) {
    const options = [
        "--out-dir", settings.output_path,
        "--boundary", settings.boundary,
    ];
    if (settings.algorithm === "denoise") {
        options.push("--strength", decimal(settings.strength));
    } else {
        options.push(
            "--scheme", settings.scheme,
            ...(settings.tau > 0
                ? ["--tau", decimal(settings.tau)] : ["--radius", decimal(settings.radius)]),
            "--steps", String(settings.steps),
            "--density", settings.density);
    }
    if (settings.keyed_file) {
        options.push("--format", "ply");
    } else if (settings.format) {
        options.push("--format", settings.format);
    }
    if (settings.object) {
        options.push("--object", settings.object);
    }
    if (isAnimation(settings)) {
        const frames = frameNumbers(settings);
        options.push("--frames", frameChunker(settings.frames, frames.length)[0]);
    } else if (isSequence(settings)) {
        options.push("--sequence");
    }
    if (isSequence(settings) && settings.same_strength) {
        options.push("--same-strength");
    }
    return options.concat(shellSplit(settings.more_arguments));
}

// Blender sends numbers in single precision: 0.016 comes as 0.01600000075995922.
function decimal(value) {
    return String(Number(value.toPrecision(7)));
}
