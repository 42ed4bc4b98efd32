"""Lengths, lengthening speeds and moment arms of muscle paths: by differences and by virtual power."""

from dataclasses import dataclass

import numpy as np
import pytest
import warp as wp
from probes import evaluate, matrix, turn_about

from biped import biped
from random_states import random_states
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import path, stages
from warpmuscle.kernels.scratch import capacity_of, work_floats
from warpmuscle.model.paths import MusclePath, PathTable, path_table, paths_struct
from warpmuscle.scene import Actuation, Character, Condition, Muscle, Scene, ViaPoint
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages

ZERO = (0.0, 0.0, 0.0)
KNEE_BENT = Condition("lKnee", -0.5, 0.4, blend=0.3)
FOOT_TURNED = Condition("lAnkle", -0.4, 0.3, blend=0.4, axis=1)
FOOT_RAISED = Condition("lAnkle", -0.2, 0.9, blend=0.4)


@wp.kernel(enable_backward=False)
def multiply(a: wp.array[path.Weight], b: wp.array[path.Weight], product: wp.array[path.Weight]):
    i = wp.tid()
    product[i] = path.both(a[i], path.without(b[i]))


def test_products_of_weights_change_by_the_product_rule():
    """Of a(t) (1 - b(t)): the rate and the gradient are a' (1 - b) - a b'."""
    rng = np.random.default_rng(0)
    a, b = (
        {"value": rng.uniform(size=50), "rate": rng.normal(size=50), "gradient": rng.normal(size=(50, 3))}
        for _ in range(2)
    )
    product = wp.zeros(50, dtype=path.Weight, device="cpu")
    wp.launch(multiply, 50, [*(structs_to_device(path.Weight, one, "cpu") for one in (a, b)), product], device="cpu")
    found, rest = product.numpy(), 1.0 - b["value"]
    np.testing.assert_allclose(found["value"], a["value"] * rest, atol=1e-6)
    np.testing.assert_allclose(found["rate"], a["rate"] * rest - a["value"] * b["rate"], atol=1e-6)
    expected = a["gradient"] * rest[:, None] - a["value"][:, None] * b["gradient"]
    np.testing.assert_allclose(found["gradient"], expected, atol=1e-6)


def points(*places: tuple[str, tuple[float, float, float]]) -> list[ViaPoint]:
    return [ViaPoint(body, position) for body, position in places]


PATHS: dict[str, MusclePath] = {
    "knee": points(("lUpperleg", (0.0, -0.1, 0.05)), ("lLowerleg", (0.0, 0.1, 0.06))),
    "knee, upwards": points(("lLowerleg", (0.0, 0.1, 0.06)), ("lUpperleg", (0.0, -0.1, 0.05))),
    "hip to toes": points(
        ("pelvis", (0.1, 0.05, -0.08)),
        ("lUpperleg", (0.03, 0.1, -0.06)),
        ("lUpperleg", (0.03, -0.15, -0.06)),
        ("lLowerleg", (0.0, -0.1, -0.07)),
        ("lFoot", (0.04, 0.0, -0.06)),
        ("lToes", (0.01, -0.01, 0.02)),
    ),
    "over three joints at once": points(("torso", (0.05, 0.1, 0.1)), ("lLowerleg", (0.03, 0.0, 0.05))),
    "shin to shin": points(
        ("lLowerleg", (0.0, 0.1, 0.05)), ("lUpperleg", (0.02, 0.0, 0.06)), ("rLowerleg", (0.02, 0.1, 0.05))
    ),
    "arm to leg": points(("lUpperarm", (0.05, 0.02, 0.05)), ("rUpperleg", (0.02, 0.1, 0.05))),
    "within a body": points(("pelvis", (0.1, 0.0, 0.0)), ("pelvis", (-0.1, 0.0, 0.0))),
    "conditional": [
        ViaPoint("pelvis", (0.1, 0.05, 0.08)),
        ViaPoint("lUpperleg", (0.03, -0.1, 0.1), KNEE_BENT),
        ViaPoint("lUpperleg", (0.03, -0.2, 0.08), KNEE_BENT),
        ViaPoint("lLowerleg", (0.0, 0.05, 0.09), FOOT_TURNED),
        ViaPoint("lLowerleg", (0.0, -0.2, 0.08), FOOT_RAISED),
        ViaPoint("lFoot", (0.0, 0.0, 0.03)),
    ],
    "on a condition of a joint that it does not cross": [
        ViaPoint("pelvis", (0.1, 0.05, 0.08)),
        ViaPoint("pelvis", (0.1, -0.05, 0.12), FOOT_TURNED),
        ViaPoint("lUpperleg", (0.0, 0.05, 0.09)),
    ],
}


