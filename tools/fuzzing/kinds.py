"""The kinds of inputs: what is mutated, and the commands that a user would give it to."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from random import Random

from fuzzing import archives
from fuzzing.commands import option_command, put_no_file, reading_command
from fuzzing.descriptions import adaptation, creature, scone, study
from fuzzing.held import ROBOT
from fuzzing.model_links import linked
from fuzzing.models import MODELS, MOVING, mutated_attributes, mutated_model, mutated_numbers
from fuzzing.recordings import recording
from fuzzing.seeds import LAYERED, MORE, RUN, SCENES, SIMBICON
from fuzzing.setting import EXPORTS, KINDS_OF_FIGURES, SHORT, Command, Setting, scene_commands
from fuzzing.tables import changed, paths
from fuzzing.texts import damaged, mutated
from fuzzing.values import NAMES, NUMBERS, WORDS, toml_text, toml_value, value
from fuzzing.worlds import world


def scene_values(rng: Random, at: Setting) -> list[Command]:
    """A whole scene with other values, types, names or structure."""
    name = rng.choice(SCENES)
    data = tomllib.loads((at.seeds / f"{name}.toml").read_text())
    (at.folder / "scene.toml").write_text(toml_text(changed(data, rng)))
    return scene_commands("scene.toml", rng, name in RUN)


def scene_text(rng: Random, at: Setting) -> list[Command]:
    """The text of a scene, of one based on others, or of those."""
    _layers(at)
    if rng.random() < 0.5:
        shutil.copy(at.seeds / f"{rng.choice(SCENES)}.toml", at.folder / "scene.toml")
    target = at.folder / rng.choice(["scene.toml", "scene.toml", "more.toml"])
    target.write_bytes(mutated(target.read_text(), rng))
    return scene_commands("scene.toml", rng)


def scene_layers(rng: Random, at: Setting) -> list[Command]:
    """Bases, characters and motions that lead nowhere, in a circle, or out of the folder."""
    _layers(at)
    where = [
        "scene.toml", "more.toml", "fwalk.toml", "biped.toml", ".", "..", "/", "/etc/passwd", "../secret.h5",
        str(at.secret), "missing.toml", "x\0y", "deep0.toml", *NAMES[:12],
    ]  # fmt: skip
    for k in range(60):
        (at.folder / f"deep{k}.toml").write_text(f'name = "deep"\nbase = "deep{k + 1}.toml"\n')
    last = rng.choice(["deep0.toml", "fwalk.toml", "scene.toml"])
    (at.folder / "deep60.toml").write_text(f'name = "last"\nbase = "{last}"\n')
    text = {"base": rng.choice(where), "name": rng.choice(["mine", *NAMES])}
    match rng.randrange(4):
        case 0:
            text["character"] = rng.choice([rng.choice(where), [rng.choice(where), rng.choice(where)], []])
        case 1:
            text |= {"tracking": {rng.choice(["file", "scene"]): rng.choice(where)}, "objective": {"tracking": 1.0}}
        case 2:
            text["muscle_model"] = {"active_force_length": rng.choice(["os:system", "more:x", *NAMES])}
    if rng.random() < 0.5:
        text["base"] = "fwalk.toml"
    (at.folder / "scene.toml").write_text(toml_text(text))
    return scene_commands("scene.toml", rng)


def simbicon(rng: Random, at: Setting) -> list[Command]:
    """Files of the original program."""
    files = _three(rng, at)
    target = rng.choice(files)
    path = at.folder / target
    path.write_bytes(mutated(path.read_bytes().decode("latin-1"), rng))
    commands = scene_commands(files[0], rng)
    return [[part for word in command for part in (files if word == files[0] else [word])] for command in commands]


def osim(rng: Random, at: Setting) -> list[Command]:
    """Models of OpenSim."""
    name = rng.choice(list(MODELS))
    (at.folder / name).write_bytes(mutated_model(MODELS[name], rng))
    return scene_commands(name, rng, simulated=False)


def osim_moving(rng: Random, at: Setting) -> list[Command]:
    """Models of OpenSim that move for a moment."""
    name = rng.choice(list(MOVING))
    (at.folder / name).write_bytes(rng.choice([mutated_model, mutated_numbers, mutated_numbers])(MOVING[name], rng))
    options = rng.choice(([], ["--hard-points"], ["--merge-welds"], ["--limit-stiffness", "100"]))
    return [["simulate", name, "--duration", "0.05", *options, "-o", "out.h5"]]


def osim_linked(rng: Random, at: Setting) -> list[Command]:
    """Models of OpenSim whose parts refer to others than they did, or whose numbers are written in other ways."""
    name = rng.choice(list(MOVING))
    (at.folder / name).write_bytes(linked(MOVING[name], rng))
    return scene_commands(name, rng, simulated=False)


def mujoco(rng: Random, at: Setting) -> list[Command]:
    """Models of MuJoCo."""
    (at.folder / "robot.xml").write_bytes(mutated_attributes(ROBOT, rng))
    return scene_commands("robot.xml", rng, simulated=False)


def hdf5_structure(rng: Random, at: Setting) -> list[Command]:
    """Result files whose groups, datasets, links and attributes are others."""
    return _hdf5(rng, at, lambda path: archives.change_structure(path, rng, at.secret))


def hdf5_values(rng: Random, at: Setting) -> list[Command]:
    """Result files with other numbers and texts."""
    return _hdf5(rng, at, lambda path: archives.change_values(path, rng))


def policy(rng: Random, at: Setting) -> list[Command]:
    """Policies with other structure, weights, names, task or scene."""
    at.copy("policy.h5", "fwalk.toml")
    path = at.folder / "policy.h5"
    choice = rng.randrange(5)
    if choice == 0:
        archives.change_structure(path, rng, at.secret)
    elif choice == 1:
        archives.change_values(path, rng)
    elif choice == 2:
        path.write_bytes(damaged(path.read_bytes(), rng))
    elif choice == 3:
        archives.change_task(path, rng)
    else:
        archives.change_policy(path, rng, at.secret)
    run: list[Command] = [["simulate", "fwalk.toml", *SHORT, "--policy", "policy.h5", "-o", "out.h5"]]
    judged: list[Command] = [
        ["judge", "policy.h5", "--json", "out.json"],
        ["judge", "fwalk.toml", *SHORT, "--policy", "policy.h5"],
    ]
    read: list[Command] = [
        ["report", "policy.h5"], ["plot", "policy.h5", "--what", rng.choice(KINDS_OF_FIGURES), "-o", "a.png"],
        ["view", "policy.h5", "--export", "out.html"], ["export", "policy.h5", "-o", rng.choice(EXPORTS)],
        ["apply", "policy.h5", "-o", "out.toml"], ["optimize", "--resume", "policy.h5", "--candidates", "2"],
        ["learn", "--resume", "policy.h5"], ["gait", "policy.h5"],
    ]  # fmt: skip
    return [rng.choice(run if rng.random() < 0.6 else judged if rng.random() < 0.1 else read)]


def journal(rng: Random, at: Setting) -> list[Command]:
    """The journal of a search that was killed."""
    at.copy("killed.h5", "killed.h5.journal")
    path = at.folder / "killed.h5.journal"
    path.write_bytes(archives.change_journal(path.read_bytes(), rng))
    return [["optimize", "--resume", "killed.h5", "--candidates", "2"], ["report", "killed.h5"]]


def sweep(rng: Random, at: Setting) -> list[Command]:
    """Sweep files, and what a sweep has left behind."""
    at.copy("sweep.toml")
    path = at.folder / "sweep.toml"
    choice = rng.randrange(3)
    if choice == 0:
        path.write_bytes(mutated(path.read_text(), rng))
    elif choice == 1:
        path.write_text(toml_text(changed(tomllib.loads(path.read_text()), rng)))
    else:
        at.copy("one.toml", "swept.h5")
        shutil.copytree(at.seeds / "swept.sweep", at.folder / "swept.sweep")
        files = sorted(file for file in (at.folder / "swept.sweep").rglob("*") if file.is_file())
        target = rng.choice(files)
        if target.suffix == ".h5" and rng.random() < 0.7:
            rng.choice([lambda: archives.change_values(target, rng),
                        lambda: archives.change_structure(target, rng, at.secret)])()  # fmt: skip
        elif target.suffix == ".json":
            target.write_bytes(mutated(target.read_text(), rng))
        else:
            target.write_bytes(damaged(target.read_bytes(), rng))
        return rng.choice([
            [["sweep", "--status", "swept.h5"]], [["sweep", "one.toml", "-o", "swept.h5", "--device", "cpu"]],
        ])  # fmt: skip
    return [["sweep", "sweep.toml", "-o", "out.h5", "--device", "cpu"], ["sweep", "--status", "out.h5"]]


def emg(rng: Random, at: Setting) -> list[Command]:
    """Electromyograms in every format, and starts of cycles."""
    name = rng.choice([name for name in ("emg.csv", "emg.sto", "emg.h5", "emg.c3d", "envelope.csv", "cycles.csv")
                       if (at.seeds / name).exists()])  # fmt: skip
    at.copy(name)
    path = at.folder / name
    if name.endswith(".h5"):
        rng.choice([lambda: archives.change_values(path, rng),
                    lambda: archives.change_structure(path, rng, at.secret)])()  # fmt: skip
    elif name.endswith(".c3d"):
        path.write_bytes(damaged(path.read_bytes(), rng))
    else:
        path.write_bytes(mutated(path.read_text(), rng))
    command = ["synergies", "extract", name, "-n", rng.choice(["2", "2", "auto"]), "--restarts", "1", "-o", "out.h5"]
    if name == "cycles.csv":
        at.copy("emg.csv")
        command[2] = "emg.csv"
        command += ["--cycles", "cycles.csv", "--points", "40"]
    return [command + (["--already-filtered"] if name == "envelope.csv" else [])]


def throws(rng: Random, at: Setting) -> list[Command]:
    """Recorded throws, as tables and as arrays, and files of synergies for them."""
    name = rng.choice(["throw.csv", "throw.csv", "throws.npz", "synergies.h5"])
    at.copy(name)
    path = at.folder / name
    command = ["throw", "fit", name, "-n", "1", "-o", "out.h5", "--device", "cpu"]
    if name == "throw.csv":
        path.write_bytes(mutated(path.read_text(), rng))
    elif name == "throws.npz":
        archives.change_npz(path, rng)
    else:
        at.copy("throw.csv")
        rng.choice([lambda: archives.change_values(path, rng),
                    lambda: archives.change_structure(path, rng, at.secret)])()  # fmt: skip
        command = ["throw", "fit", "throw.csv", "--emg", name, "-o", "out.h5", "--device", "cpu"]
    return [command]


def tracked(rng: Random, at: Setting) -> list[Command]:
    """Motions that the objective tracks."""
    suffix = rng.choice(["npz", "npz", "h5"])
    at.copy(f"tracked_{suffix}.toml", f"gait.{suffix}")
    path = at.folder / f"gait.{suffix}"
    if suffix == "npz":
        archives.change_npz(path, rng)
    else:
        rng.choice([lambda: archives.change_values(path, rng),
                    lambda: archives.change_structure(path, rng, at.secret)])()  # fmt: skip
    return [["simulate", f"tracked_{suffix}.toml", "-o", "out.h5"]]


def settings(rng: Random, at: Setting) -> list[Command]:
    """Values of a scene that are set on the command line."""
    name = rng.choice(RUN)
    data = tomllib.loads((at.seeds / f"{name}.toml").read_text())
    words: list[str] = []
    for _ in range(rng.choice([1, 1, 2])):
        key = rng.choice(paths(data))
        if rng.random() < 0.3:
            parts = key.split(".")
            parts[rng.randrange(len(parts))] = rng.choice(["*", "?*", "[", "x", "", "0", "-1", *NAMES[:12]])
            key = ".".join(parts)
        key = rng.choice([key, key, key, "scale.*", "duration", "time_step", "name", "robustness.runs", "control_rate"])
        text = rng.choice(
            [str(rng.choice(NUMBERS)), toml_value(value(rng)), rng.choice(WORDS), f"{{factor={rng.choice(NUMBERS)}}}"]
        )
        words += ["--set", f"{key}={text}".replace("\0", "")]
    return [
        command + words
        for command in scene_commands(name, rng)
        if command[0] in ("info", "simulate", "optimize", "view")
    ] or [["info", name, *words]]


def options(rng: Random, at: Setting) -> list[Command]:
    """Options of the commands with values that nobody means."""
    at.copy("search.h5", "fwalk.h5", "emg.csv", "throw.csv")
    return [option_command(rng)]


def no_files(rng: Random, at: Setting) -> list[Command]:
    """Folders, pipes, devices, links in a circle and files of no end where a file is to be read."""
    at.copy("fwalk.rbs", "fwalk.sbc", "fwalk.rs", "killed.h5", "emg.csv", "throw.csv", "tracked_npz.toml")
    at.copy("tracked_h5.toml")
    (at.folder / "scene.toml").write_text('base = "in.toml"\nname = "a"\n')
    command, name = reading_command(rng)
    put_no_file(at.folder / name, rng)
    return [command]


def _layers(at: Setting) -> None:
    (at.folder / "scene.toml").write_text(LAYERED)
    (at.folder / "more.toml").write_text(MORE)


def _three(rng: Random, at: Setting) -> list[str]:
    """Files of the original program, by the names that they have in the folder."""
    if at.reference is not None and rng.random() < 0.4:
        characters = sorted(at.reference.rglob("*.rbs"))
        chosen = [rng.choice(characters)]
        folder = at.reference / "controllers" / chosen[0].parent.name
        controllers = sorted(folder.glob("*.sbc"))
        states = sorted([*folder.glob("*.rs"), *chosen[0].parent.glob("*.rs")])
        chosen += [rng.choice(controllers)] if controllers else []
        chosen += [rng.choice(states)] if states else []
        for path in chosen:
            shutil.copy(path, at.folder / path.name)
        return [path.name for path in chosen]
    name = rng.choice(SIMBICON)
    files = [f"{name}.rbs", f"{name}.sbc", f"{name}.rs"]
    at.copy(*files)
    return files if rng.random() < 0.7 else [files[0]]


def _hdf5(rng: Random, at: Setting, change: Callable[[Path], None]) -> list[Command]:
    if rng.random() < 0.05:  # a motion of few frames or none
        at.copy("fwalk.h5")
        archives.cut_motion(at.folder / "fwalk.h5", rng.choice([0, 0, 1, 2]))
        more: list[Command] = [
            ["gait", "fwalk.h5"], ["creature", "judge", "fwalk.h5"], ["view", "fwalk.h5", "--export", "out.html"],
            ["report", "fwalk.h5", "-o", "out.html"], ["report", "fwalk.h5"], ["video", "fwalk.h5", "-o", "a.gif"],
            ["export", "fwalk.h5", "-o", rng.choice(EXPORTS)],
            ["plot", "fwalk.h5", "--what", rng.choice(KINDS_OF_FIGURES), "-o", "a.png"],
        ]  # fmt: skip
        return [rng.choice(more)]
    name = rng.choice(["search.h5", "search.h5", "fwalk.h5", "elbow_open_loop.h5", "swept.h5"])
    at.copy(name)
    change(at.folder / name)
    export = rng.choice(EXPORTS)
    commands: list[Command] = [
        ["report", name], ["report", name], ["export", name, "-o", export], ["export", name, "-o", export],
        ["view", name, "--export", "out.html"], ["plot", name, "--what", rng.choice(KINDS_OF_FIGURES), "-o", "a.png"],
    ]  # fmt: skip
    if name == "search.h5":
        commands += [["apply", name, "-o", "out.toml"], ["optimize", "--resume", name, "--candidates", "2"]] * 2
        commands += [["view", name, "--export", "out.html", "--candidates", "2"]]
    if name == "swept.h5":
        commands = [[*command, "--run", "as it is,seed=1,torque=1"] for command in commands]
    if rng.random() < 0.04:
        commands = [
            ["report", name, "-o", "out.html"],
            ["video", name, "-o", "a.gif", "--size", "96x64", "--rate", "10"],
        ]
    return [rng.choice(commands)]


Maker = Callable[[Random, Setting], list[Command]]
KINDS: dict[str, tuple[Maker, float]] = {  # and the part that each has of all cases
    "scene-values": (scene_values, 0.12),
    "scene-text": (scene_text, 0.09),
    "scene-layers": (scene_layers, 0.06),
    "simbicon": (simbicon, 0.10),
    "osim": (osim, 0.10),
    "osim-moving": (osim_moving, 0.02),
    "osim-linked": (osim_linked, 0.02),
    "mujoco": (mujoco, 0.04),
    "hdf5-structure": (hdf5_structure, 0.08),
    "hdf5-values": (hdf5_values, 0.05),
    "policy": (policy, 0.05),
    "journal": (journal, 0.04),
    "sweep": (sweep, 0.05),
    "emg": (emg, 0.06),
    "throws": (throws, 0.03),
    "tracked": (tracked, 0.04),
    "settings": (settings, 0.04),
    "options": (options, 0.03),
    "no-files": (no_files, 0.02),
    "creature": (creature, 0.05),
    "world": (world, 0.10),
    "study": (study, 0.04),
    "adaptation": (adaptation, 0.02),
    "scone": (scone, 0.05),
    "recording": (recording, 0.06),
}

WITHOUT_SEEDS = {"osim", "osim-moving", "osim-linked", "mujoco"}  # whose inputs stand in this package


def shares(count: int) -> dict[str, int]:
    """How many cases each kind has of so many in all, at least one."""
    total = sum(part for _, part in KINDS.values())
    return {kind: max(round(count * part / total), 1) for kind, (_, part) in KINDS.items()}


def make(kind: str, number: int, seed: int, at: Setting) -> list[Command]:
    """Write the inputs of a case into its folder, and give its commands."""
    return KINDS[kind][0](Random(f"{seed}/{kind}/{number}"), at)
