"""A made-up patient, of whom all is known: the walk of a biped with other numbers, which a search is to find again."""

import csv
import re
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

import command_line
from warpmuscle.core.errors import Error
from warpmuscle.formats import load, toml
from warpmuscle.formats.overrides import with_values
from warpmuscle.gait.cycles import leg_angles, over_strides, steady_strides
from warpmuscle.gait.measures import measure
from warpmuscle.gait.pelvis_and_trunk import segments
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import ParameterTable, Result
from warpmuscle.results.result import read as read_result
from warpmuscle.results.result import write
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.folder import Folder, Manifest, entries_of
from warpmuscle.sweep.patient import path
from warpmuscle.sweep.patient.compared import Walk, in_spread
from warpmuscle.sweep.patient.file import read
from warpmuscle.sweep.patient.plan import hip_offset, start_tilt
from warpmuscle.sweep.patient.recorded import Patient, read_patient
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.run import SweepResult

OTHER = {  # the patient bends stance knees and lifts legs in another way
    "controller.states.0.trajectories.STANCE_Knee.components.0.angle.0": 0.55,
    "controller.states.0.trajectories.SWING_Hip.components.1.angle.1": -0.56,
}
TEXT = """title = "Made up <script>alert(1)</script>"
scene = "walker.toml"
seeds = 2
[[recording]]
motion = "walk.h5"
begin = 2.0
[match]
candidates = 24
population = 8
sigma = 0.1
duration = 4
[adapt]
candidates = 8
population = 4
sigma = 0.01
[[change]]
name = "load"
"character.bodies.torso.mass" = { factor = 1.2 }
"""


def made_up() -> tuple[Scene, Recording]:
    """The patient and a recording."""
    scene = with_values(load("fwalk"), OTHER)
    scene = substitute(scene, start_values(scene))
    scene.duration = 6.0
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run()
    return scene, rollout.recording()


def written(path: Path, scene: Scene, *motions: Recording) -> None:
    none = np.zeros(0)
    table = ParameterTable((), (), none, none, none, none, ())
    write(path, Result(toml.dumps(scene), "cpu", "", 0, table, replays=motions))


@pytest.fixture(scope="module")
def motion() -> tuple[Scene, Recording]:
    return made_up()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, motion) -> Path:
    folder = tmp_path_factory.mktemp("patient")
    written(folder / "walk.h5", *motion)
    (folder / "walker.toml").write_text(
        'base = "fwalk.toml"\n[[stages]]\nname = "legs"\nfree = ["controller.states.0.trajectories.*_Knee.*", '
        '"controller.states.0.trajectories.SWING_Hip.components.1.*"]\n'
    )
    (folder / "patient.toml").write_text(TEXT)
    return folder


@pytest.fixture(scope="module")
def patient(folder: Path) -> Patient:
    return read_patient(read(folder / "patient.toml"), "cpu")


def test_strides_are_those_between_touch_downs(patient: Patient, motion):
    scene, recording = motion
    cycles = steady_strides(recording.window(2.0), scene)
    angles = leg_angles(recording, scene)["Knee flexion"]["right"]
    rows = over_strides(recording.time, angles, cycles["right"])
    assert patient.gait.curves["Knee flexion"]["right"][-len(rows) :] == pytest.approx(rows, abs=1e-6)
    assert patient.gait.speed == pytest.approx(measure(recording.window(2.0), scene).speed_forward, abs=0.02)


def test_a_treadmill_changes_nothing(folder: Path, tmp_path: Path, patient: Patient, motion):
    scene, recording = motion
    back = np.zeros((recording.frames, 3))
    back[:, 2] = patient.gait.speed * recording.time
    belt = recording.changed(
        com=recording.com - back, root_position=recording.root_position - back,
        body_position=recording.body_position - back[:, None],
    )  # fmt: skip
    written(tmp_path / "walk.h5", scene, belt, belt)
    (tmp_path / "patient.toml").write_text(TEXT.replace('"walker.toml"', '"fwalk"'))
    found = read_patient(read(tmp_path / "patient.toml"), "cpu")
    assert found.gait.speed == pytest.approx(patient.gait.speed, abs=0.02)
    assert found.strides("left") == 2 * patient.strides("left")  # of both motions


def test_events_take_the_place_of_forces(folder: Path, patient: Patient, motion):
    scene, recording = motion
    begins = {side: [begin for begin, _ in own] for side, own in steady_strides(recording, scene).items()}
    events = ", ".join(f"{side} = {[round(time, 4) for time in times]}" for side, times in begins.items())
    file = folder / "events.toml"
    file.write_text(TEXT.replace("begin = 2.0", f"begin = 2.0\nevents = {{ {events} }}"))
    found = read_patient(read(file), "cpu")
    assert found.strides("left") < len(begins["left"])
    rows = found.gait.curves["Hip flexion"]["left"]
    assert rows == pytest.approx(patient.gait.curves["Hip flexion"]["left"][-len(rows) - 1 : -1], abs=0.5) or (
        rows == pytest.approx(patient.gait.curves["Hip flexion"]["left"][-len(rows) :], abs=0.5)
    )
    file.write_text(TEXT.replace("begin = 2.0", "events = { left = [90, 91], right = [90, 91] }"))
    with pytest.raises(Error, match=r"events.toml:5: .*no whole stride of the left foot: its events leave none"):
        read_patient(read(file), "cpu")


