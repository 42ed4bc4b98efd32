"""Ground that moves along itself: blocks on belts against closed forms, and a walk seen from a belt."""

import msgspec
import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.formats import load
from warpmuscle.gait.measures import measure
from warpmuscle.kernels.contact import belts
from warpmuscle.results.recording import Recording
from warpmuscle.scene import BallObject, Body, Box, Character, Failure, Ground, InitialState, Scene, Sphere, Treadmill
from warpmuscle.scene.number import Free
from warpmuscle.scene.objects.motion import object_motion
from warpmuscle.scene.treadmill.belt_motion import BELTS, mean_shift, share
from warpmuscle.simulation.rollout import Rollout

G = 9.8
BOX, BALL = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)), Sphere((0.0, 0.0, 0.0), 0.1)


def block(treadmill: Treadmill | None, x: float = 0.5, duration: float = 1.0, shape=BOX, **ground) -> Scene:
    body = Body(5.0, (0.02, 0.02, 0.02), [shape], friction=0.5)
    ground = Ground(**({"stiffness": 1e5, "damping": 1e3, "treadmill": treadmill} | ground))
    return Scene(
        "block", Character("block", {"block": body}), initial_state=InitialState((x, 0.0999, 0.0)), ground=ground,
        failure=Failure(com_height=0.0, heading=0.0), duration=duration, time_step=0.0005,
    )  # fmt: skip


def recorded(scene: Scene, rate: float = 200.0) -> Recording:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=rate)
    rollout.run()
    return rollout.recording(0)


@wp.kernel(enable_backward=False)
def ask(times: wp.array[float], knots: wp.array[wp.vec2], values: wp.array[float]):
    i = wp.tid()
    values[i] = belts.profile_at(times[i], knots)


@pytest.mark.parametrize("knots", [[(0.0, 1.0)], [(0.5, 1.0), (0.7, -0.5), (1.0, 0.0)]])
def test_a_profile_is_straight_between_its_knots(knots: list[tuple[float, float]]):
    times = np.linspace(-1.0, 2.0, 200, dtype=np.float32)
    values = wp.zeros(200, dtype=float, device="cpu")
    given = wp.array(times, dtype=float, device="cpu"), wp.array(np.float32(knots), dtype=wp.vec2, device="cpu")
    wp.launch(ask, 200, [*given, values], device="cpu")
    np.testing.assert_allclose(values.numpy(), np.interp(times, *np.transpose(knots)), atol=1e-6)


def test_velocity_lies_in_the_plane_with_its_whole_length():
    normal = np.array([0.2, 0.9, -0.3]) / np.linalg.norm([0.2, 0.9, -0.3])
    v = evaluate(belts.along_ground, np.array([0.3]), np.array([1.2]), normal)[0]
    assert v @ normal == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(v) == pytest.approx(np.hypot(0.3, 1.2), rel=1e-6)
    assert v[2] < 0.0 < v[0]


@pytest.mark.parametrize(("x", "speed"), [(0.5, 2.0), (-0.5, 0.8)], ids=["left", "right"])
def test_a_block_on_a_belt_slides_until_it_has_its_speed(x: float, speed: float):
    recording = recorded(block(Treadmill(speed=0.8, left=1.2), x))
    t, z = recording.time.astype(float), recording.root_position[:, 2].astype(float)
    a = 0.5 * G
    taken = speed / a
    expected = np.where(t < taken, -0.5 * a * t**2, -0.5 * a * taken**2 - speed * (t - taken))
    np.testing.assert_allclose(z, expected, atol=6e-3)
    assert (z[-1] - z[-21]) / (t[-1] - t[-21]) == pytest.approx(-speed, rel=1e-3)


def test_a_platform_that_shifts_carries_what_stands_on_it_along():
    treadmill = Treadmill(speed=0.3, sideways=-0.1, profile=[(0.1, 0.0), (0.3, 1.0), (0.6, 1.0), (0.8, 0.0)], start=0.1)
    scene = block(treadmill)
    recording = recorded(scene)
    shift = mean_shift(scene.ground, recording.time)
    moved = recording.root_position - recording.root_position[0]
    np.testing.assert_allclose(moved[:, [0, 2]], shift[:, [0, 2]], atol=1.5e-3)
    assert shift[-1, 2] == pytest.approx(-0.15)


def test_recordings_have_the_speeds_of_both_belts():
    treadmill = Treadmill(speed=0.8, left=0.4, right=-0.2, profile=[(0.1, 0.0), (0.6, 1.0)])
    recording = recorded(block(treadmill, 5.0))
    assert recording.recorded_names == BELTS
    assert recording.recorded_units == ("m/s", "m/s")
    middle = recording.time + 0.5 * 0.0005  # of steps
    np.testing.assert_allclose(recording.recorded, share(treadmill, middle)[:, None] * [1.2, 0.6], atol=1e-6)


def test_hunt_crossley_contacts_are_carried_along_too():
    recording = recorded(block(Treadmill(speed=1.0), shape=BALL, law="hunt_crossley"))
    spin = recording.root_angular_velocity[-1, 0] * 0.1
    assert recording.root_velocity[-1, 2] == pytest.approx(-1.0 * 2.0 / (2.0 + 5.0 * 0.4), rel=2.0)  # it rolls
    assert recording.root_velocity[-1, 2] - spin == pytest.approx(-1.0, abs=0.05)


def test_a_ball_on_a_belt_comes_to_roll_at_two_sevenths_of_its_speed():
    scene = block(Treadmill(speed=1.4))
    scene.objects = {"one": BallObject(position=(0.0, 0.0999, 3.0), friction=0.4)}
    motion = object_motion(recorded(scene), "one")
    assert motion.velocity[-1, 2] == pytest.approx(-1.4 * 2.0 / 7.0, rel=5e-3)


def test_instances_have_belts_of_their_own():
    scene = block(Treadmill(speed=Free(0.5, 0.0, 2.0)))
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2], record_rate=100.0)
    rollout.set_parameters(np.array([[0.0], [0.5], [1.0]]))
    rollout.run()
    ends = [rollout.recording(k).root_velocity[-1, 2] for k in range(3)]
    np.testing.assert_allclose(ends, [0.0, -0.5, -1.0], atol=1e-3)


def test_walking_on_a_belt_is_walking_on_the_ground_seen_from_a_moving_frame():
    ground = load("fwalk")
    ground.duration = 1.0
    belt = msgspec.structs.replace(
        ground, ground=msgspec.structs.replace(ground.ground, treadmill=Treadmill(speed=0.6))
    )
    rollouts = [Rollout(scene, 1, "cpu", record=[0], record_rate=200.0) for scene in (ground, belt)]
    speeds = rollouts[0].state.speeds.numpy()[0].astype(float)
    speeds[2] -= 0.6
    rollouts[1].set_initial(speeds=speeds[None])
    for rollout in rollouts:
        rollout.run()
    still, moving = (rollout.recording(0) for rollout in rollouts)
    shift = np.array([0.0, 0.0, 0.6]) * still.time[:, None]
    np.testing.assert_allclose(moving.com + shift, still.com, atol=1e-4)
    np.testing.assert_allclose(moving.com_velocity, still.com_velocity, atol=1e-2)
    assert measure(moving, belt).speed_forward == pytest.approx(measure(still, ground).speed_forward, abs=1e-4)
