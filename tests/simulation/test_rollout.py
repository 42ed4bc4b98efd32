"""A batch of simulations: independence of everything around an instance, failures, costs, recordings, parameters."""

import copy
import dataclasses

import numpy as np
import pytest

from short_walks import CANDIDATE, assert_same_bits, candidates, limp, plain_walk, short_walk
from warpmuscle.core.arrays import named_arrays
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_numbers, start_values, substitute
from warpmuscle.simulation.rollout import Rollout


def simulated(count: int = 1, slot: int = 0, durations: tuple[float, ...] = (0.5,), **options) -> Rollout:
    rollout = Rollout(short_walk(), count, "cpu", record=[slot], record_rate=200, **options)
    rollout.set_parameters(candidates(count, slot))
    for duration in durations:
        rollout.run(duration)
    return rollout


@pytest.fixture(scope="module")
def alone() -> Rollout:
    return simulated(threads=1)


@pytest.mark.parametrize(
    "around",
    [
        {},
        {"count": 3},
        {"count": 500, "slot": 499},
        {"count": 5, "slot": 2, "threads": 1},
        {"count": 5, "slot": 2, "threads": 2},
        {"count": 5, "slot": 2, "threads": 4},
        {"durations": (0.1,) * 5},
        {"count": 3, "slot": 1, "durations": (0.0005, 0.2345, 0.265)},
    ],
    ids=str,
)
def test_a_candidate_gives_the_same_bits_whatever_is_around_it(around: dict, alone: Rollout):
    rollout, slot = simulated(**around), around.get("slot", 0)
    assert rollout.cost()[slot] == alone.cost()[0]
    assert rollout.status()[slot] == Status.COMPLETED
    assert_same_bits(rollout.recording(slot), alone.recording())


def test_simulating_again_after_a_reset_gives_the_same_bits(alone: Rollout):
    rollout = simulated()
    rollout.reset()
    assert (rollout.time, rollout.cost()[0], rollout.recording().frames) == (0.0, 0.0, 0)
    rollout.run()
    assert_same_bits(rollout.recording(), alone.recording())


def test_an_instance_that_diverges_has_a_finite_cost_and_disturbs_nobody(alone: Rollout):
    rollout = Rollout(short_walk(), 3, "cpu", record=[1])
    rollout.set_parameters([[3e8, 3e8], CANDIDATE, [3e8, 290.0]])
    rollout.run()
    assert rollout.status().tolist() == [Status.DIVERGED, Status.COMPLETED, Status.DIVERGED]
    assert np.isfinite(rollout.cost()).all()
    assert rollout.cost()[1] == alone.cost()[0]
    assert rollout.end_time()[0] < rollout.end_time()[1] == pytest.approx(0.5)


def test_a_diverged_instance_leaves_no_value_that_is_not_finite():
    rollout = Rollout(short_walk(), 1, "cpu", record=[0], record_rate=2000)
    rollout.set_parameters([3e8, 3e8])
    rollout.run()
    recording = rollout.recording()
    for field in dataclasses.fields(Recording):
        value = getattr(recording, field.name)
        assert not isinstance(value, np.ndarray) or np.isfinite(value).all(), field.name


def test_an_instance_that_falls_stops_and_costs_between_once_and_twice_the_worst():
    scene = limp()
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    worst, end = scene.objective.failure_cost, rollout.end_time()[0]
    assert rollout.status()[0] == Status.FELL
    assert rollout.alive == 0
    assert rollout.cost()[0] == pytest.approx(worst * (2.0 - end / 2.0), rel=1e-6)
    height = rollout.recording().com[:, 1]
    assert len(height) == round(end * 2000)
    assert height[-1] >= 0.9 * height[0] > height[-1] - 0.01


def test_whoever_falls_later_costs_less():
    rollout = Rollout(limp(), 20, "cpu")
    rollout.reset(velocity_noise=0.5, seed=3)
    rollout.run()
    order = np.argsort(rollout.end_time())
    assert len(set(rollout.end_time())) > 5
    assert np.all(np.diff(rollout.cost()[order]) <= 0.0)


