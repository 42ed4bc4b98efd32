"""Devices on a pendulum against closed forms and double precision, and the power that recordings have of them."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from muscle_arm import ABOUT_JOINT, MASS, REACH, arm
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.force import devices as kernels
from warpmuscle.kernels.force.cycle_torque import KNOTS, CycleTorque, side_of, torque_at
from warpmuscle.kernels.force.devices import FORCES
from warpmuscle.kernels.force.joint_motor import JointMotor, joint_motor_torque
from warpmuscle.kernels.structs import LEFT, RIGHT, BodyPlan, Feet, Model, Scratch, Skeleton, State
from warpmuscle.model.forces import shipped
from warpmuscle.scene import Actuation, Force, InitialState, JointState, Scene
from warpmuscle.scene.force import power_name
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

STEP, STEPS, GRAVITY, START = 0.0005, 1000, 9.8, 3.0  # s, steps, m/s^2, rad/s
WHERE = {
    "bilinear_spring": {"joint": "elbow"}, "cycle_torque": {"joint": "elbow"}, "weight_support": {"body": "tip"},
    "point_spring": {"body": "base", "other_body": "tip"}, "joint_motor": {"body": "base", "other_body": "tip"},
    "push": {"body": "tip"},
}  # fmt: skip


def device(kind: str, **values: float) -> Force:
    names = FORCES[kind].parameters.vars
    return Force(kind, **WHERE[kind], parameters=dict.fromkeys(names, 0.0) | values)


def pendulum(**devices: Force) -> Scene:
    """A body on a hinge without friction that is pushed at the start; all its scenes share a kernel."""
    idle = {kind: device(kind) for kind in WHERE}
    scene = arm(
        actuation={"elbow": Actuation("torque")}, forces=idle | devices, duration=STEPS * STEP, time_step=STEP,
        initial_state=InitialState((0.0, 1.0, 0.0)),
    )  # fmt: skip
    scene.character.feet = ("tip", "base")
    scene.initial_state.joints = {"elbow": JointState(angular_velocity=(START, 0.0, 0.0))}
    check_scene(scene)
    return scene


def swing(**devices: Force) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Angles, speeds and powers of devices at every step."""
    rollout = Rollout(pendulum(**devices), 1, "cpu", record=[0], record_rate=1.0 / STEP)
    rollout.run()
    seen = rollout.recording()
    assert set(seen.recorded_names) == {power_name(name) for name in {*WHERE, *devices}}
    assert set(seen.recorded_units) == {"W"}
    powers = {name: seen.recorded[:, seen.recorded_names.index(power_name(name))] for name in {*WHERE, *devices}}
    q, v = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))
    return q[:, 7], v[:, -1], powers


def expected(torque) -> np.ndarray:
    """Angles by leapfrog in double precision, under a torque (angle, speed) besides gravity."""
    q, middle = 0.0, START
    found = np.empty(STEPS)
    for step in range(STEPS):
        found[step] = q
        a = (torque(q, middle) - MASS * GRAVITY * REACH * np.sin(q)) / ABOUT_JOINT
        middle += (STEP if step else 0.5 * STEP) * a
        q += STEP * middle
    return found


def test_an_orthosis_stores_what_it_takes_and_gives_it_back():
    k, rest = 40.0, 0.1
    angle, speed, power = swing(bilinear_spring=device("bilinear_spring", rest_angle=rest, stiffness_above=k))
    stretch = np.maximum(angle - rest, 0.0)
    assert angle == pytest.approx(expected(lambda q, v: -k * max(q - rest, 0.0)), abs=2e-4)
    assert power["bilinear_spring"] == pytest.approx(-k * stretch * speed, abs=1e-3)
    work = np.concatenate(
        [[0.0], np.cumsum(0.5 * STEP * (power["bilinear_spring"][1:] + power["bilinear_spring"][:-1]))]
    )
    assert work == pytest.approx(-0.5 * k * stretch**2, abs=2e-3)
    assert work.min() < -0.3
    assert np.all(power["weight_support"] == 0.0)


