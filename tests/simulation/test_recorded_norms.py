"""Recorded gait cycles in the place of people's norms: what terms compare with, and files that cannot serve."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from small_result import footfalls, walk_result, with_arrays
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.formats import load, toml
from warpmuscle.gait.cycles import body_weight
from warpmuscle.results.partial_motion import reduced
from warpmuscle.results.result import write
from warpmuscle.scene import Objective, RecordedNorms, Scene
from warpmuscle.scene.norms import NORMS, PERCENT_OF_BIN, norm_table
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.recorded_norms import recorded_norms

SWING = np.degrees(0.3)  # of the hips of the recorded walk, whose knees and ankles are straight


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A walk, whose left foot lands at 1, 2 and 3 s and whose legs swing like pendulums; the right one is later."""
    path = tmp_path_factory.mktemp("norms") / "walk.h5"
    write(path, walk_result())
    return path


def compared(path, **fields) -> Scene:
    """A scene that is compared with the recorded walk."""
    scene = load("walk56")
    named = RecordedNorms(file=str(path), **fields)
    return msgspec.structs.replace(scene, objective=Objective(norms=1.0, norm_force=1.0), norms=named)


def test_angles_and_forces_are_the_means_over_recorded_cycles(file):
    found = recorded_norms(compared(file))
    assert found is not None
    wanted = -SWING * np.sin(2.0 * np.pi * PERCENT_OF_BIN / 100.0)  # a turn about x to the left extends the hip
    for side in (0, 1):  # both hips are alike, each from its own foot's landing
        assert found.angle[side, 0] == pytest.approx(wanted, abs=0.6)
        assert np.abs(found.angle[side, 1:]).max() < 1e-3
    scene = load("walk56")
    weight = body_weight(substitute(scene, start_values(scene)))
    carried = (PERCENT_OF_BIN > 2.0) & (PERCENT_OF_BIN < 58.0)
    assert found.force[carried] == pytest.approx(350.0 / 0.6 / weight, rel=1e-3)
    assert found.force[(PERCENT_OF_BIN > 62.0) & (PERCENT_OF_BIN < 98.0)] == pytest.approx(0.0, abs=1e-9)
    assert found.moment is None


def test_terms_compare_in_half_widths_of_people_as_they_do_with_people(file):
    scene = compared(file)
    names, found = topology(scene.character), recorded_norms(scene)
    assert found is not None
    own, scale, side = norm_table(scene, names, found.angle)
    people, scale_of_people, side_of_people = norm_table(scene, names)
    assert np.array_equal(scale, scale_of_people)
    assert np.array_equal(side, side_of_people)
    hip = names.body_of_joint("lHip")
    half_width = NORMS["Hip flexion"].half_width
    assert own[:, hip] * half_width == pytest.approx(found.angle[0, 0])
    assert np.abs(own[:, hip] - people[:, hip]).max() > 1.0


def test_a_scene_that_compares_with_nobody_reads_no_file(tmp_path):
    scene = compared(tmp_path / "none.h5")
    assert recorded_norms(msgspec.structs.replace(scene, objective=Objective(torque=1.0))) is None
    assert recorded_norms(msgspec.structs.replace(scene, norms=None)) is None


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"replays": [1]}, "walk.h5 has 1 motion, none with number 1"),
        ({"start": 3.2}, "walk.h5: 1 motion without a whole gait cycle: from 3.2 s on the left foot lands less than"),
    ],
)
def test_what_the_file_has_not_is_told_in_a_line(file, fields, message):
    with pytest.raises(Error, match=message) as caught:
        recorded_norms(compared(file, **fields))
    assert "\n" not in str(caught.value)


def test_files_without_a_body_or_its_forces_are_refused_in_a_line(tmp_path):
    result = walk_result()
    motion = result.replays[0]
    kept = ["foot_force_left", "joint_orientation", "body_orientation"]
    standing = with_arrays(motion, foot_force_right=footfalls(motion.time, 0.0, 1.0))
    for name, changed, message in (
        ("other", replace(result, scene=""), "other.h5: the body of its motions is not known"),
        ("lean", replace(result, replays=(reduced(motion, kept),)), "lean.h5: the motion has no foot_force_right"),
        ("still", replace(result, replays=(standing,)), "still.h5: 1 motion without .* the right foot lands less"),
        ("empty", replace(result, replays=()), "empty.h5: holds no motion, whose curves would be norms"),
    ):
        write(tmp_path / f"{name}.h5", changed)
        with pytest.raises(Error, match=message) as caught:
            recorded_norms(compared(tmp_path / f"{name}.h5"))
        assert "\n" not in str(caught.value)
    with pytest.raises(Error, match="no such file"):
        recorded_norms(compared(tmp_path / "none.h5"))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('file = ""', "norms.file: name a result file with motions"),
        ('file = "a.h5"\nstart = -1', "norms.start"),
        ('file = "a.h5"\nreplays = [0, -2]', "norms.replays.1: must not be negative, is -2"),
        ("start = 1", "norms: .*file"),
    ],
)
def test_tables_that_name_no_motion_are_refused(lines, message, tmp_path):
    (tmp_path / "own.toml").write_text(f'name = "own"\nbase = "walk56"\n[norms]\n{lines}\n')
    with pytest.raises(SceneError, match=message):
        toml.read(tmp_path / "own.toml")