def character() -> Character:
    """The biped with ball, universal, hinge and fixed joints; the axes of an ankle are not at right angles."""
    c = biped()
    c.joints["lAnkle"].axes = [(1.0, 0.0, 0.0), (0.3, 0.2, 1.0)]
    c.joints["lElbow"].type, c.joints["lElbow"].axes = "fixed", []
    return c


@dataclass
class Geometry:
    """What the kernel says of n instances and M muscles with C crossings."""

    table: PathTable
    length: np.ndarray  # (n, M)
    speed: np.ndarray  # (n, M)
    arm: np.ndarray  # (n, C, 3)


def geometry_of(stages_: Stages, paths: dict[str, MusclePath], c: Character | None = None) -> Geometry:
    """Of paths whose numbers may be arrays with one value an instance.

    Args:
        c: the character with such arrays in place of its free parameters, if it has any.
    """
    names, c, n = stages_.names, c or stages_.scene.character, stages_.instances
    table, (model, state) = path_table(paths, names, c), stages_.structs
    model.paths, model.muscles.count = paths_struct(table, names, c, stages_.device), len(paths)
    shape = (n, max(len(paths), 1))
    outputs = [
        wp.zeros(shape, dtype=float, device=stages_.device),
        wp.zeros(shape, dtype=float, device=stages_.device),
        wp.zeros((n, max(len(table.crossings), 1)), dtype=wp.vec3, device=stages_.device),
    ]
    workspace = wp.zeros((n, work_floats(capacity_of(len(names.bodies)))), dtype=float, device=stages_.device)
    wp.launch(stages.muscle_paths_of(), n, [model, state, workspace], outputs, device=stages_.device)
    length, speed, arm = (array.numpy().astype(float) for array in outputs)
    return Geometry(table, length[:, : len(paths)], speed[:, : len(paths)], arm[:, : len(table.crossings)])


def somewhere(c: Character, count: int, seed: int = 0, speed: float = 3.0) -> Stages:
    """Random states of a character near the origin."""
    stages_, s = Stages(Scene("path", c), count, "cpu"), random_states(c, count, seed, speed)
    stages_.set_state(*(getattr(s, name) for name in type(s).__dataclass_fields__))
    return stages_


def gradient(stages_: Stages, geometry: Geometry) -> np.ndarray:
    """Derivatives of the lengths by the speeds' integrals (n, M, S), from the moment arms: arm . angular velocity.

    The angular velocity of each joint for a unit of each speed comes from the forward kinematics.
    """
    names, n = stages_.names, stages_.instances
    start, given = names.speed_start, stages_.structs[1].speeds.numpy().copy()
    result = np.zeros((n, len(geometry.table.muscles), names.speeds))
    for k in range(start[1], names.speeds):
        unit = np.zeros_like(given)
        unit[:, k] = 1.0
        stages_.structs[1].speeds.assign(unit)
        angular = stages_.forward_kinematics()["angular_velocity"].astype(float)
        body = int(np.searchsorted(start, k, side="right")) - 1
        relative = angular[:, body] - angular[:, names.parents[body]]
        for i, crossing in enumerate(geometry.table.crossings):
            if crossing.joint == body:
                result[:, crossing.muscle, k] = np.sum(geometry.arm[:, i] * relative, axis=1)
    stages_.structs[1].speeds.assign(given)
    return result


