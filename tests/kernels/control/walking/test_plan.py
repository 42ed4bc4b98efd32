"""The plan of a walk over time: steps last as long as their formula says, by gravity and the length of a leg."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.formats import load
from warpmuscle.kernels.body_structs import Feet
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.kernels.control.walking.plan import aim
from warpmuscle.kernels.structs import Model, Scratch, Skeleton
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout

STEP_TIME, QUICKENING = 1.83, 0.845  # of the scene


@pytest.mark.parametrize("speed", [0.0, 0.9])
def test_a_phase_goes_on_by_the_time_of_a_step(speed: float):
    """step_time sqrt(L/g) / (1 + quickening V/sqrt(g L)), V the speed that is followed; of who stands, none."""
    scene = load("steer")
    scene.controller.parameters |= {"step_time": STEP_TIME, "quickening": QUICKENING}
    rollout = Rollout(scene, 1, "cpu")
    rollout.set_commands({"speed": speed})
    rollout.run(0.6)
    memories = []
    for _ in range(2):
        memories.append(rollout._extensions.struct.first.memory.numpy()[0, 0].astype(float))
        rollout.run(scene.time_step)
    before, after = memories
    followed, leg = after[int(places.SPEED)], after[int(places.LEG)]
    duration = STEP_TIME * np.sqrt(leg / scene.gravity) / (1.0 + QUICKENING * followed / np.sqrt(scene.gravity * leg))
    gained = after[int(places.PHASE)] - before[int(places.PHASE)]
    if speed == 0.0:
        assert after[int(places.PHASE)] == followed == 0.0
        return
    assert 0.02 < followed < speed
    assert after[int(places.HASTE)] == 1.0
    assert gained == pytest.approx(scene.time_step / duration, rel=1e-3)


def test_who_stands_steps_out_where_no_sole_bears_it():
    """Pushed forwards and backwards; who is pushed to the side by 0.2 m/s keeps standing."""
    pushes = np.array([[0.0, 0.0, 0.4], [0.0, 0.0, -0.3], [0.0, 0.0, -0.6], [0.2, 0.0, 0.0]])
    rollout = Rollout(load("steer"), len(pushes), "cpu")
    rollout.set_commands({"speed": 0.0})
    rollout.disturb(replace(none(len(pushes)), velocity=pushes))
    stepped = np.zeros(len(pushes), dtype=bool)
    for _ in range(8):
        rollout.run(0.25)
        memory = rollout._extensions.struct.first.memory.numpy()[:, 0]
        stepped |= memory[:, int(places.STANCE)] != float(places.STANDS)
    assert stepped.tolist() == [True, True, True, False]
    assert set(rollout.status_names()) == {"running"}


@wp.kernel(enable_backward=False)
def aims(p: places.Walking, model: Model, work: Scratch, memory: wp.array[float], found: wp.array[wp.vec3]):
    its = work
    one = aim(0, p, model, its, memory)
    found[0] = one.place
    found[1] = wp.vec3(one.moves, one.remaining, 0.0)


@pytest.mark.parametrize(("stance", "heading"), [(0.0, 0.0), (1.0, 0.0), (1.0, 0.7), (0.0, -2.0)])
def test_a_foot_comes_down_where_the_pendulum_rests_but_for_width_and_speed(stance: float, heading: float):
    """Hof 2008: over the foot that stands the body falls by x'' = g/h x until the other one comes down."""
    gravity, leg, sole, width, speed, tuned, phase = 9.8, 0.9, 0.08, 0.2, 0.7, 0.1, 0.5
    retreat, step_time, use, heel, toe, least = 0.9, 1.6, 0.5, -0.06, 0.16, 0.05
    standing, out = (0, -1.0) if stance == 0.0 else (1, 1.0)  # of the left, then the right leg swings
    ankles = np.array([[0.1, 0.08, 0.02], [-0.1, 0.08, -0.03]])
    turn = np.array([[np.cos(heading), 0, np.sin(heading)], [0, 1, 0], [-np.sin(heading), 0, np.cos(heading)]])
    ahead = 0.5 * use * (heel + toe)
    pivot = ankles[standing] + [0.0, -sole, ahead]  # feet look along z
    off, velocity = np.array([out * 0.05, 0.88, 0.03]), np.array([out * 0.1, 0.02, 0.6])
    memory = np.zeros(places.STATE, np.float32)
    for place, value in (
        (places.STANCE, stance), (places.HEADING, heading), (places.PHASE, phase), (places.SPEED, speed),
        (places.LEG, leg), (places.SOLE, sole), (places.HEEL, heel), (places.TOE, toe), (places.TUNED, tuned),
    ):  # fmt: skip
        memory[int(place)] = value
    p = places.Walking()
    given = {"step_time": step_time, "step_width": width, "least_width": least, "retreat": retreat, "sole_use": use}
    for name, value in given.items():
        setattr(p, name, value)
    model = filled(Model, gravity=np.float32([[gravity]]))
    model.skeleton = filled(Skeleton, plan={"parent": np.zeros(2, np.int32)})
    model.feet = filled(Feet, left=0, right=1)
    work = filled(
        Scratch, position=np.float32(ankles), rotation=np.tile(np.eye(3, dtype=np.float32), (2, 1, 1)),
        center=np.float32([pivot + turn @ off, turn @ velocity]),
    )  # fmt: skip
    found = wp.zeros(2, dtype=wp.vec3, device="cpu")
    wp.launch(aims, 1, [p, model, work, wp.array(memory, device="cpu")], [found], device="cpu")
    rate, duration = np.sqrt(gravity / off[1]), step_time * np.sqrt(leg / gravity)
    remaining = (0.88 - phase) * duration
    cosh, sinh = np.cosh(rate * remaining), np.sinh(rate * remaining)
    fallen = off * cosh + velocity / rate * sinh
    fast = off * rate * sinh + velocity * cosh
    rests = fast * np.sqrt(off[1] / gravity + fast**2 / (4.0 * gravity**2))
    margin = width * leg / (np.exp(rate * duration) + 1.0)
    back = retreat * (speed + tuned) * duration / (np.exp(rate * duration) - 1.0)
    x, z = fallen[0] + rests[0] + out * margin, fallen[2] + rests[2] - back
    assert least * leg < out * x < 0.55 * leg
    np.testing.assert_allclose(found.numpy()[0], pivot + turn @ [x, sole, z - ahead], atol=2e-5)
    np.testing.assert_allclose(found.numpy()[1, :2], [fast[2] + rate * fallen[2], remaining], rtol=1e-4)