def test_an_instance_that_turns_away_has_failed():
    scene = short_walk(1.0)
    scene.initial_state.root_angular_velocity = (0.0, 8.0, 0.0)
    scene.controller.heading_control, scene.failure.heading = False, 0.3
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] == Status.TURNED
    assert 0.3 / 8.0 <= rollout.end_time()[0] < 0.2


@pytest.mark.parametrize("start", [-3.0, 0.9, 1.6])
@pytest.mark.parametrize("controlled", [False, True])
def test_the_limit_of_the_heading_counts_from_where_the_walk_starts(start: float, controlled: bool):
    """A controller of the heading turns the body to its own; without it, the walk goes on where it looks."""
    scene = short_walk(0.3)
    scene.initial_state.heading, scene.controller.heading_control, scene.failure.heading = start, controlled, 0.4
    scene.controller.desired_heading = 4.0 * np.pi + start - 0.8
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] == Status.COMPLETED


def test_ground_contact_of_another_body_is_a_failure_if_asked_for():
    outcomes = []
    for fails in (True, False):
        scene = limp(1.5)
        scene.failure.com_height, scene.failure.heading, scene.failure.body_contact = 0.0, 0.0, fails
        rollout = Rollout(scene, 1, "cpu")
        rollout.run()
        outcomes.append(rollout.status()[0])
    assert outcomes == [Status.TOUCHED, Status.COMPLETED]


def test_cost_is_the_weighted_integral_of_the_torques():
    scene = short_walk()
    scene.objective.torque = 2.5
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    torque = rollout.recording().joint_torque
    assert len(torque) == 1000
    expected = 2.5 * np.linalg.norm(torque, axis=2).sum() * 0.0005
    assert rollout.cost()[0] == pytest.approx(expected, rel=1e-5)


def test_recording_takes_every_so_many_steps(alone: Rollout):
    fine = Rollout(short_walk(), 1, "cpu", record=[0], record_rate=2000)
    fine.set_parameters(CANDIDATE)
    fine.run()
    dense, coarse = fine.recording(), alone.recording()
    np.testing.assert_allclose(coarse.time, np.arange(100) / 200.0)
    assert np.array_equal(coarse.root_position, dense.root_position[::10])
    assert np.array_equal(coarse.joint_torque, dense.joint_torque[::10])


def test_recording_starts_with_the_state_of_the_scene(alone: Rollout):
    recording, start = alone.recording(), alone.scene.initial_state
    np.testing.assert_allclose(recording.root_position[0], start.root_position, atol=1e-6)
    speed = np.linalg.norm(start.root_velocity)  # turned to the heading, if one is given
    assert np.linalg.norm(recording.root_velocity[0]) == pytest.approx(speed, rel=1e-5)
    for i, name in enumerate(recording.joint_names):
        given = np.array(start.joints[name].orientation)
        assert abs(recording.joint_orientation[0, i] @ given) == pytest.approx(1.0, abs=1e-5)