def differences(stages_: Stages, paths: dict[str, MusclePath], step: float = 4e-3) -> np.ndarray:
    """The same by central differences of the lengths; a ball joint turns about the axes of its child."""
    names, coordinates = stages_.names, stages_.structs[1].coordinates
    given = coordinates.numpy().copy()
    result = np.zeros((stages_.instances, len(paths), names.speeds))
    for body in range(1, len(names.bodies)):
        first = names.coordinate_start[body]
        for k in range(names.speed_start[body + 1] - names.speed_start[body]):
            lengths = []
            for way in (-step, step):
                moved = given.astype(float)
                if names.coordinate_start[body + 1] - first == 4:
                    q, turn = moved[:, first : first + 4], turn_about(np.eye(3)[k], np.array(way))
                    moved[:, first : first + 3] = (
                        q[:, 3:] * turn[:3] + turn[3] * q[:, :3] + np.cross(q[:, :3], turn[:3])
                    )
                    moved[:, first + 3] = q[:, 3] * turn[3] - q[:, :3] @ turn[:3]
                else:
                    moved[:, first + k] += way
                coordinates.assign(moved.astype(np.float32))
                lengths.append(geometry_of(stages_, paths).length)
            result[:, :, names.speed_start[body] + k] = (lengths[1] - lengths[0]) / (2.0 * step)
    coordinates.assign(given)
    return result


def test_moment_arms_are_the_derivatives_of_the_length_by_all_coordinates():
    """In states of which none is within a difference of the end of a blend, where the second derivative jumps."""
    stages_ = somewhere(character(), 40, seed=1)
    got, expected = gradient(stages_, geometry_of(stages_, PATHS)), differences(stages_, PATHS)
    assert np.abs(expected[:, list(PATHS).index("conditional")]).max() > 0.05
    np.testing.assert_allclose(got, expected, atol=2e-4)


def test_tension_does_the_work_that_shortening_takes():
    """sum(torque . relative angular velocity) = -sum(force * speed), with the torques F r acting on the parents."""
    stages_ = somewhere(character(), 500, seed=1)
    geometry, angular = geometry_of(stages_, PATHS), stages_.forward_kinematics()["angular_velocity"].astype(float)
    force = np.random.default_rng(2).uniform(0.0, 1000.0, geometry.length.shape)
    power, gross = np.zeros(500), np.sum(force * np.abs(geometry.speed), axis=1)
    for i, crossing in enumerate(geometry.table.crossings):
        relative = angular[:, stages_.names.parents[crossing.joint]] - angular[:, crossing.joint]
        part = np.sum(force[:, crossing.muscle, None] * geometry.arm[:, i] * relative, axis=1)
        power, gross = power + part, gross + np.abs(part)
    assert np.max(np.abs(power + np.sum(force * geometry.speed, axis=1)) / gross) < 1e-5


def test_speed_is_the_rate_of_the_length():
    stages_, h = somewhere(character(), 30, seed=3), 2e-3
    state, names = stages_.structs[1], stages_.names
    now, v = geometry_of(stages_, PATHS), state.speeds.numpy()
    gradients = differences(stages_, PATHS, h)  # of the joints; a free root does not stretch a muscle
    rate = np.einsum("nms,ns->nm", gradients[:, :, names.speed_start[1] :], v[:, names.speed_start[1] :])
    np.testing.assert_allclose(now.speed, rate, atol=5e-3)


def test_length_is_that_of_the_line_through_the_points():
    c = character()
    stages_ = somewhere(c, 50, seed=4)
    bodies, now = stages_.names.bodies, stages_.forward_kinematics()
    rotation, place = matrix(now["orientation"].astype(float)), now["position"].astype(float)
    fixed = {name: path_ for name, path_ in PATHS.items() if all(p.condition is None for p in path_)}
    got = geometry_of(stages_, fixed).length
    for i, path_ in enumerate(fixed.values()):
        where = [bodies.index(p.body) for p in path_]
        line = np.stack([place[:, b] + rotation[:, b] @ p.position for b, p in zip(where, path_, strict=True)])
        np.testing.assert_allclose(got[:, i], np.linalg.norm(np.diff(line, axis=0), axis=-1).sum(axis=0), atol=2e-6)


