"""What is too large is refused before work starts, by the name of its limit."""

import os
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

from small_result import walk_result
from small_scene import muscle_scene, sound_scene
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import read_file
from warpmuscle.core.limits import LIMITS, check_size
from warpmuscle.formats import load, toml
from warpmuscle.formats.meshes.read import read_mesh
from warpmuscle.formats.mujoco.compiled import compiled
from warpmuscle.optimization.optimize import optimize
from warpmuscle.scene import (
    BallObject,
    Body,
    Constraint,
    Ligament,
    Muscle,
    MuscleModel,
    Scene,
    Terrain,
    Treadmill,
    ViaPoint,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.tiles import HeightField, Rough
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.plan import read as read_sweep
from warpmuscle.synergy.emg import resampled
from warpmuscle.synergy.factorization import factorize
from warpmuscle.synergy.recordings import read_signals
from warpmuscle.synergy.signals import Signals
from warpmuscle.throw.recordings.motion_files import read as read_motions
from warpmuscle.video.film import Look, make_film

ROOT = Path(__file__).parents[2]


def changed(change: Callable[[Scene], None]) -> Callable[[Path], object]:
    """Check the small scene with muscles after a change."""

    def check(folder: Path) -> None:
        scene = muscle_scene()
        change(scene)
        check_scene(scene)

    return check


def long_profile() -> Treadmill:
    return Treadmill(profile=[(0.1 * k, 1.0) for k in range(1001)])


def on_tile(tile: HeightField | Rough) -> Callable[[Scene], None]:
    """Let a scene have ground of one tile."""
    return lambda scene: setattr(scene.ground, "terrain", Terrain([tile]))


def large(name: str) -> Callable[[Path], Path]:
    """A file of 1.5 GiB, of which nothing is on the disk."""

    def make(folder: Path) -> Path:
        (folder / name).touch()
        os.truncate(folder / name, 3 * 2**29)
        return folder / name

    return make


def based(folder: Path) -> Path:
    """A scene based on a hundred others."""
    for k in range(100):
        (folder / f"{k}.toml").write_text(f'name = "a"\nbase = "{k + 1}.toml"\n')
    (folder / "100.toml").write_text('name = "a"\nbase = "fwalk.toml"\n')
    return folder / "0.toml"


def sweep(folder: Path) -> Path:
    """A sweep of a million runs."""
    axes = "\n".join(f'"objective.{name}" = {list(range(1, 101))}' for name in ("torque", "speed", "heading"))
    (folder / "s.toml").write_text(f'scene = "fwalk"\n[grid]\n{axes}\n')
    return folder / "s.toml"


def signals() -> Signals:
    """Twenty minutes of a hundred channels, ten thousand samples a second; zeros that take no memory."""
    return Signals(tuple(map(str, range(100))), 1e4, np.broadcast_to(0.0, (12_000_000, 100)))


def chain(scene: Scene) -> None:
    scene.character.bodies |= {f"b{k}": Body(1.0, (1.0, 1.0, 1.0)) for k in range(1000)}


def many_muscles(scene: Scene) -> None:
    path = [ViaPoint("pelvis", (0.0, 0.1, 0.1)), ViaPoint("lFoot", (0.0, -0.3, 0.1))]
    scene.character.muscles |= {f"m{k}": Muscle(path=path, f_max=1.0, l_opt=0.1, l_slack=0.1) for k in range(6000)}


def many_constraints(scene: Scene) -> None:
    held = Constraint("distance", "lFoot", "rFoot", distance=0.2)
    scene.character.constraints = {f"c{k}": held for k in range(100)}


def long_ligament(scene: Scene) -> None:
    knots = np.arange(2000.0).tolist()
    scene.muscle_model = MuscleModel(curves="millard")
    scene.character.muscles["HFL"].curve_shape = Ligament(knots, knots)


def long_curve(scene: Scene) -> None:
    component = scene.controller.states[0].trajectories["SWING_Hip"].components[0]
    component.phase = component.angle = np.arange(300_000.0).tolist()


def many_parameters(scene: Scene) -> None:
    component = scene.controller.states[0].trajectories["SWING_Hip"].components[0]
    component.phase, component.angle = np.arange(3000.0).tolist(), [Free(0.0, -1.0, 1.0)] * 3000


def signals_file(folder: Path, put: Callable[[h5py.File], object]) -> Path:
    """Recorded signals with something else in their file."""
    with h5py.File(folder / "emg.h5", "w") as file:
        file["rate"] = 1000.0
        put(file)
    return folder / "emg.h5"


def rows(file: h5py.File, name: str, kind: object, count: int) -> None:
    """A dataset of so many rows, none of which is on the disk."""
    file.create_dataset(name, (count,), kind, chunks=(1000,))


def empty_names(file: h5py.File) -> None:
    file.create_dataset("values", (0, 10**7), "f8", chunks=(1, 1000), maxshape=(None, None))
    rows(file, "names", h5py.string_dtype(), 10**7)


def long_names(file: h5py.File) -> None:
    file.create_dataset("values", (0, 3), "f8", chunks=(1, 3), maxshape=(None, None))
    file["names"] = ["x" * 3 * 10**7] * 3


def many_groups(file: h5py.File) -> None:
    for k in range(200):
        file.create_group(str(k))


def archive(folder: Path) -> Path:
    """An archive that says to hold 3 GiB."""
    with zipfile.ZipFile(folder / "a.npz", "w") as file:
        file.writestr("time.npy", bytes(100))
    path = folder / "a.npz"
    content = bytearray(path.read_bytes())
    at = content.rindex(b"PK\x01\x02") + 24  # the size in the directory
    content[at : at + 4] = (3 * 2**30).to_bytes(4, "little")
    path.write_bytes(content)
    return path


TOO_LARGE: dict[str, tuple[str, Callable[[Path], object]]] = {
    "text": ("big.toml", lambda folder: load(large("big.toml")(folder))),
    "text of the original program": ("big.rbs", lambda folder: load(large("big.rbs")(folder))),
    "table": ("big.csv", lambda folder: read_signals(large("big.csv")(folder))),
    "model": ("big.osim", lambda folder: load(large("big.osim")(folder))),
    "mesh": ("big.stl", lambda folder: read_mesh(large("big.stl")(folder))),
    "triangles": ("many.obj", lambda folder: read_mesh(many_triangles(folder))),
    "elements": ("many.osim:", lambda folder: load(many_elements(folder))),
    "asked": ("grid.xml:1", lambda folder: compiled(large_grid(folder))),
    "nesting": ("<text>", lambda folder: toml.loads(f"name = 'a'\n[{'.'.join('a' * 60)}]\nb = 1")),
    "bases": ("base", lambda folder: load(based(folder))),
    "values": ("", changed(long_curve)),
    "bodies": ("character.bodies", changed(chain)),
    "constraints": ("character.constraints", changed(many_constraints)),
    "muscles": ("character.muscles", changed(many_muscles)),
    "knots": ("character.muscles.HFL.curve_shape.x", changed(long_ligament)),
    "parameters": ("", changed(many_parameters)),
    "heights": ("ground.terrain.tiles.0.points", changed(on_tile(HeightField(points=(2**20, 3), packed="eA==")))),
    "profile": ("ground.treadmill.profile", changed(lambda scene: setattr(scene.ground, "treadmill", long_profile()))),
    "solids": ("objects", changed(lambda scene: setattr(scene, "objects", {str(k): BallObject() for k in range(17)}))),
    "tiles": ("ground.terrain.tiles.0", changed(on_tile(Rough(count=(9_000, 9_000))))),
    "steps": ("duration", changed(lambda scene: setattr(scene, "duration", 1e9))),
    "steps, tiny": ("duration", changed(lambda scene: setattr(scene, "time_step", 1e-11))),
    "delay": (
        "character.muscles.HFL.delay",
        changed(lambda scene: (setattr(scene, "duration", 1e3), setattr(scene.character.muscles["HFL"], "delay", 900))),
    ),
    "runs": ("robustness.runs", changed(lambda scene: setattr(scene.robustness, "runs", 10**9))),
    "frames": ("", lambda folder: Rollout(long_scene(), 1, "cpu", record=[0], record_rate=2000.0)),
    "threads": ("", lambda folder: Rollout(sound_scene(), 1, "cpu", threads=10**9)),
    "candidates": ("", lambda folder: optimize(load("fwalk"), 10**12)),
    "searches": ("", lambda folder: optimize(load("fwalk"), 10, search="cma", searches=10**8)),
    "population": ("", lambda folder: optimize(load("fwalk"), 10, search="cma", population=10**9)),
    "sweep": ("grid", lambda folder: read_sweep(sweep(folder))),
    "film": ("", lambda folder: make_film(*film_of_an_hour(), Look(speed=0.001, rate=240.0))),
    "samples": ("", lambda folder: resampled(signals(), 9e4)),
    "restarts": ("", lambda folder: factorize(np.ones((20, 4)), 1, restarts=10**7)),
    "objects": ("", lambda folder: read_signals(signals_file(folder, many_groups))),
    "unpacked": ("/x", lambda folder: read_signals(signals_file(folder, lambda file: rows(file, "x", "f8", 10**13)))),
    "names": ("/names", lambda folder: read_signals(signals_file(folder, empty_names))),
    "characters": ("/names", lambda folder: read_signals(signals_file(folder, long_names))),
    "archive": ("", lambda folder: read_motions(archive(folder), ["elbow"])),
}


def many_elements(folder: Path) -> Path:
    """A model with more elements than are read."""
    path = folder / "many.osim"
    path.write_text("<OpenSimDocument>" + "<a/>" * LIMITS["elements"].most + "</OpenSimDocument>")
    return path


def large_grid(folder: Path) -> Path:
    """A short text that asks for gigabytes."""
    path = folder / "grid.xml"
    path.write_text('<mujoco><asset><hfield nrow="100000" ncol="100000"/></asset></mujoco>')
    return path


def many_triangles(folder: Path) -> Path:
    """One polygon with more corners than are taken."""
    path = folder / "many.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * (LIMITS["triangles"].most // 2) + "\n")
    return path


def long_scene() -> Scene:
    """Twenty minutes."""
    return msgspec.structs.replace(sound_scene(), duration=1200.0)


def film_of_an_hour() -> tuple[object, Scene]:
    """A motion and its scene."""
    result = walk_result("fwalk")
    return result.replays[0], toml.loads(result.scene)


@pytest.mark.parametrize("what", TOO_LARGE)
def test_what_is_too_large_is_refused_by_the_name_of_its_limit(what: str, tmp_path: Path, monkeypatch):
    if what == "objects":  # so many take half a minute to make
        monkeypatch.setitem(LIMITS, what, LIMITS[what]._replace(most=100))
    place, make = TOO_LARGE[what]
    with pytest.raises(
        Error, match=rf"{re.escape(place)}.* more than .*, the limit `{what.split(',')[0].split()[0]}`$"
    ):
        make(tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("gravity", 1e300),
        ("gravity", Free(0.0, -1e200, 1.0)),
        ("ground.height", Free(same_as="controller.pd.lHip.kp", factor=1e30)),
        ("character.bodies.pelvis.mass", 1e-40),
        ("time_step", 1e-13),
    ],
)
def test_numbers_that_single_precision_cannot_compute_with_are_refused_by_their_key(key: str, value: float | Free):
    scene = sound_scene()
    *path, last = key.split(".")
    part = scene
    for name in path:
        part = part[name] if isinstance(part, dict) else getattr(part, name)
    setattr(part, last, value)
    with pytest.raises(SceneError, match=rf"^{key}: .*(beyond 1e\+12|at least 1e-12)"):
        check_scene(scene)


