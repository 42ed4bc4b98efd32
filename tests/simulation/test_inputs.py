"""Excitations, motions and starts of instances do what a scene's own do, in any batch; errors say what is wrong."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from same_values import assert_same
from warpmuscle.core.errors import RolloutError
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    Excitation,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    MuscleModel,
    Pulley,
    Scene,
)
from warpmuscle.simulation.inputs import Inputs
from warpmuscle.simulation.multi_device import MultiDeviceRollout
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
X, ZERO = (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)
DURATION, RATE = 0.1, 1000.0
TIME = np.linspace(0.0, DURATION, 6)
QUANTITIES = ["coordinates", "speeds", "muscle_activation"]


def arm(**changes) -> Scene:
    """Two hinges below a base that moves as prescribed, the first one kinematic, the second one with two muscles."""
    bodies = {name: Body(1.0, (0.02, 0.01, 0.02)) for name in ("base", "upper", "lower")}
    joints = {
        "shoulder": Joint("hinge", "base", "upper", ZERO, (0.0, 0.2, 0.0), [X]),
        "elbow": Joint("hinge", "upper", "lower", (0.0, -0.2, 0.0), (0.0, 0.2, 0.0), [X]),
    }
    given = {"f_max": 300.0, "l_opt": 0.1, "l_slack": 0.2, "rest_length": 0.3}
    muscles = {
        name: Muscle(pulleys=[Pulley("elbow", arm)], excitation=Excitation([0.0, DURATION], [0.0, share]), **given)
        for name, arm, share in (("flexor", 0.03, 0.6), ("extensor", -0.02, 0.2))
    }
    scene = Scene("arm", Character("base", bodies, joints, "planar", muscles), duration=DURATION, time_step=1.0 / RATE)
    scene.actuation = {"shoulder": Actuation("kinematic"), "elbow": Actuation("muscle", damping=0.1)}
    scene.motion = {"root": Motion([0.0], position=[ZERO]), "shoulder": Motion(TIME.tolist(), wave(0).tolist())}
    scene.failure, scene.ground = Failure(0.0, 0.0), Ground(stiffness=0.0)
    scene.muscle_model = MuscleModel(activation="neural", implicit_damping=True)
    for field, value in changes.items():
        setattr(scene, field, value)
    return scene


def wave(seed: int) -> np.ndarray:
    return 0.4 * np.sin(20.0 * TIME + seed)


def batch(count: int, scene: Scene | None = None, record: list[int] | None = None, **options) -> Rollout:
    chosen = list(range(count)) if record is None else record
    return Rollout(
        scene or arm(), count, "cpu", record=chosen, record_rate=RATE, quantities=QUANTITIES, **options
    )  # fmt: skip


def recorded(rollout: Rollout) -> list[np.ndarray]:
    rollout.run()
    return [rollout.recorded(name).copy() for name in QUANTITIES]


def moved(seed: int) -> np.ndarray:
    """Values (coordinates, times) of the kinematic coordinates: those of the root, and the shoulder."""
    return np.stack([0.05 * wave(seed + 1), 0.1 * wave(seed + 2), 0.2 * wave(seed + 3), wave(seed)])


def test_given_excitations_and_motion_do_what_those_of_a_scene_do():
    expected = recorded(batch(1))
    plain = arm()
    for muscle in plain.character.muscles.values():
        muscle.excitation = None
    plain.motion = {"root": Motion([0.0], position=[ZERO])}
    rollout = batch(1, plain)
    assert rollout.muscle_names == ("flexor", "extensor")
    assert rollout.motion_names == ("root.y", "root.z", "root.turn", "shoulder")
    assert rollout.coordinate_names == rollout.speed_names == (*rollout.motion_names, "elbow")
    rollout.set_excitations([0.0, DURATION], [[[0.0, 0.6], [0.0, 0.2]]])
    rollout.set_motion(TIME, np.stack([np.zeros((3, 6))[0]] * 3 + [wave(0)])[None])
    for mine, theirs in zip(recorded(rollout), expected, strict=True):
        np.testing.assert_allclose(mine, theirs, atol=2e-6)
    assert np.ptp(expected[0][0, :, -1]) > 0.01


def given(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        "excitation": rng.uniform(0.0, 1.0, (count, 2, 6)),
        "motion": np.stack([moved(i) for i in range(count)]),
        "coordinates": rng.uniform(-0.5, 0.5, (count, 5)),
        "speeds": rng.uniform(-1.0, 1.0, (count, 5)),
        "activation": rng.uniform(0.0, 1.0, (count, 2)),
    }


def give(rollout: Rollout | MultiDeviceRollout, values: dict[str, np.ndarray]) -> None:
    rollout.set_excitations(TIME, values["excitation"])
    rollout.set_motion(TIME, values["motion"])
    rollout.set_initial(values["coordinates"], values["speeds"], values["activation"])


def test_instances_have_the_same_bits_alone_and_in_any_batch():
    values = given(7)
    together = batch(7, threads=2)
    give(together, values)
    whole = recorded(together)
    assert len({array.tobytes() for array in whole[0]}) == 7
    for i in (0, 3, 6):
        alone = batch(1)
        give(alone, {name: array[i : i + 1] for name, array in values.items()})
        assert_same(recorded(alone), [array[i : i + 1] for array in whole])
    split = MultiDeviceRollout(arm(), 7, ["cpu", "cpu"], record=[6, 0, 4], record_rate=RATE, quantities=QUANTITIES)
    give(split, values)
    assert_same(recorded(split), [array[[6, 0, 4]] for array in whole])


def test_several_instances_may_follow_one_motion():
    motions, of = np.stack([moved(0), moved(1)]), np.array([1, 0, 0, 1])
    shared, own = batch(4), batch(4)
    shared.set_motion(TIME, motions, of)
    own.set_motion(TIME, motions[of])
    assert_same(recorded(shared), recorded(own))


def test_starts_are_where_the_simulation_starts():
    values, rollout = given(3), batch(3)
    give(rollout, values)
    q, v, a = recorded(rollout)
    np.testing.assert_allclose(q[:, 0, 4], values["coordinates"][:, 4], rtol=1e-6)
    np.testing.assert_allclose(v[:, 0, 4], values["speeds"][:, 4], rtol=1e-6)
    np.testing.assert_allclose(q[:, 0, :4], values["motion"][:, :, 0], atol=1e-6)  # kinematic ones where it says
    assert np.abs(a[:, 0] - values["activation"]).max() < 0.15  # after the first step


def test_what_was_given_stays_with_other_parameters_and_after_a_reset():
    values = given(2)
    rollout = batch(2)
    give(rollout, values)
    first = recorded(rollout)
    rollout.set_parameters([])
    assert_same(recorded(rollout), first)


def test_a_batch_goes_on_from_a_snapshot_under_other_excitations():
    values = given(2)
    rollout = batch(2)
    give(rollout, values)
    rollout.run(0.05)
    held = rollout.snapshot()
    rollout.run()
    first = [rollout.recorded(name).copy() for name in QUANTITIES]
    rollout.set_excitations([0.0], np.ones((1, 2, 1)), restart=False)
    rollout.restore(held)
    assert rollout.time == pytest.approx(0.05)
    other = recorded(rollout)
    assert np.array_equal(other[0][:, :50], first[0][:, :50])
    assert np.abs(other[0][:, -1] - first[0][:, -1]).max() > 1e-3
    rollout.restore(held)
    rollout.set_excitations(TIME, values["excitation"], restart=False)
    assert_same(recorded(rollout), first)


def test_a_kernel_that_knows_no_excitations_over_time_gives_way_when_some_are_given():
    """As a GPU has it where no muscle of the scene has any."""
    plain, lean = batch(1), batch(1)
    usual = lean._launcher.config
    lean._launcher.config = usual.compiling(muscles=usual.kind.muscles._replace(timed=False))
    for rollout in (plain, lean):
        rollout.set_excitations([0.0, DURATION], [[[0.9, 0.1], [0.0, 0.8]]])
    assert_same(recorded(plain), recorded(lean))


def test_excitations_beyond_0_to_1_count_as_0_and_1():
    beyond, within = batch(1), batch(1)
    beyond.set_excitations([0.0], [[[1.5], [-0.2]]])
    within.set_excitations([0.0], [[[1.0], [0.0]]])
    assert_same(recorded(beyond), recorded(within))


def test_some_quantities_alone_are_those_of_a_whole_recording():
    some, whole = batch(2, record=[1]), Rollout(arm(), 2, "cpu", record=[1], record_rate=RATE)
    whole.run()
    q, v, a = recorded(some)
    motion = whole.recording()
    np.testing.assert_array_equal(q, whole.recorded("coordinates"))
    np.testing.assert_array_equal(v, whole.recorded("speeds"))
    np.testing.assert_array_equal(a[0], motion.muscle_activation.astype(np.float32))
    with pytest.raises(RolloutError, match="only some quantities were recorded"):
        some.recording()


def test_muscles_that_act_on_no_driven_joint_may_be_excited_too():
    scene = arm()
    scene.actuation["elbow"] = Actuation("kinematic")
    rollout = batch(1, scene)
    rollout.set_excitations(TIME, np.ones((1, 2, 6)))
    rollout.set_initial(activation=np.ones((1, 2)))
    assert recorded(rollout)[2].shape == (1, 100, 0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda r: r.set_excitations([0.0], np.zeros((3, 2, 1))),
            r"values \(1 or 2, 2, K\), not \(1,\) and \(3, 2, 1\)",
        ),
        (lambda r: r.set_excitations([0.0, 0.0], np.zeros((1, 2, 2))), "times of the excitations must increase"),
        (lambda r: r.set_excitations([0.0], np.full((1, 2, 1), np.nan)), "a number of the excitations is not finite"),
        (lambda r: r.set_excitations([], np.zeros((1, 2, 0))), "take times"),
        (lambda r: r.set_motion([0.0], np.zeros((1, 3, 1))), r"a motion of 4 coordinates takes times .* \(1, 3, 1\)"),
        (lambda r: r.set_motion([0.0, 0.05], np.zeros((1, 4, 2))), "reaches from 0 to 0.05 s, the simulation .* 0.1 s"),
        (lambda r: r.set_motion([0.0], np.full((1, 4, 1), np.inf)), "a number of the motion is not finite"),
        (
            lambda r: r.set_motion([0.0], np.zeros((1, 4, 1)), [0, 1]),
            "`of` takes the number of a motion, 0 to 0, for each",
        ),
        (lambda r: r.set_motion([0.0], np.zeros((1, 4, 1)), [0.5, 0.0]), "takes the number of a motion"),
        (lambda r: r.set_initial(np.zeros((1, 4))), r"initial coordinates have shape \(1, 4\); .* \(1 or 2, 5\)"),
        (lambda r: r.set_initial(speeds=np.full((2, 5), np.nan)), "a number of the initial speeds is not finite"),
        (lambda r: r.set_initial(activation=np.zeros(2)), r"initial activations have shape \(2,\)"),
        (lambda r: r.recorded("torque"), "'torque' was not recorded"),
    ],
)
def test_wrong_inputs_are_refused(call, message: str):
    with pytest.raises(RolloutError, match=message):
        call(batch(2))


def test_unknown_quantities_and_missing_recordings_are_refused():
    with pytest.raises(RolloutError, match="no quantity 'angle'; known: coordinates, speeds, muscle_path_length"):
        Rollout(arm(), quantities=["angle"])
    with pytest.raises(RolloutError, match="no instance was recorded"):
        batch(1, record=[]).recorded("speeds")
    still = arm(actuation={}, motion={})
    with pytest.raises(RolloutError, match="no kinematic coordinates"):
        batch(1, still).set_motion([0.0], np.zeros((1, 0, 1)))


def test_a_start_in_the_scene_is_that_of_joints_that_are_not_kinematic():
    start = InitialState(
        joints={"elbow": JointState((0.1, 0.0, 0.0, 0.99499)), "shoulder": JointState((0.3, 0.0, 0.0, 0.95394))}
    )
    q = recorded(batch(1, arm(initial_state=start)))[0][0, 0]
    np.testing.assert_allclose(q[-2:], [wave(0)[0], 2.0 * np.arcsin(0.1)], atol=1e-5)


def inputs_of(scene: Scene, count: int = 2) -> Inputs:
    inputs = Inputs(scene, structure_of(scene), count, wp.get_device("cpu"))
    inputs.use(scene)
    return inputs


def test_initial_values_are_the_same_object_until_something_changes():
    inputs, still = inputs_of(arm()), np.zeros((1, 2))
    first = inputs.initial_values(still)
    assert inputs.initial_values(still) is first
    assert inputs.initial_values(still + 1.0) is not first
    assert inputs.initial_values(still) is first
    pushes = none(2)
    for change in (
        lambda: inputs.set_motion([0.0], np.full((1, 4, 1), 0.5), None, DURATION),
        lambda: inputs.set_initial(None, np.ones((1, 5)), None),
        lambda: inputs.set_disturbances(pushes),
        lambda: inputs.use(arm()),
    ):
        change()
        assert inputs.initial_values(still) is not first
        first = inputs.initial_values(still)


def test_inputs_by_themselves_know_where_instances_start_and_what_the_model_has():
    inputs = inputs_of(arm(initial_state=InitialState(joints={"elbow": JointState((0.1, 0.0, 0.0, 0.99499))})))
    values = inputs.initial_values(np.zeros((1, 2)))
    elbow, shoulder = 2.0 * np.arcsin(0.1), wave(0)[0]
    np.testing.assert_allclose(values.coordinates, [[0.0, 0.0, 0.0, shoulder, elbow]] * 2, atol=1e-5)
    assert values.accelerations.shape == (2, 5)
    inputs.set_initial([[9.0, 9.0, 9.0, 9.0, 0.7]], None, [[0.1, 0.2], [0.3, 0.4]])
    inputs.set_motion([0.0], np.stack([np.full((4, 1), 0.25), np.full((4, 1), 0.5)]), [1, 0], DURATION)
    inputs.set_disturbances(replace(none(2), slope=np.array([0.0, 0.1])))
    values = inputs.initial_values(np.zeros((1, 2)))
    np.testing.assert_allclose(values.coordinates, [[0.5, 0.5, 0.5, 0.5, 0.7], [0.25, 0.25, 0.25, 0.25, 0.7]])
    np.testing.assert_allclose(values.activation, [[0.1, 0.2], [0.3, 0.4]], rtol=1e-6)
    assert (inputs.of_model.motion.row.tolist(), inputs.of_model.slope.tolist()) == ([1, 0], [0.0, 0.1])
    inputs.set_excitations([0.0, 1.0], [[[0.0, 2.0], [0.5, 0.25]]])
    assert inputs.of_model.excitations["knot_value"].numpy().tolist() == [[0.0, 1.0, 0.5, 0.25]]
    outside = inputs.from_outside([[0.5, 0.6]], [[1.0, 2.0]])
    assert set(outside) == {"muscles.timed", "muscles.knot_time", "muscles.knot_value", "actuation.effort"}
    assert outside["actuation.effort"].numpy().tolist() == [[1.0, 2.0]]


def test_noise_of_the_root_is_added_to_its_start():
    inputs = inputs_of(arm(motion={}, actuation={}))
    inputs.set_disturbances(replace(none(2), velocity=np.array([[9.0, 1.0, 2.0], [9.0, 3.0, 4.0]])))
    noise = np.array([[0.5, 0.25], [0.125, 0.0625]])
    np.testing.assert_allclose(inputs.initial_values(noise).speeds[:, :2], [[1.5, 2.25], [3.125, 4.0625]])
