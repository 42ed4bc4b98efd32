"""The energy balance of recorded motions: powers add up to zero, and each is that of another way to it."""

import msgspec
import numpy as np
import pytest

from small_result import walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gait.muscle_effort import fibre_powers
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.energy_balance import energy_balance
from warpmuscle.studies.inverse_dynamics import joint_space

SETTLED = 20  # steps after which nothing of the first one is left


def every_step(scene: Scene, duration: float) -> tuple[Recording, Scene]:
    short = msgspec.structs.replace(scene, duration=duration)
    rollout = Rollout(short, 1, "cpu", record=[0], record_rate=1.0 / float(short.time_step))
    rollout.run()
    return rollout.recording().at(slice(SETTLED, None)), at_start(short)


@pytest.fixture(scope="module")
def walk() -> tuple[Recording, Scene]:
    """Every step of a short walk by torques."""
    return every_step(load("fwalk"), 0.4)


@pytest.fixture(scope="module")
def muscular() -> tuple[Recording, Scene]:
    """The same on 56 muscles."""
    return every_step(msgspec.structs.replace(walk_scene(), objective=Objective()), 0.3)


def test_powers_of_a_walk_add_up_to_nothing(walk: tuple[Recording, Scene]):
    found = energy_balance(*walk)
    assert found.left is not None
    assert abs(found.left) < 0.01 * found.turnover
    parts = (found.gravity, found.inertia, found.muscles, found.torques, found.stops, found.devices, found.ground)
    assert sum(parts) == pytest.approx(found.left)
    assert found.muscles == 0.0
    assert found.fibres is None
    assert found.sliding is not None
    assert found.ground < found.sliding + 5.0  # friction takes, and so does what is pressed in
    assert found.turnover > 50.0


def test_powers_of_a_walk_on_muscles_add_up_to_nothing(muscular: tuple[Recording, Scene]):
    found = energy_balance(*muscular)
    assert found.left is not None
    assert abs(found.left) < 0.01 * found.turnover
    assert found.fibres is not None
    assert sum(found.fibres) == pytest.approx(found.muscles)
    assert found.fibres.damping < 0.0
    assert found.fibres.lengthening < 0.0 < found.fibres.shortening


def test_damping_of_fibres_takes_what_its_law_says(muscular: tuple[Recording, Scene]):
    """A force of f_max times the damping at the largest speed, in proportion to the speed (Millard 2013)."""
    motion, scene = muscular
    found = fibre_powers(motion, scene)
    assert found is not None
    muscles = [scene.character.muscles[name] for name in motion.muscle_names]
    f_max, l_opt = (np.array([float(getattr(one, name)) for one in muscles]) for name in ("f_max", "l_opt"))
    model = scene.muscle_model
    rate = motion.muscle_fibre_velocity.astype(float) / l_opt
    taken = float(model.damping) / float(model.v_max) * f_max * l_opt * rate**2
    tense = motion.muscle_force > 0.02 * f_max  # a slack muscle does not push, whatever its damping
    assert found.damping[tense].sum() == pytest.approx(-taken[tense].sum(), rel=0.02)
    assert tense.mean() > 0.2


def test_inertia_and_gravity_are_those_of_the_mass_matrix(walk: tuple[Recording, Scene]):
    """Kinetic energy 1/2 v M v, and the weight times how far its centre sinks."""
    motion, scene = walk
    ends = np.array([0, motion.frames - 1])
    matrix = joint_space(scene, motion.coordinate[ends]).mass_matrix
    speeds = motion.speed[ends].astype(float)
    energy = 0.5 * np.einsum("ni,nij,nj->n", speeds, matrix, speeds)
    time = float(motion.time[-1] - motion.time[0])
    found = energy_balance(motion, scene)
    assert found.inertia == pytest.approx((energy[0] - energy[1]) / time, rel=0.03)
    sunk = float(motion.com[0, 1] - motion.com[-1, 1])
    assert found.gravity == pytest.approx(body_mass(scene.character) * float(scene.gravity) * sunk / time, rel=1e-6)


def test_the_ground_is_what_is_left_where_steps_are_missing(walk: tuple[Recording, Scene]):
    motion, scene = walk
    whole, rough = energy_balance(motion, scene), energy_balance(motion.at(slice(None, None, 10)), scene)
    assert (rough.left, rough.sliding) == (None, None)
    others = rough.gravity + rough.inertia + rough.muscles + rough.torques + rough.stops + rough.devices
    assert rough.ground == pytest.approx(-others)
    assert rough.ground == pytest.approx(whole.ground, abs=0.1 * whole.turnover)


def test_a_motion_that_has_too_little_is_refused(walk: tuple[Recording, Scene]):
    motion, scene = walk
    with pytest.raises(Error, match="3 frames or more, not 2"):
        energy_balance(motion.at(slice(0, 2)), scene)
    with pytest.raises(Error, match="of another character than the scene"):
        energy_balance(motion, load("arm18"))