# Conditional points.


def on_the_knee(angles: np.ndarray, paths: dict[str, MusclePath]) -> tuple[Stages, Geometry]:
    """Paths at these knee angles, all else in the reference pose."""
    c = character()
    stages_ = Stages(Scene("path", c), len(angles), "cpu")
    coordinates = np.tile(stages_.structs[1].coordinates.numpy()[:1], (len(angles), 1))
    coordinates[:, stages_.names.coordinate_start[stages_.names.body_of_joint("lKnee")]] = angles
    stages_.structs[1].coordinates.assign(coordinates.astype(np.float32))
    return stages_, geometry_of(stages_, paths)


def with_condition(condition: Condition | None) -> MusclePath:
    return [
        ViaPoint("lUpperleg", (0.0, -0.1, 0.05)),
        ViaPoint("lUpperleg", (0.0, -0.2, 0.07), condition),
        ViaPoint("lUpperleg", (0.0, -0.25, 0.07), condition),
        ViaPoint("lLowerleg", (0.0, 0.1, 0.06)),
    ]


def test_conditional_points_count_within_the_interval_and_not_outside():
    angles = np.linspace(-1.2, 1.2, 481)
    through = with_condition(None)
    paths = {"on": through, "off": [through[0], through[-1]], "both": with_condition(KNEE_BENT)}
    length = on_the_knee(angles, paths)[1].length
    inside = (angles > -0.35) & (angles < 0.25)
    outside = (angles < -0.65) | (angles > 0.55)
    np.testing.assert_allclose(length[inside, 2], length[inside, 0], atol=1e-6)
    np.testing.assert_allclose(length[outside, 2], length[outside, 1], atol=1e-6)
    assert np.all(length[:, 2] < length[:, 0] + 1e-6)
    assert np.all(length[:, 2] > length[:, 1] - 1e-6)


def test_length_and_moment_arm_have_no_jump_where_a_point_comes_in():
    """Halving the distance of poses halves the largest change from pose to pose."""
    changes = []
    for count in (400, 800):
        stages_, geometry = on_the_knee(np.linspace(-1.2, 1.2, count), {"both": with_condition(KNEE_BENT)})
        arm = gradient(stages_, geometry).sum(axis=(1, 2))
        changes.append([np.abs(np.diff(values)).max() for values in (geometry.length[:, 0], arm)])
    np.testing.assert_allclose(np.array(changes[1]) / changes[0], 0.5, atol=0.05)


def test_weight_of_a_condition_is_half_at_its_ends_and_its_slope_is_its_derivative():
    angle, h = np.linspace(-2.0, 2.0, 400), 1e-3
    value = evaluate(path.condition_weight, [-0.7, 0.9], -0.7, 0.9, 0.2)[:, 0]
    np.testing.assert_allclose(value, 0.5, atol=1e-6)
    weight = [evaluate(path.condition_weight, angle + d, -0.7, 0.9, 0.2) for d in (-h, 0.0, h)]
    np.testing.assert_allclose(weight[1][:, 1], (weight[2] - weight[0])[:, 0] / (2.0 * h), atol=5e-3)


# Numbers, batches and errors.


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
    p = paths_struct(table, names, character(), "cpu")
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


def test_fixed_joints_have_no_muscles():
    c = character()
    over_elbow = {"m": points(("lUpperarm", ZERO), ("lLowerarm", ZERO))}
    assert path_table(over_elbow, topology(c), c).crossings == []


def test_direction_of_a_path_does_not_matter():
    geometry = geometry_of(somewhere(character(), 12, seed=5), PATHS)
    np.testing.assert_allclose(geometry.length[:, 0], geometry.length[:, 1], atol=1e-6)
    knee = [i for i, crossing in enumerate(geometry.table.crossings) if crossing.muscle in (0, 1)]
    np.testing.assert_allclose(*geometry.arm[:, knee].swapaxes(0, 1), atol=1e-6)