def test_a_harness_that_carries_all_that_hangs_leaves_the_speed_as_it_is():
    """Both bodies weigh the same: half of the weight of the character is that of the one that swings."""
    angle, speed, power = swing(weight_support=device("weight_support", share=0.5))
    assert speed == pytest.approx(START, abs=1e-4)
    assert power["weight_support"] == pytest.approx(MASS * GRAVITY * REACH * np.sin(angle) * speed, abs=1e-3)


def test_a_push_comes_again_at_its_intervals_until_its_end():
    force, moment, place = np.array([-3.0, 5.0]), 0.2, np.array([0.05, -0.02])  # (y, z)
    times = {"start": 0.05, "duration": 0.02, "interval": 0.1, "end": 0.3}
    angle, _speed, power = swing(
        push=device(
            "push", **times, force_y=force[0], force_z=force[1], moment_x=moment, place_y=place[0], place_z=place[1]
        )
    )
    on = np.zeros(STEPS, dtype=bool)
    for begun in (0.05, 0.15, 0.25):
        on[round(begun / STEP) : round((begun + 0.02) / STEP)] = True
    q, middle, found = 0.0, START, np.empty(STEPS)
    for step in range(STEPS):
        found[step] = q
        y, z = place[0] - REACH, place[1]
        arm = np.array([y * np.cos(q) - z * np.sin(q), y * np.sin(q) + z * np.cos(q)])
        pushed = (arm[0] * force[1] - arm[1] * force[0] + moment) if on[step] else 0.0
        middle += (STEP if step else 0.5 * STEP) * (pushed - MASS * GRAVITY * REACH * np.sin(q)) / ABOUT_JOINT
        q += STEP * middle
    assert angle == pytest.approx(found, abs=2e-4)
    assert np.all(power["push"][~on] == 0.0)
    assert np.all(power["push"][on] != 0.0)


def test_a_cord_between_points_pulls_by_its_stretch_and_does_nothing_where_it_is_slack():
    k, d, rest = 300.0, 2.0, 0.29
    base, tip = np.array([0.1, -0.15]), np.array([0.02, -0.03])  # (y, z), from the centres of mass

    def place(q: float) -> np.ndarray:
        y, z = tip[0] - REACH, tip[1]
        return np.array([y * np.cos(q) - z * np.sin(q), y * np.sin(q) + z * np.cos(q)])

    def length(q: float) -> float:
        return float(np.linalg.norm(place(q) - base))

    def arm_of(q: float) -> float:
        return (length(q + 1e-6) - length(q - 1e-6)) / 2e-6

    def torque(q: float, v: float) -> float:
        stretch = length(q) - rest
        return -(k * stretch + d * arm_of(q) * v) * arm_of(q) if stretch > 0.0 else 0.0

    cord = device(
        "point_spring", first_y=base[0], first_z=base[1], second_y=tip[0], second_z=tip[1], rest_length=rest,
        stiffness_above=k, damping=d,
    )  # fmt: skip
    angle, speed, power = swing(point_spring=cord)
    assert angle == pytest.approx(expected(torque), abs=2e-3)
    there = np.array([torque(q, v) * v for q, v in zip(angle, speed, strict=True)])
    assert power["point_spring"] == pytest.approx(there, abs=2e-3)
    assert 0.05 < np.mean(there == 0.0) < 0.95  # both happen


def test_a_motor_between_bodies_holds_the_second_one_upright():
    """It hangs from a base that stands still: leaning backwards is a turn about -x, and the joint's own spring adds."""
    values = {"lean_gain": 8.0, "lean_target": -0.2, "lean_damping": 0.05, "stiffness": 3.0, "damping": 0.02}
    angle, speed, power = swing(joint_motor=device("joint_motor", most=100.0, **values))

    def torque(q: float, v: float) -> float:
        return 8.0 * (0.2 - q) - 0.05 * v - 3.0 * q - 0.02 * v

    assert angle == pytest.approx(expected(torque), abs=2e-3)
    assert power["joint_motor"] == pytest.approx(torque(angle, speed) * speed, abs=5e-3)
    weak, speed, power = swing(joint_motor=device("joint_motor", most=0.3, **values))
    assert np.abs(weak - angle).max() > 0.1
    assert np.abs(power["joint_motor"]).max() == pytest.approx(0.3 * np.abs(speed).max(), rel=0.02)


