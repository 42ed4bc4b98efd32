"""Which muscle acts on which joint, and what paths must be."""

import numpy as np
import pytest

from biped import biped
from leg_paths import KNEE_BENT, PATHS, ZERO, character, points
from warpmuscle.core.errors import SceneError
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.path_table import path_table
from warpmuscle.model.paths import paths_struct
from warpmuscle.scene import Condition, ViaPoint
from warpmuscle.scene.topology import topology


def test_muscles_act_on_the_joints_between_the_bodies_of_their_points():
    names = topology(character())
    table = path_table(PATHS, names, character())
    joints = {muscle: [] for muscle in PATHS}
    for crossing in table.crossings:
        joints[list(PATHS)[crossing.muscle]].append(names.joints[crossing.joint - 1])
    assert {muscle: sorted(crossed) for muscle, crossed in joints.items()} == {
        "knee": ["lKnee"],
        "knee, upwards": ["lKnee"],
        "hip to toes": ["lAnkle", "lHip", "lKnee", "lToeJoint"],
        "over three joints at once": ["lHip", "lKnee", "pelvis_torso"],
        "shin to shin": ["lHip", "lKnee", "rHip", "rKnee"],
        "arm to leg": ["lShoulder", "pelvis_torso", "rHip"],
        "within a body": [],
        "conditional": ["lAnkle", "lHip", "lKnee"],
        "on a condition of a joint that it does not cross": ["lAnkle", "lHip"],
    }


def test_joints_find_their_muscles_and_muscles_their_joints():
    names = topology(character())
    table = path_table(PATHS, names, character())
    p = paths_struct(table, grouped_paths(table, names, character()), names, character(), "cpu")
    start, muscle = p.crossing_start.numpy(), p.crossing_muscle.numpy()
    joint = np.array([crossing.joint for crossing in table.crossings])
    assert [crossing.muscle for crossing in table.crossings] == muscle.tolist()
    assert all(set(joint[start[body] : start[body + 1]]) <= {body} for body in range(len(names.bodies)))
    assert start[-1] == len(joint)
    own = p.of_muscle.numpy()
    for m, span in enumerate(p.span.numpy()):
        assert set(muscle[own["number"][span["first_crossing"] : span["end_crossing"]]]) <= {m}
    assert sorted(own["number"]) == list(range(len(joint)))
    assert (own["joint"] == joint[own["number"]]).all()


def test_a_segment_depends_on_the_conditions_of_its_own_points_alone():
    via = [ViaPoint(body, ZERO) for body in ("pelvis", "lUpperleg", "lLowerleg")]
    via[2].condition = KNEE_BENT
    table = path_table(
        {"one": [*via, ViaPoint("lFoot", ZERO)], "other": [HERE, THERE]}, topology(character()), character()
    )
    found = {segment: table.conditional(k) for k, segment in enumerate(table.segments)}
    own = {(0, 1): [], (1, 2): [KNEE_BENT], (2, 3): [KNEE_BENT], (1, 3): [KNEE_BENT], (4, 5): []}
    assert found == own


def test_segments_within_a_body_are_fixed_whatever_comes_behind_them():
    path = points(("pelvis", ZERO), ("pelvis", ZERO), ("lUpperleg", ZERO), ("lUpperleg", ZERO), ("lLowerleg", ZERO))
    table = path_table({"m": path}, topology(character()), character())
    assert table.fixed == [[(0, 1), (2, 3)]]
    assert table.segments == [(1, 2), (3, 4)]


def test_fixed_joints_have_no_muscles():
    c = character()
    over_elbow = {"m": points(("lUpperarm", ZERO), ("lLowerarm", ZERO))}
    assert path_table(over_elbow, topology(c), c).crossings == []


HERE, THERE = ViaPoint("pelvis", ZERO), ViaPoint("lFoot", ZERO)


@pytest.mark.parametrize(
    ("bad", "key", "message"),
    [
        ([HERE], "", "at least two points, got 1"),
        ([HERE, ViaPoint("tail", ZERO)], ".1.body", "no body 'tail'"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("knee", 0.0, 1.0)), THERE], ".1.condition.joint", "no joint 'knee'"),
        (
            [HERE, ViaPoint("pelvis", ZERO, Condition("lHip", 0.0, 1.0)), THERE],
            ".1.condition.blend",
            "give a blend of 0",
        ),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 0.0, 1.0, axis=1)), THERE], ".1.condition.axis", "angle 1"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 1.0, 1.0)), THERE], ".1.condition.low", "must be less"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 0.0, 1.0, -0.1)), THERE], ".1.condition.blend", "negative"),
    ],
)
def test_errors_say_what_is_wrong_and_where(bad: list[ViaPoint], key: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        path_table({"SOL": bad}, topology(biped()), biped())
    assert caught.value.key == f"muscles.SOL.path{key}"
