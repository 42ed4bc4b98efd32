"""Lengths, lengthening speeds and moment arms of muscle paths: by differences and by virtual power."""

import numpy as np
from probes import matrix

from leg_paths import PATHS, character, differences, geometry_of, gradient, somewhere
from random_states import random_states
from warpmuscle.scene import Actuation, Character, Muscle, Scene
from warpmuscle.simulation.stages import Stages


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
