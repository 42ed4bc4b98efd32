"""What is shown of a recording: poses from orientations, the desired pose, feet, and fewer frames."""

import numpy as np
import pytest

from biped import biped, breadth_first, forward_kinematics, random_recording
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import normalized
from warpmuscle.formats import load
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Body, Character, Displacement, Failure, InitialState, Joint, JointState, Scene, Sphere
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.curves import panels_of
from warpmuscle.view.figure import figure_of
from warpmuscle.view.track import doll_of, thinned, track_of


def moving_biped(frames: int = 30) -> Recording:
    """The biped of the original program in random poses."""
    rng, names = random_recording(frames, joints=14), breadth_first(biped())
    turns = normalized(rng.joint_orientation - 0.5)
    root, place = normalized(rng.root_orientation - 0.5), rng.root_position
    poses = forward_kinematics(biped(), place, root, dict(zip(names, np.moveaxis(turns, 1, 0), strict=True)))
    arrays = {name: rng[name] for name in QUANTITIES} | {
        "time": np.linspace(0.0, 0.29, frames), "joint_orientation": turns, "root_orientation": root,
        "body_position": np.stack([pose[0] for pose in poses.values()], axis=1),
        "body_orientation": np.stack([pose[1] for pose in poses.values()], axis=1),
    }  # fmt: skip
    return Recording.of(arrays, tuple(names), tuple(poses))


def fwalk() -> Scene:
    scene = load("fwalk")
    return substitute(scene, start_values(scene))


def test_positions_follow_from_orientations():
    recording = moving_biped()
    doll = doll_of(Scene("biped", biped()), ())
    positions = doll.positions(recording.root_position, recording.body_orientation, np.zeros((30, 0, 3)))
    np.testing.assert_allclose(positions, recording.body_position, atol=1e-12)


@pytest.mark.long
def test_positions_follow_where_joint_points_move():
    body = Body(1.0, (0.1, 0.1, 0.1))
    cart = Joint("slide", "rail", "cart", (0.1, 0.2, 0.0), (0.0, 0.05, 0.0), [(0.0, 0.6, 0.8)])
    rod = Joint("hinge", "cart", "rod", (0.0, 0.0, 0.1), (0.0, 0.3, 0.0), [(1.0, 0.0, 0.0)])
    cap = Joint(
        "coupled", "cart", "cap", (0.0, 0.1, 0.0), (0.0, -0.1, 0.0), follows="rod",
        translations=[Displacement((0.0, 1.0, 0.0), slope=0.2)],
    )  # fmt: skip
    bodies = dict.fromkeys(("rail", "cart", "rod", "cap"), body)
    character = Character("rail", bodies, {"cart": cart, "rod": rod, "cap": cap}, "fixed")
    start = InitialState(joints={"cart": JointState(coordinate=1.0, speed=2.0)})
    scene = Scene("cart", character, initial_state=start, failure=Failure(com_height=0.0), duration=0.2)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    recording = rollout.recording(0)
    track = track_of(recording, scene)
    assert track.doll.sliding == (1, 3)
    lines = {line.name for panel in panels_of(recording, scene) for line in panel.lines}
    assert "cart" in lines
    assert "cap" not in lines  # it has no coordinate
    assert np.ptp(recording.body_position[:, 1], axis=0).max() > 0.1
    assert np.ptp(track.slid[:, 1], axis=0).max() > 0.01
    positions = track.doll.positions(recording.root_position, recording.body_orientation, track.slid)
    np.testing.assert_allclose(positions, recording.body_position, atol=1e-6)


def test_desired_pose_turns_by_targets_from_parent_to_child_but_the_swing_hip_from_the_heading():
    recording, scene = moving_biped(), fwalk()
    track = track_of(recording, scene)
    assert track.desired is not None
    names = track.doll.names
    knee, thigh = names.body_of_joint("lKnee"), names.body_of_joint("lHip")
    head = normalized(recording.joint_target[:, knee - 1])
    from_parent = track.desired[:, thigh]
    expected = [_product(p, q) for p, q in zip(from_parent, head, strict=True)]
    np.testing.assert_allclose(track.desired[:, knee], expected, atol=1e-12)
    swing = names.body_of_joint("rHip")  # of the left stance, in which all frames are
    facing = recording.root_orientation * np.array([0.0, 1.0, 0.0, 1.0])
    facing = normalized(facing)
    target = normalized(recording.joint_target[:, swing - 1])
    expected = [_product(p, q) for p, q in zip(facing, target, strict=True)]
    same = np.abs(np.sum(track.desired[:, swing] * expected, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-9)


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    vector = p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3])
    return np.append(vector, p[3] * q[3] - p[:3] @ q[:3])


def test_force_acts_at_the_corners_of_the_sole_that_are_in_the_ground():
    recording, scene = moving_biped(1), fwalk()
    foot = recording.body_names.index("lFoot")
    recording.body_orientation[:] = (0.0, 0.0, 0.0, 1.0)
    recording.body_position[:] = (0.0, 1.0, 0.0)
    recording.body_position[0, foot] = (0.3, 0.030, 2.0)  # its sole is at -0.033
    center = track_of(recording, scene).foot_center[0, 0]
    np.testing.assert_allclose(center, (0.3, 0.0, 2.0 + (-0.09 + 0.055) / 2.0), atol=1e-12)


def test_thinning_keeps_every_frame_that_is_due():
    recording = moving_biped(30)
    assert thinned(recording, 50.0).time.tolist() == pytest.approx(recording.time[::2].tolist())
    assert thinned(recording, 1000.0).frames == thinned(recording, None).frames == 30


def test_motions_that_cannot_be_shown_are_one_clear_error():
    with pytest.raises(Error, match="no frames"):
        track_of(moving_biped().window(9.0), fwalk())
    with pytest.raises(Error, match=r"another character than that of the scene 'fwalk'"):
        track_of(random_recording(), fwalk())


def test_a_massless_body_is_nothing_to_see_unless_it_has_shapes():
    hinge = Joint("hinge", "world", "rod", (0.0, 1.0, 0.0), (0.0, 0.3, 0.0), [(1.0, 0.0, 0.0)])
    bodies = {"world": Body(0.0, (0.0, 0.0, 0.0)), "rod": Body(1.0, (0.1, 0.1, 0.1), [Sphere((0.0, 0.0, 0.0), 0.1)])}
    character = Character("world", bodies, {"swing": hinge}, "fixed")
    names = ["world", "rod"]
    assert {piece.body for piece in figure_of(character, (), names)} == {1}
    bodies["world"].shapes = [Sphere((0.0, 1.0, 0.0), 0.05)]
    assert {piece.body for piece in figure_of(character, (), names)} == {0, 1}