def test_every_limit_has_a_case_above():
    assert set(LIMITS) == {what.split(",")[0].split()[0] for what in TOO_LARGE}


def test_the_greatest_size_is_allowed_and_what_is_no_number_is_not():
    check_size("steps", LIMITS["steps"].most)
    for size in (LIMITS["steps"].most + 1, np.inf, np.nan):
        with pytest.raises(Error, match="limit `steps`"):
            check_size("steps", size)


@pytest.mark.parametrize("name", ["a.toml", "a.rbs", "a.osim", "a.csv", "a.sto", "a.c3d"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_pipes_and_devices_are_no_files(name: str, kind: str, tmp_path: Path):
    path = tmp_path / name
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    read = load if name.endswith(("toml", "rbs", "osim")) else read_signals
    with pytest.raises(Error, match=rf"{name}: cannot be (opened|read): this is a pipe or a device, not a file$"):
        read(path)


def test_a_file_is_read_whole(tmp_path: Path):
    (tmp_path / "a").write_bytes(b"\0" * 100_000 + b"end")
    assert read_file(tmp_path / "a").endswith(b"end")
    with pytest.raises(IsADirectoryError):
        read_file(tmp_path)
    os.truncate(tmp_path / "a", LIMITS["text"].most + 1)
    with pytest.raises(SceneError, match="limit `text`"):
        read_file(tmp_path / "a")