@wp.kernel(enable_backward=False, module="unique")
def motor_torques(
    turned: wp.array[wp.vec3], spin: wp.array[wp.vec3], bent: wp.array[wp.vec3], rate: wp.array[wp.vec3],
    motor: JointMotor, torque: wp.array[wp.vec3],
):  # fmt: skip
    i = wp.tid()
    torque[i] = joint_motor_torque(turned[i], spin[i], bent[i], rate[i], motor)


def test_a_motor_between_bodies_about_all_axes_is_that_of_hyfydy_with_scones_reflexes():
    rng = np.random.default_rng(5)
    given = rng.uniform(-0.5, 0.5, (4, 40, 3)).astype(np.float32)
    values = dict(zip(JointMotor.vars, rng.uniform(1.0, 20.0, 12), strict=True))
    values |= {f"{axis}_target": 0.01 * values[f"{axis}_target"] for axis in ("lean", "list", "turn")}
    motor = filled(JointMotor, **values | {"most": 10.0})
    torque = wp.zeros(40, dtype=wp.vec3, device="cpu")
    arrays = [wp.array(rows, dtype=wp.vec3, device="cpu") for rows in given]
    wp.launch(motor_torques, 40, [*arrays, motor, torque], device="cpu")
    turned, spin, bent, rate = given.astype(float)
    to_ours = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # of SCONE's axes: x forward, z right
    axes = to_ours.T  # rows: x, y and z of SCONE's, which list, turn and lean are about
    gain, target, damping = (
        np.array([values[f"{axis}_{what}"] for axis in ("list", "turn", "lean")])
        for what in ("gain", "target", "damping")
    )
    asked = gain * (target - turned @ axes.T) - damping * (spin @ axes.T)
    wanted = asked @ axes - values["stiffness"] * bent - values["damping"] * rate
    size = np.linalg.norm(wanted, axis=1, keepdims=True)
    assert 0.1 < np.mean(size > 10.0) < 1.0
    wanted *= np.minimum(1.0, 10.0 / size)
    np.testing.assert_allclose(torque.numpy(), wanted, rtol=2e-4, atol=2e-4)


def test_a_motor_gives_its_first_torque_where_no_foot_has_landed():
    angle, speed, power = swing(cycle_torque=device("cycle_torque", torque_0=0.7, torque_1=100.0))
    assert angle == pytest.approx(expected(lambda q, v: 0.7), abs=2e-4)
    assert power["cycle_torque"] == pytest.approx(0.7 * speed, abs=1e-4)


@wp.kernel(enable_backward=False)
def torques(part: wp.array[float], torque: CycleTorque, result: wp.array[float]):
    i = wp.tid()
    result[i] = torque_at(part[i], torque)


def test_torques_run_straight_from_knot_to_knot_and_round_the_cycle():
    knots = np.random.default_rng(0).normal(size=KNOTS)
    part = np.concatenate([np.linspace(0.0, 1.0, 101), [-0.2, 1.3]])
    given = filled(CycleTorque, **{f"torque_{k}": knots[k] for k in range(KNOTS)})
    result = wp.zeros(len(part), dtype=float, device="cpu")
    wp.launch(torques, len(part), [wp.array(part, dtype=float, device="cpu"), given], [result], device="cpu")
    right = np.interp(np.clip(part, 0.0, 1.0), np.linspace(0.0, 1.0, KNOTS + 1), [*knots, knots[0]])
    assert result.numpy() == pytest.approx(right, abs=1e-5)


