"""Three hinges of an OpenSim model as one ball joint: the same poses, paths and names of coordinates."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about, multiply
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.sto import coordinates
from warpmuscle.scene import BallCoordinates, JointState, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*centre of mass starts"), pytest.mark.usefixtures("unoptimized_kernels")
]  # fmt: skip

NAMES = ("flexion", "adduction", "turn")
COUNT = 200


def leg(folder: Path, third: str = "0 1 0", mass: float = 1.0) -> Path:
    """A thigh on a hip of three angles, with a muscle of which one point counts while two of them are in a range."""
    transform = small.axes(
        rotation1=("flexion", "0 0 1", small.LINE), rotation2=("adduction", "1 0 0", small.LINE),
        rotation3=("turn", third, small.LINE),
    )  # fmt: skip
    hip = small.joint(
        "CustomJoint", "hip", "pelvis", "thigh", "".join(map(small.coordinate, NAMES)), transform, place="0.1 0.2 0.05",
        turn="0.2 0.1 -0.3", own="0.02 0.2 0", own_turn="0.1 -0.2 0.3",
    )  # fmt: skip
    conditions = "".join(conditional(f"p{k}", name, place) for k, (name, place) in enumerate(CONDITIONS.items()))
    points = small.point("a", "pelvis", "0.15 0.3 0.1") + conditions + small.point("b", "thigh", "0.05 -0.1 0.02")
    bodies = small.body("pelvis", 10.0) + small.body("thigh", mass, center="0 -0.2 0.01")
    free = small.joint("FreeJoint", "root", "ground", "pelvis", "".join(map(small.coordinate, "abcxyz")))
    return small.written(folder, small.model(bodies, free + hip, small.muscle("m", points)))


CONDITIONS = {"flexion": "0.2 0.05 0.02", "adduction": "0.25 0 0.05", "turn": "0.22 -0.05 0"}


def conditional(name: str, coordinate: str, location: str) -> str:
    """A point on the thigh that counts while a coordinate is within -0.4 and 0.7."""
    return (
        f'<ConditionalPathPoint name="{name}"><socket_parent_frame>/bodyset/thigh</socket_parent_frame>'
        f"<location>{location}</location><socket_coordinate>/jointset/hip/{coordinate}</socket_coordinate>"
        f"<range>-0.4 0.7</range></ConditionalPathPoint>\n"
    )


def both(folder: Path) -> tuple[Scene, Scene]:
    """The leg with three hinges, and with a ball joint."""
    path = leg(folder)
    kinds = {"ignored": [], "hard_points": True}
    return load(path, **kinds), load(path, ball_joints=True, **kinds)


def turned(scene: Scene, angles: np.ndarray) -> np.ndarray:
    """Orientations (n, 4) of the ball joint's child at the three angles (n, 3)."""
    joint = scene.character.joints["hip"]
    swing, twist = joint_type(joint).frame(joint)
    middle = np.cross(swing[0], twist[0])
    second = -angles[:, 1] if scene.opensim.balls["hip"].turned_round else angles[:, 1]
    turns = [
        about(axis, angle) for axis, angle in ((swing[0], angles[:, 0]), (middle, second), (twist[0], angles[:, 2]))
    ]
    return np.asarray(multiply(multiply(turns[0], turns[1]), turns[2]))


def test_poses_and_paths_are_those_of_the_hinges(tmp_path: Path):
    hinges, ball = both(tmp_path)
    angles = np.random.default_rng(1).uniform(-1.2, 1.2, (COUNT, 3))
    found = []
    for scene, own in ((hinges, angles), (ball, turned(ball, angles))):
        stages = Stages(scene, COUNT, "cpu")
        q = stages.state.coordinates.numpy().copy()
        q[:, 7:] = own
        stages.state.coordinates.assign(q.astype(np.float32))
        places = stages.forward_kinematics()
        found.append((places["position"][:, -1], places["orientation"][:, -1], stages.muscle_paths().length[:, 0]))
    assert np.abs(np.diff(found[0][2])).max() > 0.01
    for chained, merged in zip(*found, strict=True):
        aligned = np.sign(np.sum(chained * merged, axis=-1, keepdims=True)) if chained.shape[-1] == 4 else 1.0
        np.testing.assert_allclose(merged * aligned, chained, atol=2e-6)


def test_limits_and_conditions_count_the_way_of_the_coordinates(tmp_path: Path):
    hinges, ball = both(tmp_path)
    joint, muscle = ball.character.joints["hip"], ball.character.muscles["m"]
    assert joint.type == "ball"
    assert list(ball.character.bodies) == ["pelvis", "thigh"]
    assert ball.opensim.balls == {"hip": BallCoordinates(NAMES, turned_round=True)}
    assert joint.limits[0] == hinges.character.joints["flexion"].limits[0]
    ranges = [(point.condition.low, point.condition.high) for point in muscle.path[1:-1]]
    np.testing.assert_allclose(ranges, [(-0.4, 0.7), (-0.7, 0.4), (-0.4, 0.7)], atol=1e-3)
    assert [(point.condition.joint, point.condition.axis) for point in muscle.path[1:-1]] == [
        ("hip", k) for k in range(3)
    ]


def test_a_motion_is_written_in_the_models_coordinates(tmp_path: Path):
    _, ball = both(tmp_path)
    ball.duration = 0.3
    ball.initial_state.joints["hip"] = JointState(angular_velocity=(1.0, 2.0, -1.5))
    ball.failure.com_height = ball.failure.heading = 0.0
    rollout = Rollout(ball, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    motion = rollout.recording(0)
    names, table = coordinates(motion, ball)
    angles = np.radians(np.stack([table[:, names.index(name)] for name in NAMES], axis=1))
    assert np.ptp(angles, axis=0).min() > 0.05
    held = motion.joint_orientation[:, 0]
    again = turned(ball, angles)
    np.testing.assert_allclose(again * np.sign(np.sum(again * held, axis=1, keepdims=True)), held, atol=1e-5)


@pytest.mark.parametrize("third", ["0 1 0.1", "0 0 1"])
def test_hinges_that_are_no_ball_joint_stay(tmp_path: Path, third: str):
    scene = load(leg(tmp_path, third), ignored=[], ball_joints=True)
    assert [scene.character.joints[name].type for name in NAMES] == ["hinge"] * 3


def test_a_condition_on_a_ball_joint_jumps_and_needs_axes(tmp_path: Path):
    _, ball = both(tmp_path)
    condition = ball.character.muscles["m"].path[1].condition
    condition.blend = 0.1
    with pytest.raises(SceneError, match=r"condition\.blend: .*give a blend of 0"):
        check_scene(ball)
    condition.blend, condition.axis = 0.0, 3
    with pytest.raises(SceneError, match=r"condition\.axis: a ball joint has no angle 3"):
        check_scene(ball)


def test_coordinates_of_a_ball_joint_are_not_said_to_be_left_out(tmp_path: Path):
    ignored: list[Ignored] = []
    load(leg(tmp_path), ball_joints=True, ignored=ignored)
    assert not [one.text for one in ignored if "left out" in one.reason]