def test_velocities_of_a_recording_are_the_changes_of_its_positions():
    rollout = Rollout(short_walk(), 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    r = rollout.recording()
    for position, velocity in ((r.root_position, r.root_velocity), (r.com, r.com_velocity)):
        error = np.abs(np.diff(position, axis=0) / 0.0005 - 0.5 * (velocity[1:] + velocity[:-1]))
        assert np.median(error) < 1e-3  # what is left of single precision after the division by the step
        assert error.max() < 0.05  # impacts


def test_forces_on_the_feet_move_the_centre_of_mass():
    rollout = Rollout(short_walk(), 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    r = rollout.recording()
    force = (r.foot_force_left + r.foot_force_right)[1:]  # of the step that ended at that time
    acceleration = force / 70.4 - [0.0, 9.8, 0.0]
    change = np.diff(r.com_velocity, axis=0)[1:] / 0.0005
    extrapolated = 1.5 * acceleration[1:] - 0.5 * acceleration[:-1]  # velocities are those at the end of a step
    np.testing.assert_allclose(change, extrapolated, atol=0.3)


@pytest.mark.parametrize(("quick", "expected"), [(0.0, [0.1, 0.2, 0.3, 0.4, 0.5]), (1e9, [0.1, 0.3, 0.4, 0.5])])
def test_progress_is_reported_and_an_interrupted_batch_can_be_continued(
    alone: Rollout, quick: float, expected: list[float], monkeypatch: pytest.MonkeyPatch
):
    """Chunks become longer where they are quick, and begin anew."""
    monkeypatch.setattr("warpmuscle.simulation.rollout.QUICK", quick)
    rollout, times = simulated(durations=()), []

    def stop(batch: Rollout) -> None:
        times.append(batch.time)
        if len(times) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rollout.run(progress=stop)
    assert rollout.status()[0] == Status.RUNNING
    assert np.isfinite(rollout.cost()).all()
    rollout.run(progress=stop)
    np.testing.assert_allclose(times, expected)
    assert_same_bits(rollout.recording(), alone.recording())


@pytest.mark.parametrize(("room", "expected"), [(0, [0.1, 0.2, 0.4, 0.5]), (2, [0.1, 0.3, 0.5])])
def test_chunks_grow_where_nobody_waits_for_the_room_of_those_that_failed(
    room: int, expected: list[float], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("warpmuscle.simulation.rollout.QUICK", 1e9)
    rollout, times = Rollout(short_walk(), 2, "cpu"), []
    rollout._room = room  # of a GPU

    def tell(batch: Rollout) -> None:
        times.append(batch.time)

    whole = rollout.advance

    def advance(step: int, kernel: None = None) -> None:
        if rollout.steps_done == 0:
            rollout.state.status.assign(np.array([Status.RUNNING, Status.FELL], dtype=np.int32))
        whole(step, kernel)

    monkeypatch.setattr(rollout, "advance", advance)
    rollout.run(progress=tell)
    np.testing.assert_allclose(times, expected)


def test_batch_never_runs_beyond_the_duration(alone: Rollout):
    rollout = simulated(durations=(9.0, 9.0))
    assert rollout.time == pytest.approx(0.5)
    assert rollout.cost()[0] == alone.cost()[0]


# Noise and parameters.


def test_noise_differs_by_instance_and_follows_the_seed():
    rollout, start = Rollout(short_walk(), 400, "cpu"), short_walk().initial_state.root_velocity
    noise = []
    for seed in (1, 1, 2):
        rollout.reset(velocity_noise=0.1, seed=seed)
        noise.append(rollout.state.speeds.numpy()[:, :3] - np.array(start))
    assert np.array_equal(noise[0], noise[1])
    assert not np.array_equal(noise[0], noise[2])
    assert len(np.unique(noise[0])) == 1200
    np.testing.assert_allclose(noise[0].std(axis=0), 0.1, rtol=0.15)
    assert np.ptp(rollout.state.speeds.numpy()[:, 3:], axis=0).max() == 0.0


def set_number(scene: Scene, path: str, value: object) -> None:
    """Set the number at a path that goes through fields, tables and lists."""
    *parents, last = path.split(".")
    part = scene
    for name in parents:
        inner = part[int(name)] if isinstance(part, list) else None
        part = inner if inner is not None else part[name] if isinstance(part, dict) else getattr(part, name)
    if isinstance(part, list):
        part[int(last)] = value
    else:
        setattr(part, last, value)


FREE_NUMBERS = {
    "character.bodies.torso.mass": 25.0,
    "character.bodies.rFoot.friction": 0.4,
    "controller.pd.lKnee.kd": 25.0,
    "controller.states.0.time": 0.65,
    "controller.states.0.trajectories.SWING_Hip.components.0.angle.0": 0.05,
    "controller.stance_hip_damping": 15.0,
    "ground.stiffness": 2e5,
    "ground.friction": 0.5,
    "gravity": 9.0,
    "objective.torque": 3.0,
}


@pytest.mark.parametrize("path", FREE_NUMBERS)
def test_a_free_number_does_what_the_number_in_the_scene_does(path: str):
    value, fixed, varied = FREE_NUMBERS[path], plain_walk(), plain_walk()
    set_number(fixed, path, value)
    set_number(varied, path, Free(value, 0.5 * value, 2.0 * value))
    expected = Rollout(fixed, 1, "cpu", record=[0])
    batch = Rollout(varied, 3, "cpu", record=[1])
    batch.set_parameters([[0.9 * value], [value], [1.1 * value]])
    for rollout in (expected, batch):
        rollout.run()
    assert [p.name for p in batch.parameters] == [path]
    assert batch.cost()[1] == expected.cost()[0]
    assert_same_bits(batch.recording(), expected.recording())
    assert len(set(batch.cost())) > 1


def test_body_shape_and_joint_place_may_be_free():
    scene = plain_walk()
    joint, foot = scene.character.joints["lAnkle"], scene.character.bodies["lFoot"]
    joint.position_in_parent = tuple(Free(v, v - 0.1, v + 0.1) for v in joint.position_in_parent)
    foot.shapes[0].low = tuple(Free(v, v - 0.1, v) for v in foot.shapes[0].low)
    rollouts = [Rollout(scene, 2, "cpu", record=[1]), Rollout(plain_walk(), 1, "cpu", record=[0])]
    rollouts[0].set_parameters([start_values(scene)] * 2)
    for rollout in rollouts:
        rollout.run()
    assert_same_bits(*(rollout.recording() for rollout in rollouts))


@pytest.mark.parametrize("name", ["fwalk", "stumble56", "run56_search", "wang2012_search", "gait2392_walk", "legs28"])
def test_parameters_of_the_controller_alone_leave_the_same_model_as_making_all_of_it_again(name: str):
    scene = load(name)
    quick, whole = (Rollout(scene, 3, "cpu") for _ in range(2))
    assert all(path.startswith("controller.") for path, _, _ in free_numbers(scene))
    values = start_values(scene) * np.array([[1.0], [1.01], [0.99]])
    quick.set_parameters(values)
    whole.change(substitute(scene, values))
    names = [name for name, _ in named_arrays(whole.model)]
    assert len(names) > 50
    for name, (_, one), (_, other) in zip(names, named_arrays(quick.model), named_arrays(whole.model), strict=True):
        assert one.numpy().tobytes() == other.numpy().tobytes(), name


def test_parameters_may_be_given_once_for_all():
    rollout = Rollout(short_walk(), 3, "cpu")
    rollout.set_parameters(CANDIDATE)
    rollout.run()
    assert len(set(rollout.cost())) == 1


# Errors.


@pytest.mark.parametrize("instance", [0, 7, None])
def test_what_was_not_recorded_cannot_be_read(instance: int | None):
    record = [] if instance is None else [1]
    with pytest.raises(RolloutError, match="was not recorded" if record else "nothing was recorded"):
        Rollout(short_walk(), 3, "cpu", record=record).recording(instance)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"device": "abacus"}, "no device 'abacus' here; known: .*cpu"),
        ({"instances": 0}, "instances must be a positive"),
        ({"instances": 2.5}, "instances must be a positive"),
        ({"record": [3]}, "cannot record instance 3 of 2"),
        ({"record": [-1]}, "cannot record instance -1"),
        ({"threads": 0}, "threads must be a positive"),
        ({"threads": -1}, "threads must be a positive"),
    ],
)
def test_impossible_batches_are_refused(options: dict, message: str):
    with pytest.raises(RolloutError, match=message):
        Rollout(short_walk(), **({"instances": 2, "device": "cpu"} | options))


def test_scene_is_left_as_it_was():
    scene = short_walk()
    before = copy.deepcopy(scene)
    Rollout(scene, 2, "cpu").run()
    assert scene == before


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_impossible_duration_is_an_error(duration: float):
    with pytest.raises(RolloutError, match="duration"):
        Rollout(short_walk(), 1, "cpu").run(duration)
