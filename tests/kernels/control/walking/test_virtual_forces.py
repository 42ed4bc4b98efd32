"""Virtual forces against statics and the principle of virtual work, in float64."""

import numpy as np
from probes import evaluate, vectors

from warpmuscle.kernels.control.walking.virtual_forces import force_torque, gravity_torque, within_foot

G = 9.81


def test_a_torque_bears_the_weight_of_a_chain_of_bodies():
    mass = np.array([6.6, 3.2, 1.0])
    centre, joint = vectors(3, 1), vectors(1, 2)[0]
    moment = (mass[:, None] * centre).sum(axis=0)
    weight = np.zeros(3)
    for m, c in zip(mass, centre, strict=True):
        weight += np.cross(c - joint, [0.0, -m * G, 0.0])
    found = evaluate(gravity_torque, mass.sum(), moment, joint, G)[0]
    np.testing.assert_allclose(found, -weight, rtol=1e-5, atol=1e-4)


def test_torques_of_a_leg_do_the_work_of_the_virtual_force():
    """With the foot held, a turn of each joint moves the centre of mass: torques do the work that the force does."""
    place, joints, force = vectors(1, 3)[0], vectors(3, 4), vectors(1, 5, 100.0)[0]
    turns = vectors(3, 6, 1e-3)  # of what is inwards of each joint relative to what is outwards
    moved = sum(np.cross(turn, place - joint) for turn, joint in zip(turns, joints, strict=True))
    torques = evaluate(force_torque, force, place, joints)
    work = -np.sum(torques * turns)  # on what is inwards acts the opposite of what acts outwards
    np.testing.assert_allclose(work, force @ moved, rtol=1e-5)


def test_the_centre_of_pressure_stays_within_the_sole():
    load, heel, toe, half = 600.0, -0.05, 0.15, 0.03
    torque = vectors(40, 7, 60.0)
    found = evaluate(within_foot, torque, load, heel, toe, half)
    ahead, aside = found[:, 0] / load, -found[:, 2] / load
    assert ahead.min() >= heel - 1e-6
    assert ahead.max() <= toe + 1e-6
    assert np.abs(aside).max() <= half + 1e-6
    inside = (torque[:, 0] > load * heel) & (torque[:, 0] < load * toe)
    np.testing.assert_allclose(found[inside, 0], torque[inside, 0], rtol=1e-6)
    np.testing.assert_allclose(found[:, 1], torque[:, 1], rtol=1e-6)