def test_a_patient_walks_as_far_from_the_mean_as_nobody_else(patient: Patient):
    mean = patient.gait.mean("Knee flexion", "left")
    assert in_spread(mean, patient, "Knee flexion", "left") == 0.0


@pytest.fixture(scope="module")
def done(folder: Path):
    return command_line.run("patient", "patient.toml", "--device", "cpu", folder=folder)


def test_the_search_comes_nearer_and_the_page_says_so(done, folder: Path):
    assert done.returncode == 0, done.stderr
    assert "2 searches, 2 walked" in done.stdout
    rows = list(csv.DictReader((folder / "patient.csv").read_text().splitlines()))
    assert [(row["search"], row["seed"], row["condition"]) for row in rows] == [
        ("match", "1", ""), ("match", "2", ""),
        ("adapt", "1", "no change"), ("adapt", "2", "no change"), ("adapt", "1", "load"), ("adapt", "2", "load"),
    ]  # fmt: skip
    words = done.stdout[done.stdout.index("angles ") :].split()
    after, before = float(words[1]), float(words[words.index("before);") - 1].removeprefix("("))
    assert after < before
    page = (folder / "patient.html").read_text()
    assert len(page.encode()) < 1_000_000
    assert "<script" not in page
    assert page.count("data:image/svg+xml") == 4
    assert "Made up &lt;script&gt;" in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_changes_stand_in_bold_where_their_interval_is_on_one_side_of_0(done, folder: Path):
    page = (folder / "patient.html").read_text()
    rows = page[page.index('id="numbers"') : page.index('id="made"')].split("<tr>")[2:]
    changes = [
        re.findall(r'<td class="n( clear)?">[^<]*(?:<small>(\S+) to (\S+)</small>)?</td>', row)[-1] for row in rows
    ]
    sides = [(bool(bold), float(low) * float(high)) for bold, low, high in changes if low]
    told = [(bold, both > 0.0) for bold, both in sides if both != 0.0]  # but for what is rounded to 0
    assert {expected for _, expected in told} == {True, False}
    assert all(bold == expected for bold, expected in told)


def test_a_run_with_a_change_is_the_scene_with_this_change(done, folder: Path):
    found = read_result(folder / "patient.patient" / "changes.h5", "load,seed=2,scene=matched_2.toml")
    other = read_result(folder / "patient.patient" / "changes.h5", "no change,seed=2,scene=matched_2.toml")
    masses = [toml.loads(one.scene).character.bodies["torso"].mass for one in (found, other)]
    assert masses[0] == pytest.approx(1.2 * masses[1])
    objectives = [toml.loads(one.scene).objective for one in (found, other)]
    assert objectives[0] == objectives[1]
    assert objectives[0].tracking == pytest.approx(0.1 / 4.0)


def test_the_command_goes_on_where_it_was(done, folder: Path):
    before = {file: file.stat().st_mtime_ns for file in folder.glob("patient.patient/*.sweep/*.h5")}
    assert len(before) == 6
    again = command_line.run("patient", "patient.toml", "--device", "cpu", folder=folder)
    assert again.returncode == 0, again.stderr
    assert {file: file.stat().st_mtime_ns for file in before} == before
    assert again.stdout.split(" in ")[0] == done.stdout.split(" in ")[0]


def test_the_command_goes_on_where_all_of_it_was_moved_to(done, folder: Path, tmp_path: Path):
    moved = shutil.copytree(folder, tmp_path / "moved", symlinks=True)
    (folder / "patient.patient").rename(folder / "elsewhere.patient")
    try:
        before = {file: file.stat().st_mtime_ns for file in moved.glob("patient.patient/*.sweep/*.h5")}
        again = command_line.run(
            "patient", "moved/patient.toml", "-o", "moved/patient.html", "--device", "cpu", folder=tmp_path
        )
    finally:
        (folder / "elsewhere.patient").rename(folder / "patient.patient")
    assert again.returncode == 0, again.stderr
    assert len(before) == 6
    assert before == {file: file.stat().st_mtime_ns for file in moved.glob("patient.patient/*.sweep/*.h5")}


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('motion = "walk.h5"', 'motion = "gone.h5"', 5, "gone.h5"),
        ('scene = "walker.toml"', 'scene = "gone.toml"', 2, "gone.toml"),
        ('scene = "walker.toml"', 'scene = "arm6"', 2, ""),
        ("torso.mass", "torsoo.mass", 18, "torsoo"),
        ("candidates = 24", 'candidates = 24\nset = { "objective.sped" = 1 }', 9, "sped"),
        ("sigma = 0.1", "sigma = -1", 10, "sigma"),
        ('scene = "walker.toml"', 'scene = "plain.toml"', 2, "no free parameters"),
    ],
)
def test_what_cannot_be_used_is_named_where_it_stands(
    done, folder: Path, tmp_path: Path, old: str, new: str, line: int, words: str
):
    for name in ("walk.h5", "walker.toml"):
        (tmp_path / name).symlink_to(folder / name)
    scene = load("fwalk")
    (tmp_path / "plain.toml").write_text(toml.dumps(substitute(scene, start_values(scene))))
    (tmp_path / "patient.toml").write_text(TEXT.replace(old, new, 1))
    failed = command_line.run("patient", "patient.toml", "--device", "cpu", folder=tmp_path)
    assert failed.returncode == 2
    assert f"patient.toml:{line}: " in failed.stderr.replace("\n", " "), failed.stderr
    assert words in failed.stderr
    assert not (tmp_path / "patient.patient").exists()  # before anything was searched for


