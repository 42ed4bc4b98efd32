"""What devices do over a stride: by closed form, and a motor on a walk beside its torques over recorded gait cycles."""

import numpy as np
import pytest
from msgspec.structs import replace

from small_result import march, with_arrays
from warpmuscle.formats import load
from warpmuscle.gait.device_work import device_powers, device_work
from warpmuscle.gait.foot_contact import touch_downs
from warpmuscle.gait.quality import gait_measures
from warpmuscle.gait.table import unit_of
from warpmuscle.scene import Force, Scene
from warpmuscle.scene.force import power_name
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout

KNOTS = [0.0, 0.0, -1.0, -2.0, -4.0, -6.0, -2.0, 1.0, 0.0, 0.0]  # N m, every tenth of the cycle


def motor(joint: str) -> Force:
    return Force("cycle_torque", joint=joint, parameters={f"torque_{k}": value for k, value in enumerate(KNOTS)})


def test_work_over_a_stride_is_that_of_the_mean_power():
    scene = load("fwalk")
    scene = substitute(scene, start_values(scene))
    scene.forces = {"motor": motor("lAnkle")}
    motion = march(scene.character, 1.0, duration=2.0, frames=201)
    power = 30.0 * np.sin(2.0 * np.pi * motion.time) + 5.0
    motion = replace_recorded(motion, power)
    found = device_work(motion, scene, cadence=120.0)  # strides of a second
    assert found["work of motor"] == pytest.approx(5.0 / body_mass(scene.character), abs=1e-2)
    positive = np.maximum(power, 0.0).mean() / body_mass(scene.character)
    assert found["positive work of motor"] == pytest.approx(positive)
    assert unit_of("work of motor") == unit_of("positive work of motor") == "J/kg a stride"


def replace_recorded(motion, power):
    return with_arrays(motion, recorded=power[:, None], recorded_names=(power_name("motor"),), recorded_units=("W",))


@pytest.fixture(scope="module")
def walk(unoptimized_kernels: None) -> tuple[Scene, object]:
    """A walk by torques with a motor on each ankle, one of which does nothing."""
    scene = load("fwalk", set={"duration": 5.0})
    idle = replace(motor("rAnkle"), parameters=dict.fromkeys(motor("rAnkle").parameters, 0.0))
    scene.forces = {"left": motor("lAnkle"), "right": idle}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    return rollout.numeric, rollout.recording()


def test_a_motor_follows_the_cycles_of_its_own_foot(walk: tuple[Scene, object]):
    scene, motion = walk
    power = device_powers(motion, scene.forces)
    assert np.all(power["right"] == 0.0)
    landings = touch_downs(motion, "left")
    assert len(landings) >= 4
    speed = motion.speed[:, next(k for k, name in enumerate(motion.speed_names) if name.startswith("lAnkle"))]
    for before, begin, end in zip(landings[:-2], landings[1:-1], landings[2:], strict=True):
        inside = (motion.time >= begin + 0.05) & (motion.time < end - 0.05)
        part = np.minimum((motion.time[inside] - begin) / (begin - before), 1.0)
        torque = np.interp(part, np.linspace(0.0, 1.0, 11), [*KNOTS, KNOTS[0]])
        assert power["left"][inside] == pytest.approx(torque * speed[inside], abs=0.1)
    found = gait_measures(motion, scene)
    assert found["positive work of left"] > 0.01
    assert found["work of right"] == 0.0
