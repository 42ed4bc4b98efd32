"""Batches that are driven from outside move as under a scene's own inputs; instances of a mask start again."""

import msgspec
import numpy as np
import pytest
import warp as wp

from muscle_arm import leg
from same_values import assert_same
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.status import Status
from warpmuscle.scene import Actuation, Scene
from warpmuscle.simulation.multi_device import MultiDeviceRollout
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

STEPS, EVERY = 200, 10  # in all, and between two changes of what is given
COUNT = 1000
ARRAYS = ("coordinates", "speeds", "accelerations")


def scene(**changes) -> Scene:
    return leg(duration=STEPS * 0.0005, **changes)


def excitations(count: int = COUNT) -> np.ndarray:
    """Random ones, (changes, instances, muscles)."""
    return np.random.default_rng(1).random((STEPS // EVERY, count, 3), dtype=np.float32)


def batch(count: int = COUNT, **options) -> Rollout:
    return Rollout(scene(), count, "cpu", threads=2, **options)


def state(rollout: Rollout) -> list[np.ndarray]:
    muscles = rollout.state.muscles
    return [getattr(rollout.state, name).numpy() for name in ARRAYS] + [muscles.activation.numpy()]


@pytest.fixture(scope="module")
def open_loop() -> list[np.ndarray]:
    """The end of the motion with the same excitations over time, as knots at every step."""
    rollout = batch()
    time = np.arange(STEPS, dtype=np.float32) * np.float32(0.0005)
    rollout.set_excitations(time, np.repeat(np.moveaxis(excitations(), 0, -1), EVERY, axis=-1))
    rollout.run()
    return state(rollout)


def as_torch(values: np.ndarray):
    torch = pytest.importorskip("torch", reason="no PyTorch: pip install torch")
    return torch.from_numpy(values).requires_grad_()


@pytest.mark.parametrize(
    "given",
    [
        np.asarray,
        lambda values: wp.array(values, dtype=float, device="cpu"),
        lambda values: values.astype(np.float64),
        as_torch,
    ],
    ids=["numpy", "warp", "float64", "torch"],
)
def test_a_loop_over_steps_gives_the_bits_of_the_same_excitations_in_open_loop(given, open_loop):
    rollout = batch()
    for values in excitations():
        rollout.step(EVERY, excitations=given(values))
    assert_same(state(rollout), open_loop)
    assert set(rollout.status()) == {Status.COMPLETED}


def test_a_policy_in_torch_reads_the_state_and_drives_the_batch_without_copies():
    torch = pytest.importorskip("torch", reason="no PyTorch: pip install torch")
    rollout = batch(8)
    speeds = wp.to_torch(rollout.observation()["speeds"])
    action = torch.zeros((8, 3))
    for _ in range(3):
        before = speeds.clone()
        torch.sigmoid(speeds[:, :3], out=action)
        rollout.step(EVERY, excitations=action)
        assert not torch.equal(speeds, before)
    np.testing.assert_array_equal(speeds.numpy(), rollout.state.speeds.numpy())


@pytest.mark.usefixtures("unoptimized_test")
def test_what_is_given_holds_for_its_steps_only():
    rollout, plain = batch(2), batch(2)
    rollout.step(EVERY, excitations=np.full((1, 3), 0.9), torques=np.full((1, 4), 5.0))
    rollout.reset()
    rollout.step(EVERY)
    plain.step(EVERY)
    assert_same(state(rollout), state(plain))


@pytest.mark.parametrize(("value", "same_as"), [(7.0, 1.0), (-3.0, 0.0), (-np.inf, 0.0)])
def test_excitations_beyond_their_interval_count_as_its_ends(value: float, same_as: float):
    motions = []
    for given in (value, same_as):
        rollout = batch(1)
        rollout.step(50, excitations=np.full((1, 3), given))
        motions.append(state(rollout))
    assert_same(*motions)
    assert all(np.isfinite(values).all() for values in motions[0])


@pytest.mark.usefixtures("unoptimized_test")
@pytest.mark.parametrize("kind", ["hinge", "universal"])
def test_torques_do_the_work_of_efforts_along_the_speeds(kind: str):
    """From rest M dv = effort h in the first step, without gravity, muscles and contact."""
    given = scene(gravity=0.0, actuation={"hip": Actuation("torque"), "knee": Actuation("torque")})
    given.character.muscles = {}
    given.character.root_joint = "free"
    given.ground.stiffness = 0.0
    if kind == "universal":
        knee = msgspec.structs.replace(given.character.joints["knee"], type="universal")
        knee.axes = [(1.0, 0.0, 0.0), (0.3, 0.2, 1.0)]
        given.character.joints["knee"] = knee
    rollout, stages = Rollout(given, 3, "cpu"), Stages(given, 3, "cpu")
    torques = np.random.default_rng(2).normal(0.0, 5.0, (3, len(rollout.torque_names)))
    assert rollout.torque_names[:3] == ("hip.x", "hip.y", "hip.z")
    for name in ("coordinates", "speeds"):
        getattr(stages.state, name).assign(getattr(rollout.state, name))
    matrix = stages.mass_matrix()
    rollout.step(1, torques=torques)
    effort = np.einsum("nij,nj->ni", matrix, rollout.state.speeds.numpy()) / given.time_step
    np.testing.assert_allclose(effort[:, 6:], torques, rtol=2e-4, atol=2e-4)
    np.testing.assert_allclose(effort[:, :6], 0.0, atol=2e-4)


@pytest.mark.usefixtures("unoptimized_test")
def test_a_torque_that_is_no_number_makes_its_instance_diverge_and_leaves_the_others_alone():
    rollout, plain = (
        Rollout(scene(actuation={"hip": Actuation("torque"), "knee": Actuation("torque")}), 3, "cpu") for _ in "ab"
    )
    torques = np.ones((3, 4), dtype=np.float32)
    plain.step(5, torques=torques)
    torques[1, 2] = np.nan
    rollout.step(5, torques=torques)
    assert rollout.status().tolist() == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    for one, other in zip(state(rollout), state(plain), strict=True):
        np.testing.assert_array_equal(one[[0, 2]], other[[0, 2]])
        assert np.isfinite(one).all()


@pytest.mark.parametrize("kind", ["numpy", "list", "warp", "torch"])
def test_instances_of_a_mask_start_again_and_the_others_go_on(kind: str):
    mask = np.array([False, True, False, True, False])
    given = {"numpy": mask, "list": mask.tolist(), "warp": wp.array(mask, dtype=wp.bool, device="cpu")}
    if kind == "torch":
        given["torch"] = pytest.importorskip("torch", reason="no PyTorch: pip install torch").from_numpy(mask)
    signal = excitations(5)
    rollout, plain = batch(5), batch(5)
    for values in signal[:7]:
        rollout.step(EVERY, excitations=values)
    rollout.reset(given[kind])
    assert rollout.end_time().tolist() == [0.035, 0.0, 0.035, 0.0, 0.035]
    for values in signal:
        rollout.step(EVERY, excitations=values)
        plain.step(EVERY, excitations=values)
    for one, other in zip(state(rollout), state(plain), strict=True):
        np.testing.assert_array_equal(one[mask], other[mask])
    assert set(rollout.status()) == {Status.COMPLETED}
    np.testing.assert_allclose(rollout.end_time(), STEPS * 0.0005)


def test_an_instance_that_started_later_ends_later_within_one_call():
    rollout = batch(3, record=[2])
    rollout.step(150)
    rollout.reset(mask=[False, False, True])
    rollout.step(100)
    assert rollout.status().tolist() == [Status.COMPLETED, Status.COMPLETED, Status.RUNNING]
    assert rollout.end_time().tolist() == [0.1, 0.1, 0.05]
    assert rollout.recording(2).time[-1] == pytest.approx(0.04)
    rollout.step(1000)
    assert rollout.status().tolist() == [Status.COMPLETED] * 3
    rollout.step(5)
    assert rollout.end_time().tolist() == [0.1] * 3


def test_a_mask_of_all_is_a_reset_and_noise_goes_with_a_mask():
    rollout, plain = batch(3), batch(3)
    rollout.step(20)
    rollout.reset(np.ones(3, dtype=bool))
    assert rollout.time == 0.0
    assert_same(state(rollout), state(plain))
    rollout.step(20)
    rollout.reset(np.zeros(3, dtype=bool))
    assert rollout.end_time().tolist() == [0.01] * 3


@pytest.mark.usefixtures("unoptimized_test")
def test_a_batch_over_several_devices_takes_steps_and_masks_alike():
    signal, mask = excitations(7), np.arange(7) % 3 == 0
    one, split = batch(7), MultiDeviceRollout(scene(), 7, ["cpu"] * 2)
    for rollout in (one, split):
        for values in signal[:4]:
            rollout.step(EVERY, excitations=values)
        rollout.reset(mask)
        rollout.step(EVERY, torques=np.ones((1, 4)))
    np.testing.assert_array_equal(one.end_time(), split.end_time())
    np.testing.assert_array_equal(one.state.speeds.numpy()[:3], split.rollouts[0].state.speeds.numpy())


def test_observations_are_the_state_itself():
    rollout = batch(4)
    found = rollout.observation()
    rollout.step(3)
    assert found["step"].numpy().tolist() == [3] * 4
    assert found["coordinates"].shape == (4, len(rollout.coordinate_names))
    assert all(np.from_dlpack(array).shape[0] == 4 for name, array in found.items() if name != "foot_force")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda r: r.step(0), "the number of steps k must be a positive whole number, not 0"),
        (lambda r: r.step(1, excitations=np.ones((2, 3))), r"excitations have shape \(2, 3\).*\(1 or 4, 3\)"),
        (lambda r: r.step(1, torques=[1.0, 2.0]), r"torques have shape \(2,\).*\(1 or 4, 4\)"),
        (lambda r: r.step(1, excitations=np.array([[0.1, np.nan, 0.2]])), "excitations hold NaN in row 0, column 1"),
        (lambda r: r.step(1, excitations="strong"), "excitations cannot be taken from a str"),
        (lambda r: r.step(1, torques=object()), "torques cannot be taken from a object"),
        (lambda r: r.reset([True]), r"a mask takes \(4,\) of bool, not \(1,\) of bool"),
        (lambda r: r.reset(mask=np.ones(4)), r"a mask takes \(4,\) of bool, not \(4,\) of float64"),
    ],
)
def test_what_cannot_be_taken_is_refused_in_one_line(call, message: str):
    rollout = batch(4)
    with pytest.raises(RolloutError, match=message) as caught:
        call(rollout)
    assert "\n" not in str(caught.value)
    assert rollout.steps_done == 0


def test_excitations_without_muscles_are_refused():
    given = scene(actuation={"hip": Actuation("torque"), "knee": Actuation("torque")})
    with pytest.raises(RolloutError, match="no muscles to excite"):
        Rollout(given, 1, "cpu").step(1, excitations=np.ones((1, 3)))
