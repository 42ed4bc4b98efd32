"""A SIMBICON controller as the device has it: curves, components, trajectories and states in flat arrays."""

import numpy as np
import pytest

from warpmuscle.kernels import structs
from warpmuscle.kernels.control.control import NO_CONTROLLER
from warpmuscle.model.controllers.simbicon import HELD, SIMBICON, Knots, control_steps, model_fields, trajectory_bodies
from warpmuscle.model.controllers.table import (
    compiled_controller,
    controller_fields,
    controller_start,
    controller_state,
)
from warpmuscle.scene import (
    PD,
    Balance,
    Body,
    Character,
    Component,
    Controller,
    Curve,
    Feedback,
    Joint,
    MachineState,
    Scene,
    Trajectory,
)
from warpmuscle.scene.topology import topology

ZERO, X, Y = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
PELVIS, LEFT_HIP, RIGHT_HIP, LEFT_FOOT, RIGHT_FOOT = range(5)  # numbers of bodies; a joint has that of its child


def scene_of() -> Scene:
    """Two states with every feature."""
    bodies = {name: Body(1.0, (1.0, 1.0, 1.0)) for name in ("pelvis", "lThigh", "rThigh", "lFoot", "rFoot")}
    joints = {
        f"{side}{name}": Joint(kind, parent.format(side), f"{side}{child}", ZERO, ZERO, axes)
        for name, kind, parent, child, axes in (
            ("Hip", "ball", "pelvis", "Thigh", [X, Y]), ("Ankle", "hinge", "{}Thigh", "Foot", [X]),
        )
        for side in "lr"
    }  # fmt: skip
    lateral = Feedback((0.0, 0.0, 2.0), 0.5, 0.3, d_limits=(-0.1, 0.2), v_limits=(-0.5, 0.4))
    first = MachineState(
        0.5,
        {
            "SWING_Hip": Trajectory(
                [
                    Component((0.0, 3.0, 4.0), [0.0, 0.6], [0.1, -0.3], reverse_on="left", feedback=lateral),
                    Component(X, [0.2], [0.7], reverse_on="right"),
                ],
                strength=Curve([0.0, 0.5, 1.0], [1.0, 0.8, 0.6]),
            ),
            "STANCE_Ankle": Trajectory([Component(X, [0.0], [0.4])], frame="character"),
            "lAnkle": Trajectory([Component(X, [0.0], [0.2])]),
        },
        1, "time_up", "right",
        balance=Balance(Curve([0.0], [0.05]), None, Curve([0.0, 1.0], [0.2, 0.3]), None),
    )  # fmt: skip
    second = MachineState(0.3, {"rHip": Trajectory([Component(X, [0.0], [0.9])])}, 0, "foot_down", "same", longest=1.4)
    controller = Controller(
        [first, second],
        {"root": PD(800.0, 60.0, 300.0, (1.0, 0.5, 0.9)), "rHip": PD(300.0, 30.0, 150.0, (1.0, 0.6, 0.8))},
        stance_hip_damping=25.0, stance_hip_max_velocity=2.0, root_predictive_torque_scale=3.0, desired_heading=0.3,
    )  # fmt: skip
    scene = Scene("typed", Character("pelvis", bodies, joints), controller)
    return scene


@pytest.fixture(scope="module")
def made() -> structs.Simbicon:
    scene = scene_of()
    names = topology(scene.character)
    assert names.joints == ("lHip", "rHip", "lAnkle", "rAnkle")
    return model_fields(scene, names, "cpu")["simbicon"]


def test_gains_stand_by_joint_and_joints_without_have_none(made: structs.Simbicon):
    gains = made.gains.numpy()[0]
    np.testing.assert_allclose(gains["kp"], [800.0, 0.0, 300.0, 0.0, 0.0])
    np.testing.assert_allclose(gains["kd"], [60.0, 0.0, 30.0, 0.0, 0.0])
    np.testing.assert_allclose(gains["torque_limit"], [300.0, 0.0, 150.0, 0.0, 0.0])
    np.testing.assert_allclose(gains["scale"], [(1.0, 0.5, 0.9), ZERO, (1.0, 0.6, 0.8), ZERO, ZERO], rtol=1e-6)
    hip = made.hip.numpy()[0, 0]
    numbers = [hip[name] for name in ("damping", "max_velocity", "predictive_scale", "desired_heading")]
    np.testing.assert_allclose(numbers, [25.0, 2.0, 3.0, 0.3], rtol=1e-6)
    assert (made.left_hip, made.right_hip, made.heading_control) == (LEFT_HIP, RIGHT_HIP, 1)


def test_states_follow_one_another_by_their_rules(made: structs.Simbicon):
    states = made.states.numpy()
    np.testing.assert_array_equal(states["next_state"], [1, 0])
    np.testing.assert_array_equal(states["on_foot_down"], [0, 1])
    np.testing.assert_array_equal(states["stance_rule"], [structs.RIGHT, structs.SAME])
    np.testing.assert_array_equal(states["first_trajectory"], [0, 3])
    np.testing.assert_array_equal(states["end_trajectory"], [3, 4])
    time = made.state_time.numpy()[0]
    np.testing.assert_allclose(time[:, 0], [0.5, 0.3])
    assert time[1, 1] == pytest.approx(1.4)


