"""Sound inputs of every kind, made by warpmuscle itself, from which mutated ones are made."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

SCENES = (
    "fwalk", "elbow_open_loop", "bigbird_walk", "walk56", "reflex_walk", "throw", "walk56_curriculum", "wang2012",
    "leg",
)  # fmt: skip
SIMBICON = ("fwalk", "bigbird_walk", "walk56")
RUN = ("fwalk", "elbow_open_loop", "leg")  # simulated: few kernels to compile
CHANNELS = ("DEL", "BIC", "TRI", "ECR")
SWEEP = """\
scene = "fwalk"
[set]
duration = 0.02
[search]
candidates = 2
[grid]
seed = [1, 2]
"objective.torque" = [1, 2]
[[run]]
name = "as it is"
[[run]]
name = "short shanks"
"scale.?Lowerleg" = 0.9
"""
LAYERED = """\
name = "mine"
base = "fwalk.toml"
character = ["biped.toml", "more.toml"]
duration = 0.02
[actuation]
lHip = { drive = ["muscle", "torque", "torque"] }
[objective]
speed = 5.0
[controller.pd]
lKnee = { kp = { value = 300, min = 150, max = 600, step = 5 }, kd = 30, scale = [1, 0.66, 1] }
"""
LEG = """\
name = "leg"
duration = 0.05
[character]
root = "base"
root_joint = "fixed"
[character.bodies]
base = { mass = 5.0, inertia = [0.1, 0.1, 0.1] }
shank = { mass = 3.0, inertia = [0.05, 0.01, 0.05] }
foot = { mass = 1.0, inertia = [0.01, 0.01, 0.01] }
[character.joints.knee]
type = "coupled"
parent = "base"
child = "shank"
position_in_parent = [0, -0.2, 0]
position_in_child = [0, 0.2, 0]
rotations = [{ axis = [1, 0, 0], slope = 1.0 }]
translations = [{ axis = [0, 1, 0], x = [-2.0, -1.0, 0.0], y = [-0.02, -0.01, { value = 0.0, min = -0.1, max = 0.1 }] }]
[character.joints.piston]
type = "slide"
parent = "shank"
child = "foot"
position_in_parent = [0, -0.2, 0]
position_in_child = [0, 0, 0]
axes = [[0, 1, 0]]
limits = [[-0.1, 0.1]]
[initial_state]
root_position = [0, 1.5, 0]
joints = { knee = { coordinate = -0.5 } }
[forces]
drag = { type = "air_drag", body = "foot", parameters = { drag_area = 0.5, density = 1.2 } }
[forces.exo]
type = "bilinear_spring"
joint = "knee"
parameters = { rest_angle = 0.1, stiffness_above = 18.0, stiffness_below = 0.0, damping = 0.0 }
"""
MORE = """\
[muscles.HIP]
path = [
    { body = "pelvis", position = [0.1, 0.05, 0.06] },
    { body = "lUpperleg", start = [0.03, 0.1, 0.05], end = [0.03, 0.05, 0.05], at = { value = 0.5, min = 0, max = 1 } },
]
f_max = 1000
l_opt = 0.1
l_slack = 0.15
delay = 0.01
"""
TRACKED = """\
name = "tracked"
base = "fwalk.toml"
duration = 0.02
[tracking]
file = "{file}"
start = 0
[objective]
tracking = 1.0
"""


def make_seeds(folder: Path) -> Path:
    """Write all seeds into a folder; the same ones each time."""
    from warpmuscle import examples
    from warpmuscle.cli.common import start_warp
    from warpmuscle.formats import load, save, toml

    start_warp()
    folder.mkdir(parents=True, exist_ok=True)
    for name in SCENES:
        (folder / f"{name}.toml").write_text(LEG if name == "leg" else toml.dumps(load(name)))
    for name in SIMBICON:
        save(load(name), folder / f"{name}.rbs", ignored=[])
    for name, text in {"layered": LAYERED, "more": MORE, "sweep": SWEEP}.items():
        (folder / f"{name}.toml").write_text(text)
    examples.write("creatures", folder, replace=True)
    for suffix in ("h5", "npz"):
        (folder / f"tracked_{suffix}.toml").write_text(TRACKED.format(file=f"gait.{suffix}"))
    _results(folder)
    _policy(folder)
    _signals(folder)
    _throws(folder)
    return folder


def _results(folder: Path) -> None:
    """Files of runs and searches, one of which was killed, and of a sweep."""
    import msgspec

    import warpmuscle as wm
    from warpmuscle.formats import load
    from warpmuscle.results.records import Result, parameter_table
    from warpmuscle.results.result import write
    from warpmuscle.sweep.plan import read
    from warpmuscle.sweep.run import sweep

    for name in RUN:
        scene = msgspec.structs.replace(load(folder / f"{name}.toml"), duration=0.1)
        rollout = wm.Rollout(scene, 1, "cpu", record=[0])
        rollout.run()
        table = parameter_table(rollout.parameters)
        made = Result(
            wm.formats.toml.dumps(scene), "cpu", "warpmuscle simulate", 0, table, replays=(rollout.recording(),)
        )
        write(folder / f"{name}.h5", made)
    shutil.copy(folder / "fwalk.h5", folder / "gait.h5")
    scene = msgspec.structs.replace(load("fwalk"), duration=0.02)
    search: dict[str, Any] = {"search": "cma", "searches": 2, "population": 4}
    with _killed(folder / "killed.h5", folder / "search.h5") as output:
        wm.optimize(scene, 24, device="cpu", output=output, progress=_copier(output, folder), **search)
    (folder / "one.toml").write_text(SWEEP.replace("[1, 2]", "[1]", 1))
    sweep(read(folder / "one.toml"), folder / "swept.h5", device="cpu")
    orientation = np.tile([0.0, 0.0, 0.0, 1.0], (20, 1))
    cycle = np.linspace(0.0, 1.0, 20, endpoint=False)
    np.savez(folder / "gait.npz", cycle=cycle, time=cycle, lHip=orientation, rKnee=0.1 * cycle, lElbow=cycle)


def _policy(folder: Path) -> None:
    """A policy of random weights for `fwalk`, and its motion."""
    import msgspec

    from warpmuscle.formats import load, toml
    from warpmuscle.learning.episodes import EpisodeBatch
    from warpmuscle.learning.player import replay, text_of
    from warpmuscle.results.learned import CURVE, Layer, Learned, PolicyTable
    from warpmuscle.results.records import Result, parameter_table
    from warpmuscle.results.result import write
    from warpmuscle.scene.learning import Task

    scene = msgspec.structs.replace(load(folder / "fwalk.toml"), duration=0.1)
    task, random = Task(actions="joint_targets"), np.random.default_rng(0)
    batch = EpisodeBatch(scene, 1, "cpu", task)
    names, actions = tuple(batch.senses.names), batch.actions.names
    layers = [
        Layer(0.1 * random.normal(size=(b, a)).astype(np.float32), np.zeros(b, np.float32))
        for a, b in ((len(names), 6), (6, len(actions)))
    ]
    ones = np.ones(len(names), np.float32)
    policy = PolicyTable(names, actions, 0.0 * ones, ones, 5.0, tuple(layers))
    curve = {name: np.linspace(0.0, 1.0, 3) for name in CURVE} | {"iteration": np.arange(1.0, 4.0)}
    learned = Learned(policy, text_of(task), curve, {}, "time is up")
    motions = (replay(policy, scene, "cpu", task)[0],)
    table = parameter_table([])
    made = Result(toml.dumps(scene), "cpu", "warpmuscle learn fwalk", 0, table, replays=motions, learned=learned)
    write(folder / "policy.h5", made)


@contextmanager
def _killed(path: Path, whole: Path) -> Iterator[Path]:
    """The file that a search is to write; it is kept as `whole`, what was there in the midst of it as `path`."""
    work = path.with_name("work.h5")
    yield work
    work.rename(whole)
    with suppress(FileNotFoundError):
        path.with_name("work.h5.journal").unlink()


def _copier(output: Path, folder: Path) -> Any:
    """A function that keeps a copy of the file and of its journal while the search goes on."""

    def keep(progress: Any) -> None:
        journal = output.with_name(output.name + ".journal")
        with suppress(FileNotFoundError):
            content = journal.read_bytes()
            shutil.copy(output, folder / "killed.h5")
            (folder / "killed.h5.journal").write_bytes(content)

    return keep


def _signals(folder: Path) -> None:
    """The same four electromyograms in every format, starts of cycles, and a file of synergies."""
    from warpmuscle.synergy.extraction import Rule, extract
    from warpmuscle.synergy.files import SynergyResult, write
    from warpmuscle.synergy.preparation import Preparation, prepare

    rng, time = np.random.default_rng(0), np.arange(800) / 1000.0
    drive = np.abs(np.sin(2.0 * np.pi * np.outer(time, [1.5, 2.3])))
    values = 0.1 * (drive @ rng.uniform(size=(2, len(CHANNELS)))) * rng.normal(size=(len(time), len(CHANNELS)))
    _table(folder / "emg.csv", ["time", *CHANNELS], np.column_stack([time, values]))
    _table(folder / "envelope.csv", ["time", *CHANNELS], np.column_stack([time, np.abs(values)])[::10])
    header = f"emg\nversion=1\nnRows={len(time)}\nnColumns={1 + len(CHANNELS)}\ninDegrees=no\nendheader\n"
    text = (folder / "emg.csv").read_text().replace(",", "\t")
    (folder / "emg.sto").write_text(header + text)
    (folder / "cycles.csv").write_text("start,swing\n0.05,0.2\n0.3,0.45\n0.6,0.7\n")
    _hdf5_signals(folder / "emg.h5", time, values)
    _c3d(folder / "emg.c3d", values)
    activations = prepare([folder / "envelope.csv"], Preparation(already_filtered=True, rate=None))
    found, accounts = extract(activations.values, Rule.of("2", 0.9, 0.75), 1, 0)
    write(folder / "synergies.h5", SynergyResult(activations, found, tuple(accounts)))


def _hdf5_signals(path: Path, time: Any, values: Any) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["time"], file["values"] = time, values
        file["names"] = np.array(CHANNELS, dtype=object)


def _c3d(path: Path, values: Any) -> None:
    """Analog channels, if the package for this format is installed."""
    with suppress(ImportError):
        import ezc3d

        content = ezc3d.c3d()
        content["parameters"]["POINT"]["RATE"]["value"] = [100]
        content["parameters"]["POINT"]["LABELS"]["value"] = ["marker"]
        content["data"]["points"] = np.zeros((4, 1, len(values) // 10))
        content["parameters"]["ANALOG"]["RATE"]["value"] = [1000]
        content["parameters"]["ANALOG"]["LABELS"]["value"] = list(CHANNELS)
        content["data"]["analogs"] = values.T[None]
        content.write(str(path))


def _throws(folder: Path) -> None:
    """A short throw as a table, and two as arrays."""
    time = np.arange(30) / 100.0
    s = time / time[-1]
    smooth = s**2 * (3.0 - 2.0 * s)
    angles = {"shoulder": 40.0 + 60.0 * smooth, "elbow": 100.0 - 80.0 * smooth, "wrist": 10.0 + 20.0 * np.sin(2.0 * s)}
    columns = {"time_s": time, **{f"{name}_deg": a for name, a in angles.items()}, "trunk_pitch_deg": 5.0 * s}
    _table(folder / "throw.csv", list(columns), np.column_stack(list(columns.values())))
    arrays = {f"{name}_flexion_deg": np.stack([a, 1.1 * a]) for name, a in angles.items()}
    points = np.zeros((2, len(time), 2, 3))
    np.savez(
        folder / "throws.npz", time=time, trial=np.array(["one", "two"]), keypoint_pos_m=points,
        keypoints=np.array(["R_SHOULDER", "R_WRIST"]), **arrays,
    )  # fmt: skip


def _table(path: Path, names: list[str], values: Any) -> None:
    rows = [",".join(f"{value:.6g}" for value in row) for row in values]
    path.write_text("\n".join([",".join(names), *rows]) + "\n")