def test_the_gait_that_is_tracked_is_the_patients(done, folder: Path, patient: Patient):
    assert done.returncode == 0
    (file,) = folder.glob("patient.patient/gait-*.npz")
    with np.load(file) as arrays:
        assert arrays["period"] == pytest.approx(patient.gait.stride_time["left"].mean(), abs=1e-5)
        turn = 2.0 * np.degrees(np.arctan2(arrays["lKnee"][:, 0], arrays["lKnee"][:, 3]))
    assert turn == pytest.approx(patient.pooled["Knee flexion"]["left"][:-1], abs=1e-3)
    result = read_result(folder / "patient.patient" / "match.h5", "seed=1")
    tracking = toml.loads(result.scene).tracking
    assert tracking is not None
    spread = np.radians(patient.spread["Knee flexion"]["left"].mean())
    assert tracking.weights["lKnee"] == pytest.approx(1.0 / (6.0 * spread**2), rel=1e-5)
    assert set(tracking.weights) == {"lHip", "rHip", "lKnee", "rKnee", "lAnkle", "rAnkle"}


def test_hips_below_another_pelvis_are_compared_by_the_thighs(folder: Path, patient: Patient):
    shifted = patient.with_hips(10.0)
    for name, offset in (("Hip flexion", 10.0), ("Knee flexion", 0.0)):
        assert shifted.gait.mean(name, "left") == pytest.approx(patient.gait.mean(name, "left") + offset)
        assert shifted.pooled[name]["right"] == pytest.approx(patient.pooled[name]["right"] + offset)
    asked = read(folder / "patient.toml")
    loose = patient.scene  # whose trunk turns on its pelvis
    assert hip_offset(asked, patient, loose, 6.0) == 0.0
    stiff = msgspec.convert(msgspec.to_builtins(loose.character), type(loose.character))
    trunk = next(joint for joint in stiff.joints.values() if joint.child == segments(loose)["Trunk"])
    trunk.type, trunk.axes = "fixed", []
    walker = msgspec.structs.replace(loose, character=stiff)
    assert hip_offset(asked, patient, walker, 6.0) == pytest.approx(6.0 - patient.gait.tilt)
    assert abs(start_tilt(walker)) < 30.0
    text = TEXT.replace("seeds = 2", "seeds = 2\nhip_offset = 3")
    (folder / "offset.toml").write_text(text)
    assert hip_offset(read(folder / "offset.toml"), patient, walker, 6.0) == 3.0


def test_who_has_no_room_on_the_disk_is_not_told_to_search_longer(folder: Path, monkeypatch: pytest.MonkeyPatch):
    def full(plan: Plan, output: Path, **options: object) -> SweepResult:
        entries = entries_of(plan)
        manifest = Manifest(plan.name, plan.text, "1", "cpu", entries, False, {})
        failed = {entry.name: "no space left on device" for entry in entries}
        return SweepResult(manifest, Folder.of(output), 0, failed)

    monkeypatch.setattr(path, "sweep", full)
    monkeypatch.setattr(path, "_measured", lambda plan, done, threads: [Walk(run.seed, "", False) for run in plan.runs])
    asked = read(folder / "patient.toml")
    with pytest.raises(Error, match=r"\(2 of 2 runs failed; seed=1: no space left on device\)$"):
        path.follow(asked, folder / "full.html", device="cpu")


def test_a_scene_that_falls_is_made_to_walk_first(folder: Path, tmp_path: Path):
    (tmp_path / "walk.h5").symlink_to(folder / "walk.h5")
    (tmp_path / "walker.toml").write_text('base = "fwalk.toml"\n[failure]\ncom_height = 1.2\n')  # it falls at once
    text = TEXT.replace("candidates = 24", "candidates = 24\nwalk = 3").replace("seeds = 2", "seeds = 1")
    (tmp_path / "patient.toml").write_text(text.replace("candidates = 24", "candidates = 2"))
    failed = command_line.run("patient", "patient.toml", "--device", "cpu", folder=tmp_path)
    assert failed.returncode == 2, failed.stdout
    assert "no search found a walk like the patient's (" in failed.stderr
    assert "); give more `match.candidates`" in failed.stderr
    walk = read_result(tmp_path / "patient.patient" / "walk.h5", "seed=1")
    assert len(walk.evaluations) == 3
    objective = toml.loads(walk.scene).objective
    assert objective.tracking == 0.0
    assert objective.speed > 0.0