def curve(made: structs.Simbicon, first: int, end: int) -> list[tuple[float, float]]:
    knots = made.knots.numpy()[0, first:end]
    return [(round(float(p), 6), round(float(v), 6)) for p, v in zip(knots["phase"], knots["value"], strict=True)]


def test_trajectories_have_their_bodies_strengths_and_components(made: structs.Simbicon):
    t = made.trajectories.numpy()
    np.testing.assert_array_equal(t["left_body"], [RIGHT_HIP, -1, LEFT_FOOT, RIGHT_HIP])  # of SWING_Hip in left stance
    np.testing.assert_array_equal(t["right_body"], [LEFT_HIP, RIGHT_FOOT, LEFT_FOOT, RIGHT_HIP])
    np.testing.assert_array_equal(t["character_frame"], [0, 1, 0, 0])
    np.testing.assert_array_equal(t["first_component"], [0, 2, 3, 4])
    np.testing.assert_array_equal(t["end_component"], [2, 3, 4, 5])
    assert curve(made, t["first_knot"][0], t["end_knot"][0]) == [(0.0, 1.0), (0.5, 0.8), (1.0, 0.6)]
    np.testing.assert_array_equal(t["end_knot"][1:], 0)


def test_components_have_unit_axes_curves_and_feedback(made: structs.Simbicon):
    plan, row = made.components.numpy(), made.component_rows.numpy()[0]
    np.testing.assert_array_equal(plan["reverse"], [structs.LEFT, structs.RIGHT, -1, -1, -1])
    np.testing.assert_array_equal(plan["has_feedback"], [1, 0, 0, 0, 0])
    angles = [curve(made, first, end) for first, end in zip(plan["first_knot"], plan["end_knot"], strict=True)]
    assert angles == [[(0.0, 0.1), (0.6, -0.3)], [(0.2, 0.7)], [(0.0, 0.4)], [(0.0, 0.2)], [(0.0, 0.9)]]
    np.testing.assert_allclose(row["axis"], [(0.0, 0.6, 0.8), X, X, X, X], rtol=1e-6)
    np.testing.assert_allclose(row["feedback_axis"][0], (0.0, 0.0, 1.0))
    np.testing.assert_allclose(row["feedback_gain"][0], (0.5, 0.3), rtol=1e-6)
    np.testing.assert_allclose(row["feedback_limits"][0], (-0.1, 0.2, -0.5, 0.4), rtol=1e-6)


def test_balance_has_four_curves_some_of_them_empty(made: structs.Simbicon):
    knots = np.asarray(made.balance_knots.numpy()).reshape(2, 8)
    ends = knots[0].reshape(4, 2).tolist()
    assert [curve(made, *pair) for pair in ends] == [[(0.0, 0.05)], [], [(0.0, 0.2), (1.0, 0.3)], []]
    np.testing.assert_array_equal(knots[1], [0] * 7 + [-1])


def test_of_two_trajectories_of_a_joint_the_later_one_counts():
    scene = scene_of()
    names = topology(scene.character)
    found = trajectory_bodies(scene.controller.states[0], scene.controller, names)
    assert found == [(RIGHT_HIP, LEFT_HIP), (-1, RIGHT_FOOT), (LEFT_FOOT, LEFT_FOOT)]


def test_curves_lie_one_behind_the_other():
    knots = Knots()
    found = [knots.add([0.0, 1.0], [2.0, 3.0]), knots.add_curve(None), knots.add_curve(Curve([0.5], [4.0]))]
    assert found == [(0, 2), (0, 0), (2, 3)]
    assert (knots.phase, knots.value) == ([0.0, 1.0, 0.5], [2.0, 3.0, 4.0])


def test_a_controller_slower_than_the_steps_holds_its_targets():
    scene = scene_of()
    for rate, step, steps in ((0.0, 0.0005, 1), (1000.0, 0.0005, 2), (2000.0, 0.0005, 1), (1e5, 0.0005, 1)):
        scene.control_rate, scene.time_step = rate, step
        assert control_steps(scene) == steps
        assert compiled_controller(scene, ()) == (HELD if steps > 1 else SIMBICON)
        assert model_fields(scene, topology(scene.character), "cpu")["simbicon"].every == steps


def test_a_scene_without_a_controller_has_none_of_its_numbers_nor_room_for_its_state():
    scene = scene_of()
    names = topology(scene.character)
    assert controller_start(scene) == {"simbicon.stance": structs.LEFT, "simbicon.machine_state": 0}
    arrays = controller_state(scene, 3, names, lambda *shape, dtype=float: shape)
    assert set(arrays) == {f"simbicon.{name}" for name in structs.SimbiconState.vars}
    assert set(arrays.values()) == {(3,), (0, len(names.bodies))}
    scene.controller = None
    assert compiled_controller(scene, ()) == NO_CONTROLLER
    assert (controller_fields(scene, names, "cpu"), controller_start(scene)) == ({}, {})
    assert controller_state(scene, 3, names, np.zeros) == {}
