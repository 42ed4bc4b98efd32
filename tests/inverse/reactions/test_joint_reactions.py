"""Joint reactions against OpenSim's published ones, and lines of action against moment arms."""

import numpy as np
import pytest

from opensim_table import table
from small_leg import loads, motion, small_leg
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.pose import rotate
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.reactions.joint_reactions import joint_reactions, muscle_wrenches
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.scene.joints import joint_type

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def test_reactions_are_those_that_opensim_published(reference_data):
    folder = reference_data / "inverse" / "static_optimization_92"
    body = BodyModel(folder / "subject01_simbody_adjusted_StaticOp.osim", "cpu")
    coordinates = read_coordinates(folder / "subject01_walk1_Kinematics.sto", body.scene)
    forces = read_loads(folder / "foot_floor_loads.xml")
    _, names, rows = table(folder / "subject01_JointReaction_ReactionLoads.sto")
    times = np.minimum(rows[:, 0], coordinates.times[-1])
    muscles = static_optimization(body, coordinates, forces, times=times)
    columns = {}
    for on, frame in (("child", "child"), ("parent", "child"), ("child", "ground")):
        columns |= joint_reactions(body, coordinates, forces, muscles, times=times, on=on, frame=frame).columns()
    for start in (
        "hip_r_on_femur_r_in_femur_r_f",
        "hip_r_on_pelvis_in_femur_r_f",
        "ground_pelvis_on_pelvis_in_ground_p",
    ):
        own = [f"{start}{axis}" for axis in "xyz"]
        theirs = rows[:, [names.index(name) for name in own]]
        ours = np.stack([columns[name] for name in own], axis=1)
        assert np.abs(ours - theirs).max() < 0.02 * np.abs(theirs).max()


@pytest.mark.parametrize("muscle", ["rectus", "hamstrings", "gastrocnemius", "glut_med", "tibialis"])
def test_lines_of_action_have_the_moment_arms_of_their_muscles(body, muscle):
    trials = prepare(body, motion(6), None, None, None)
    tension = np.zeros((6, len(body.muscles)))
    tension[:, body.muscles.index(muscle)] = 100.0
    pulled = muscle_wrenches(body, trials.states, slice(0, 6), tension)
    moment, force = (array.numpy().astype(np.float64) for array in pulled)
    dynamics = body.dynamics(trials.states, trials.loads)
    arms = body.muscle_frames(trials.states, slice(0, 6)).moment_arm.numpy().astype(float)
    checked = 0
    for lever in np.flatnonzero(body.lever_muscle == body.muscles.index(muscle)):
        number = int(body._levers[1][lever])
        joint = body.scene.character.joints[body.topology.joints[number - 1]]
        q = trials.states.coordinates[:, body.topology.coordinates_of(number)]
        subspace = joint_type(joint).motion(joint, q, np.zeros_like(q))
        parent = dynamics.orientation[:, body.topology.parents[number]]
        turning, moving = rotate(parent, subspace.turning[0]), rotate(parent, subspace.moving[0])
        work = np.sum(turning * moment[:, number] + moving * force[:, number], axis=1)
        assert work == pytest.approx(100.0 * arms[:, lever], abs=0.01)
        checked += 1
    assert checked >= 1


def test_the_knee_carries_more_than_the_foot_pushes_as_muscles_pull_across_it(body):
    at = motion()
    forces = loads(at.times)
    muscles = static_optimization(body, at, forces, reserve=20.0)
    passive = joint_reactions(body, at, forces, frame="ground")
    pulled = joint_reactions(body, at, forces, muscles, frame="ground")
    knee = pulled.joints.index("knee_r")
    assert np.linalg.norm(pulled.force[:, knee], axis=1).mean() > np.linalg.norm(passive.force[:, knee], axis=1).mean()


def test_what_a_joint_puts_on_the_child_the_child_puts_back(body):
    at = motion(10)
    child, parent = (joint_reactions(body, at, loads(at.times), on=on, frame="ground") for on in ("child", "parent"))
    assert parent.force == pytest.approx(-child.force, abs=1e-3)
    about = [one.moment + np.cross(one.point, one.force) for one in (child, parent)]  # the origin
    assert about[1] == pytest.approx(-about[0], abs=0.02)


def test_axes_turn_forces_and_change_no_size(body):
    at = motion(10)
    found = [joint_reactions(body, at, loads(at.times), frame=frame) for frame in ("child", "parent", "ground")]
    sizes = [np.linalg.norm(one.force, axis=2) for one in found]
    assert sizes[0] == pytest.approx(sizes[2], rel=1e-5)
    assert sizes[1] == pytest.approx(sizes[2], rel=1e-5)


def test_names_are_those_of_opensim(body):
    at = motion(5)
    names = joint_reactions(body, at, on="parent", frame="child").columns()
    assert "knee_r_on_femur_r_in_tibia_r_fx" in names
    assert "hip_r_on_pelvis_in_femur_r_mz" in names


def test_what_does_not_go_together_is_refused(body):
    at = motion(10)
    muscles = static_optimization(body, motion(8), reserve=5.0)
    with pytest.raises(ArgumentError, match="frames"):
        joint_reactions(body, at, None, muscles)
    with pytest.raises(ArgumentError, match="child"):
        joint_reactions(body, at, on="both")
