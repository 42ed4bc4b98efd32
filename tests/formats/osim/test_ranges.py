"""Ranges of coordinates push with no force, as in OpenSim; that is told, and a stiffness may be given."""

import math
from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

TWO = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q")) + small.joint(
    "SliderJoint", "slider", "rod", "tip", small.coordinate("s")
)
HELD = (
    '<CoordinateLimitForce name="stop"><coordinate>q</coordinate><upper_stiffness>2</upper_stiffness>'
    "<upper_limit>90</upper_limit><lower_stiffness>3</lower_stiffness><lower_limit>-45</lower_limit>"
    "<damping>0.1</damping><transition>5</transition></CoordinateLimitForce>"
)


def two(folder: Path, forces: str = "", **options: float) -> tuple[Scene, list[str]]:
    """A pin and a slider on it, and the notes on ranges."""
    ignored: list[Ignored] = []
    text = small.model(small.body("rod", center="0 -0.5 0") + small.body("tip"), TWO, forces)
    scene = load(small.written(folder, text), ignored=ignored, **options)
    return scene, [one.reason for one in ignored if "leaves" in one.reason]


def test_ranges_that_push_with_no_force_are_told_once(tmp_path: Path):
    scene, (told,) = two(tmp_path)
    assert {joint.limit_stiffness for joint in scene.character.joints.values() if joint.limits} == {0.0}
    assert "the ranges of 2 coordinates (q, s) push with no force" in told
    assert "--limit-stiffness" in told


def test_a_stiffness_is_that_of_all_ranges_but_those_that_a_force_of_the_model_holds(tmp_path: Path):
    scene, told = two(tmp_path, limit_stiffness=500.0)
    assert not told
    for name in ("q", "s"):
        joint = scene.character.joints[name]
        assert (joint.limits, joint.limit_stiffness, joint.limit_damping) == ([(-2.0, 2.0)], 500.0, 2.5)
    scene, told = two(tmp_path, HELD, limit_stiffness=500.0)
    assert not told
    assert scene.forces["stop"].type == "coordinate_limit"
    assert scene.character.joints["q"].limit_stiffness == 0.0
    assert scene.character.joints["s"].limit_stiffness == 500.0
    assert "the range of s pushes with no force" in two(tmp_path, HELD)[1][0]


@pytest.mark.parametrize("stiffness", [-1.0, float("nan"), "stiff"])
def test_a_stiffness_is_a_number_and_not_negative(tmp_path: Path, stiffness: float):
    with pytest.raises(ArgumentError, match="limit_stiffness must be a finite number, 0 or greater"):
        two(tmp_path, limit_stiffness=stiffness)


def thrown(folder: Path, **options: float) -> Floats:
    """Angles, rad, of a rod that starts downwards at 5 rad/s, over 1 s, at 1000 a second."""
    start = small.coordinate("q", "<default_speed_value>5</default_speed_value>")
    text = small.model(small.body("rod", center="0 -0.5 0"), small.joint("PinJoint", "pin", "ground", "rod", start))
    scene = load(small.written(folder, text), ignored=[], **options)
    scene.duration, scene.time_step = 1.0, 1e-4
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0)
    rollout.run()
    return rollout.recording().joint_angle[:, 0]


def thrown_in_numpy(stiffness: float) -> Floats:
    """The same in float64 with steps of 10 us: the stop pushes by k x + 5 ms k x' beyond 2 rad, and never pulls."""
    inertia, weight, q, speed, found = 2.0 + 0.25, 9.80665 * 0.5, 0.0, 5.0, []
    for step in range(100_000):
        if step % 100 == 0:
            found.append(q)
        stop = max(stiffness * (q - 2.0 + 0.005 * speed), 0.0) if q > 2.0 else 0.0
        speed += 1e-5 * (-weight * math.sin(q) - stop) / inertia
        q += 1e-5 * speed
    return np.array(found)


@pytest.mark.parametrize("stiffness", [0.0, 500.0, 20_000.0])
def test_a_free_run_leaves_its_range_but_for_a_stiffness_that_throws_it_back(tmp_path: Path, stiffness: float):
    """A stop gives way by no more than the square root of twice the energy that comes at it over its stiffness."""
    angles = thrown(tmp_path, limit_stiffness=stiffness)
    expected = thrown_in_numpy(stiffness)
    np.testing.assert_allclose(angles, expected, atol=0.02)
    if stiffness == 0.0:
        assert angles[-1] > 3.5
        return
    energy = 0.5 * 2.25 * 25.0 - 0.5 * 9.80665 * (1.0 - math.cos(2.0))
    assert 2.0 < angles.max() < 2.0 + math.sqrt(2.0 * energy / stiffness)
    assert angles[-1] < 2.0


def test_a_force_of_the_model_pushes_a_thrown_rod_back_as_in_opensim(tmp_path: Path):
    osim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    start = small.coordinate("q", "<default_speed_value>5</default_speed_value>")
    pin = small.joint("PinJoint", "pin", "ground", "rod", start)
    path = small.written(tmp_path, small.model(small.body("rod", center="0 -0.5 0"), pin, HELD))
    scene = load(path, ignored=[])
    scene.duration, scene.time_step = 1.0, 1e-4
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0)
    rollout.run()
    ours = rollout.recording().joint_angle[:, 0]
    model = osim.Model(str(path))
    state = model.initSystem()
    manager = osim.Manager(model)
    manager.setIntegratorAccuracy(1e-9)
    manager.initialize(state)
    coordinate, theirs = model.getCoordinateSet().get(0), []
    for frame in range(len(ours)):
        if frame:
            state = manager.integrate(0.001 * frame)
        theirs.append(coordinate.getValue(state))
    assert max(theirs) > math.radians(90.0)  # it comes to the stop
    np.testing.assert_allclose(ours, theirs, atol=2e-4)
