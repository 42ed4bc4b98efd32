"""Objects that turn about an axis against closed forms: pendulum, seesaw, energy and momentum of an impact on it."""

import numpy as np
import pytest

from objects_alone import PLAIN, STEP, played, together
from warpmuscle.core.status import Status
from warpmuscle.scene import BallObject, BoxObject, Hinge
from warpmuscle.scene.objects.motion import object_motion
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

G = 9.8
PLANK, SIZE = 6.0, (0.3, 0.04, 2.0)
INERTIA = PLANK / 12.0 * (SIZE[1] ** 2 + SIZE[2] ** 2)  # about x through its middle


def plank(**more):
    return BoxObject(mass=PLANK, size=SIZE, position=(0.0, 0.5, 0.0), hinge=Hinge(), **more)


def angle(motion) -> np.ndarray:
    """About x, rad."""
    return np.unwrap(2.0 * np.arctan2(motion.orientation[:, 0], motion.orientation[:, 3]).astype(float))


def test_a_hung_box_swings_with_the_period_of_a_pendulum_and_keeps_its_energy():
    size, mass, hung, start = (0.1, 0.6, 0.2), 2.0, 0.25, 0.1
    solid = BoxObject(
        mass=mass, size=size, position=(0.0, 1.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0),
        hinge=Hinge(axis=(2.0, 0.0, 0.0), position=(0.0, hung, 0.0)), angular_velocity=(start, 0.0, 0.0),
    )  # fmt: skip
    recording, motion = played(together({"one": solid}, duration=10.0, gravity=G), 1000.0)
    one, t = motion["one"], recording.time.astype(float)
    inertia = mass / 12.0 * (0.6**2 + 0.2**2) + mass * hung**2
    omega = np.sqrt(mass * G * hung / inertia)
    np.testing.assert_allclose(angle(one), start / omega * np.sin(omega * t), atol=1e-4)
    pivot = one.position + np.array(
        [[0.0, hung * np.cos(a), hung * np.sin(a)] for a in angle(one)]
    )  # where the axis is now
    np.testing.assert_allclose(pivot, np.tile([0.0, 1.0 + hung, 0.0], (len(pivot), 1)), atol=2e-6)


def test_a_hung_box_that_turns_over_keeps_its_energy():
    mass, hung = 2.0, 0.3
    solid = BoxObject(
        mass=mass, size=(0.1, 0.6, 0.2), position=(0.0, 2.0, 0.0), hinge=Hinge(position=(0.0, hung, 0.0)),
        angular_velocity=(12.0, 0.0, 0.0),
    )  # fmt: skip
    _, motion = played(together({"one": solid}, duration=4.0, gravity=G), 1000.0)
    one = motion["one"]
    inertia = mass / 12.0 * (0.6**2 + 0.2**2) + mass * hung**2
    energy = 0.5 * inertia * one.angular_velocity[:, 0].astype(float) ** 2 + mass * G * one.position[:, 1]
    assert abs(angle(one)[-1]) > 4.0 * np.pi
    np.testing.assert_allclose(energy, energy[0], rtol=5e-3)


def test_a_damped_axle_slows_down_exponentially():
    solid = plank(angular_velocity=(1.0, 0.0, 0.0))
    solid.hinge.damping = 3.0
    recording, motion = played(together({"one": solid}, duration=1.0), 1000.0)
    rate, t = motion["one"].angular_velocity[1:, 0], recording.time[1:] - 0.5 * STEP  # in the middle of the step before
    np.testing.assert_allclose(rate, np.exp(-3.0 / INERTIA * t), rtol=2e-3)


@pytest.mark.parametrize("restitution", [0.2, 0.7])
def test_an_impact_on_a_seesaw_keeps_angular_momentum_and_loses_the_energy_that_its_restitution_says(
    restitution: float,
):
    """J = (1 + e) v/(1/m + a^2/I) at a lever a; the energy lost is (1 - e^2)/2 v^2/(1/m + a^2/I)."""
    mass, lever, speed = 1.5, 0.8, 3.0
    objects = {
        "plank": plank(restitution=1.0, friction=0.0),
        "ball": BallObject(
            mass=mass, position=(0.0, 0.7, lever), velocity=(0.0, -speed, 0.0), restitution=restitution, friction=0.0,
            touches=["plank"],
        ),
    }  # fmt: skip
    _, motion = played(together(objects, duration=0.1), 2000.0)
    reduced = 1.0 / (1.0 / mass + lever**2 / INERTIA)
    impulse = (1.0 + restitution) * speed * reduced
    rate, velocity = float(motion["plank"].angular_velocity[-1, 0]), motion["ball"].velocity[-1].astype(float)
    assert velocity[1] == pytest.approx(-speed + impulse / mass, abs=0.03)
    assert rate == pytest.approx(impulse * lever / INERTIA, rel=0.01)
    place = motion["ball"].position[-1] - np.array([0.0, 0.5, 0.0])
    turning = INERTIA * rate + mass * np.cross(place, velocity)[0]
    assert turning == pytest.approx(mass * lever * speed, rel=1e-3)
    energy = 0.5 * INERTIA * rate**2 + 0.5 * mass * velocity @ velocity
    lost = 0.5 * mass * speed**2 - energy
    assert lost == pytest.approx(0.5 * (1.0 - restitution**2) * speed**2 * reduced, rel=0.02)


def test_a_seesaw_with_a_load_at_each_end_begins_to_fall_as_both_say():
    lever, masses = 0.8, (2.0, 1.0)
    turned = {
        f"load{k}": BoxObject(
            mass=mass, size=(0.1, 0.1, 0.1), position=(0.0, 0.57 - mass * G / 8e4, side * lever), restitution=0.0,
            friction=1.0, touches=["plank"],
        )
        for k, (mass, side) in enumerate(zip(masses, (1.0, -1.0), strict=True))
    }  # fmt: skip
    _, motion = played(
        together({"plank": plank(restitution=0.0, friction=1.0), **turned}, duration=0.3, gravity=G), 1000.0
    )
    inertia = INERTIA + sum(m * (lever**2 + (0.05 + 0.02) ** 2 + 0.1**2 / 6.0) for m in masses)
    expected = (masses[0] - masses[1]) * G * lever / inertia
    rate = motion["plank"].angular_velocity[:, 0]
    slope = np.polyfit(np.arange(100, 200) / 1000.0, rate[100:200], 1)[0]
    assert slope == pytest.approx(expected, rel=0.02)


def test_a_seesaw_that_is_heavier_on_one_side_comes_to_lie_on_the_ground():
    off = 0.2
    solid = plank(restitution=0.0)
    solid.hinge.position = (0.0, 0.0, -off)
    recording, motion = played(together({"plank": solid}, PLAIN, 3.0, G), 50.0)
    last = angle(motion["plank"])[-1]
    assert 0.5 - (1.0 + off) * np.sin(last) - 0.02 * np.cos(last) == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(motion["plank"].angular_velocity[-1], 0.0, atol=1e-3)
    assert recording.time[-1] == pytest.approx(3.0, abs=0.05)


def test_an_object_beyond_all_bounds_ends_its_instance():
    solid = BoxObject(mass=8.0, size=(4e11, 0.04, 2.0), position=(0.0, 0.4, 0.0), hinge=Hinge(damping=0.5))
    rollout = Rollout(together({"one": solid}, ground=PLAIN, duration=0.05, gravity=G), 1, "cpu", record=[0])
    rollout.run()
    assert rollout.status()[0] == Status.DIVERGED
    motion = object_motion(rollout.recording(0), "one")
    assert all(np.isfinite(values).all() for values in motion)