@wp.kernel(enable_backward=False)
def sides(model: Model, result: wp.array[int]):
    body = wp.tid()
    result[body] = side_of(body, model)


def test_each_joint_of_a_leg_follows_its_own_foot():
    """Bodies: 0 pelvis; 1 and 2 thighs, 3 and 4 shanks, 5 and 6 feet, 7 and 8 toes."""
    parents = np.array([-1, 0, 0, 1, 2, 3, 4, 5, 6], dtype=np.int32)
    plan = np.zeros(len(parents), dtype=BodyPlan.numpy_dtype())
    plan["parent"] = parents
    skeleton = filled(Skeleton, plan=wp.array(plan, dtype=BodyPlan, device="cpu"))
    model = filled(Model, skeleton=skeleton, feet=filled(Feet, left=5, right=6))
    result = wp.zeros(7, dtype=int, device="cpu")
    wp.launch(sides, 7, [model], [result], device="cpu")
    assert list(result.numpy()[1:]) == [LEFT, RIGHT] * 3


def test_a_motor_that_follows_a_gait_cycle_is_on_one_leg():
    scene = pendulum()
    scene.character.feet = None
    with pytest.raises(SceneError, match="no foot hangs on 'elbow'") as caught:
        check_scene(scene)
    assert caught.value.key == "forces.cycle_torque.joint"


@wp.kernel(enable_backward=False)
def limited(model: Model, state: State, work: Scratch, limit: kernels.CoordinateLimit, found: wp.array[wp.vec3]):
    its = work
    found[0] = kernels.coordinate_limit(0, 1, model, state, its, limit)


def test_a_limit_acts_along_the_first_coordinate_of_its_joint_alone():
    plan = {"coordinate_start": [0, 0], "speed_start": [0, 0]}
    model = filled(Model, skeleton=filled(Skeleton, plan=plan))
    state = filled(State, coordinates=np.float32([[0.9, 0.0]]), speeds=np.float32([[0.0, 0.0]]))
    limit = filled(kernels.CoordinateLimit, low=-0.5, high=0.5, transition=0.1, stiffness_above=20.0)
    found = wp.zeros(1, dtype=wp.vec3, device="cpu")
    wp.launch(limited, 1, [model, state, filled(Scratch), limit, found], device="cpu")
    np.testing.assert_allclose(found.numpy()[0], [-20.0 * 0.4, 0.0, 0.0], rtol=1e-5)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"effort": None}, "force 'odd' in FORCES of devices.py needs one Warp function: `effort`"),
        ({"parameters": int}, "force 'odd' .*: its `parameters` are not a @wp.struct of floats"),
        ({"positive": ("damping", "width")}, "`positive` must be a tuple of names of parameters, 'width' is not"),
        ({"positive": "damping"}, "`positive` must be a tuple of names of parameters, 'damping' is not"),
        ({"of_angle": False}, "force 'odd' .* reads a coordinate of its joint: say `of_angle=True`"),
    ],
)
def test_what_a_shipped_kind_forgets_is_named(changed: dict[str, object], message: str):
    with pytest.raises(TypeError, match=message):
        kernels.checked("odd", FORCES["bilinear_spring"]._replace(**changed))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"parameters": None}, r"kernels/force/devices.py: it takes \(int, int, Model, State, Scratch\), but .*spring"),
        ({"effort": len}, "'odd' must be a Warp function"),
        ({"effort": FORCES["air_drag"].wrench, "parameters": FORCES["air_drag"].parameters}, "returns wp.vec3"),
    ],
)
def test_functions_of_a_shipped_kind_are_looked_at(
    changed: dict[str, object], message: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(FORCES, "odd", FORCES["bilinear_spring"]._replace(**changed))
    with pytest.raises(SceneError, match=message):
        shipped("odd")


@pytest.mark.parametrize("name", FORCES)
def test_shipped_kinds_forget_nothing(name: str):
    assert shipped(name) == FORCES[name]
