// SPDX-License-Identifier: GPL-3.0-or-later

// Flamenco job type: fair many meshes, or the frames of one surface, on a render farm.
//
// Every task fairs one share of the meshes (`--shard i/n`), and a last one sums them up. A task may
// be run again at any time: what is finished is skipped, and outputs appear whole or not.

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
            description: "Folder with mesh files, or a pattern such as /scans/*.ply; for an " +
                "animation its .blend, .abc or .usd file. The workers must see it under this path",
        },
        {
            key: "mesh_count", type: "int32", default: 100, visible: "submission",
            eval: "sum(p.is_file() for p in Path(abspath(settings.input)).rglob('*'))",
            evalInfo: { showLinkButton: true, description: "Files in the input folder" },
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
            description: "Folder for the results, which the workers see under this path",
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
            key: "method", type: "string", default: "auto",
            choices: ["timestep", "tensor", "uniform", "auto"],
            description: "What follows the density: the timestep, the diffusion tensor, or " +
                "nothing; auto estimates the noise and needs neither Tau nor Steps",
        },
        {
            key: "strength", type: "float", default: 1.0,
            description: "Of the method auto: factor of the noise that it estimates",
        },
        { key: "tau", type: "float", default: 0.016, description: "Time of a step" },
        { key: "steps", type: "int32", default: 4, description: "Number of steps" },
        {
            key: "density", type: "string", default: "edge", choices: ["edge", "area"],
            description: "Measure of the density: mean edge length or area around a vertex",
        },
        {
            key: "boundary", type: "string", default: "fixed", choices: ["fixed", "free"],
            description: "Whether the rims of open meshes stay or move along",
        },
        {
            key: "same_strength", type: "bool", default: true,
            description: "Smooth every frame as the first one, so that nothing flickers. Unused " +
                "for single meshes",
        },
        {
            key: "keyed_file", type: "string", subtype: "file_path", default: "",
            description: "Frames only: a .blend file for one object that plays all of them",
        },
        {
            key: "jobs", type: "int32", default: 1,
            description: "Processes that a task works with at a time",
        },
        {
            key: "memory", type: "string", default: "",
            description: "Memory that the processes of a task may hold together, such as 8G. " +
                "Empty: what is free",
        },
        {
            key: "allow_failures", type: "bool", default: false,
            description: "Let the job succeed although meshes have failed; summary.json in the " +
                "output folder names them",
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
    const settings = job.settings;
    checkSettings(settings);
    const shares = shareCount(settings);
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

function checkSettings(settings) {
    if (settings.chunk_size < 1) {
        throw new Error("Chunk Size must be at least 1");
    }
    if (isAnimation(settings) && !settings.frames) {
        throw new Error("An animation needs Frames, such as 1-50");
    }
    if (settings.keyed_file && !isSequence(settings)) {
        throw new Error("Keyed File is for frames: single meshes do not become one object");
    }
}

function isAnimation(settings) {
    return settings.kind === "animation";
}

function isSequence(settings) {
    return settings.kind !== "meshes";
}

function meshCount(settings) {
    return isAnimation(settings) ? frameCount(settings.frames) : Math.max(settings.mesh_count, 1);
}

function shareCount(settings) {
    return Math.ceil(meshCount(settings) / settings.chunk_size);
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
    const options = ["--merge", "--report", path.join(settings.output_dir, "summary.json")];
    if (settings.keyed_file) {
        options.push("-o", settings.keyed_file);
    }
    if (settings.allow_failures) {
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
        args: ["-c", "adaptive_fairing", settings.input].concat(commonOptions(settings), options),
    }, steps);
}

// Options that the tasks of a job must have in common, so that the last one finds what the others
// have made.
function commonOptions(settings) {
    const options = [
        "--out-dir", settings.output_dir,
        "--method", settings.method,
        "--strength", String(settings.strength),
        "--tau", String(settings.tau),
        "--steps", String(settings.steps),
        "--density", settings.density,
        "--boundary", settings.boundary,
    ];
    // With a keyed file the format is fixed.
    if (settings.format && !settings.keyed_file) {
        options.push("--format", settings.format);
    } else if (settings.keyed_file) {
        options.push("--format", "ply");
    }
    if (settings.object) {
        options.push("--object", settings.object);
    }
    if (isAnimation(settings)) {
        options.push("--frames", settings.frames);
    } else if (isSequence(settings)) {
        options.push("--sequence");
    }
    if (isSequence(settings) && settings.same_strength) {
        options.push("--same-strength");
    }
    return options.concat(shellSplit(settings.more_arguments));
}