def test_result_does_not_depend_on_the_slot():
    chosen = [7, 3]
    many, few = somewhere(character(), 12, seed=5), Stages(Scene("path", character()), 2, "cpu")
    for name in ("coordinates", "speeds"):
        getattr(few.structs[1], name).assign(getattr(many.structs[1], name).numpy()[chosen])
    together, alone = geometry_of(many, PATHS), geometry_of(few, PATHS)
    for name in ("length", "speed", "arm"):
        assert np.array_equal(getattr(alone, name), getattr(together, name)[chosen])


def test_instances_may_have_their_own_points_and_conditions():
    heights = np.linspace(-0.2, 0.0, 5)
    low = np.array([-0.5, -0.5, 0.3, 0.3, 0.3])
    varied = with_condition(Condition("lKnee", low, 1.0, 0.1))
    varied[0].position = (0.0, heights, 0.05)
    together = on_the_knee(np.zeros(5), {"m": varied})[1].length[:, 0]
    for i in range(5):
        varied = with_condition(Condition("lKnee", float(low[i]), 1.0, 0.1))
        varied[0].position = (0.0, float(heights[i]), 0.05)
        assert together[i] == on_the_knee(np.zeros(1), {"m": varied})[1].length[0, 0]


def test_no_muscles_are_no_trouble():
    assert geometry_of(somewhere(character(), 2), {}).arm.shape == (2, 0, 3)


def test_stages_give_the_paths_of_all_muscles_of_a_character_even_if_none_drives_a_joint():
    c, s = character(), random_states(character(), 3)
    c.muscles = {name: Muscle(path=list(path_), f_max=1000.0, l_opt=0.1, l_slack=0.1) for name, path_ in PATHS.items()}
    stages_ = Stages(Scene("path", c, actuation={name: Actuation("none") for name in moving(c)}), 3, "cpu")
    stages_.set_state(*(getattr(s, name) for name in type(s).__dataclass_fields__))
    got, expected = stages_.muscle_paths(), geometry_of(somewhere(character(), 3), PATHS)
    assert np.array_equal(got.length, expected.length)
    assert np.array_equal(got.speed, expected.speed)
    assert np.array_equal(got.moment_arm, expected.arm)
    assert got.muscle == tuple(crossing.muscle for crossing in expected.table.crossings)
    assert got.joint == tuple(crossing.joint - 1 for crossing in expected.table.crossings)
    assert stages_.model.muscles.count == 0


def moving(c: Character) -> list[str]:
    """Names of the joints that can be driven."""
    return [name for name, joint in c.joints.items() if joint.type != "fixed"]


HERE, THERE = ViaPoint("pelvis", ZERO), ViaPoint("lFoot", ZERO)


@pytest.mark.parametrize(
    ("bad", "key", "message"),
    [
        ([HERE], "", "at least two points, got 1"),
        ([HERE, ViaPoint("tail", ZERO)], ".1.body", "no body 'tail'"),
        ([ViaPoint("pelvis", ZERO, KNEE_BENT), THERE], ".0.condition", "take no condition"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("knee", 0.0, 1.0)), THERE], ".1.condition.joint", "no joint 'knee'"),
        (
            [HERE, ViaPoint("pelvis", ZERO, Condition("lHip", 0.0, 1.0)), THERE],
            ".1.condition.blend",
            "give a blend of 0",
        ),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 0.0, 1.0, axis=1)), THERE], ".1.condition.axis", "angle 1"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 1.0, 1.0)), THERE], ".1.condition.low", "not less"),
        ([HERE, ViaPoint("pelvis", ZERO, Condition("lKnee", 0.0, 1.0, -0.1)), THERE], ".1.condition.blend", "negative"),
    ],
)
def test_errors_say_what_is_wrong_and_where(bad: list[ViaPoint], key: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        path_table({"SOL": bad}, topology(biped()), biped())
    assert caught.value.key == f"muscles.SOL.path{key}"
