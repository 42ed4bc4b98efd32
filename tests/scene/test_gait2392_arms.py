"""The arms of gait2392_arms are those that Rajagopal 2016 takes from the trunk of gait2392."""

import numpy as np

from warpmuscle import load

# Rajagopal2016.osim: mass, kg, centre from the elbow, m, and moments of inertia, kg m^2, in its axes (forwards, up,
# right); places of radius and hand are those of their joints in the arm's neutral position.
HAND = (-0.006727 - 0.008797, -0.013007 - 0.235841 - 0.068095, 0.026083 + 0.01361)
FOREARM = (
    (0.6075, (0.0, -0.120525, 0.0), (0.002962, 0.000618, 0.003213)),  # ulna
    (0.6075, (-0.006727, -0.013007 - 0.120525, 0.026083), (0.002962, 0.000618, 0.003213)),  # radius
    (0.4575, HAND, (0.000892, 0.000547, 0.00134)),
)  # fmt: skip
HUMERUS = 2.0325, 0.164502, 0.286273  # kg, m to its centre, m to the elbow


def test_trunk_and_arms_weigh_what_the_trunk_weighed():
    bodies, before = load("gait2392_arms").character.bodies, load("gait2392").character.bodies
    arms = [bodies[f"{part}_{side}"].mass for part in ("upper_arm", "forearm") for side in "lr"]
    np.testing.assert_allclose(bodies["torso"].mass + sum(arms), before["torso"].mass, rtol=1e-12)
    assert bodies["upper_arm_r"].mass == HUMERUS[0]


def test_forearms_are_ulna_radius_and_hand_together():
    character = load("gait2392_arms").character
    mass = np.array([part[0] for part in FOREARM])
    centre = np.array([part[1] for part in FOREARM])
    mean = mass @ centre / mass.sum()
    inertia = sum(
        np.array(own) + m * (np.sum((place - mean) ** 2) - (place - mean) ** 2)
        for (m, _, own), place in zip(FOREARM, centre, strict=True)
    )
    for side in "lr":
        forearm, elbow = character.bodies[f"forearm_{side}"], character.joints[f"elbow_{side}"]
        np.testing.assert_allclose(forearm.mass, mass.sum(), rtol=1e-12)
        np.testing.assert_allclose(elbow.position_in_child[1], -mean[1], atol=1e-4)
        np.testing.assert_allclose(forearm.inertia, inertia[[2, 1, 0]], atol=6e-5)  # our axes: left, up, forwards


def test_both_arms_are_mirror_images():
    joints = load("gait2392_arms").character.joints
    for name in ("shoulder", "elbow"):
        left, right = joints[f"{name}_l"], joints[f"{name}_r"]
        for place in ("position_in_parent", "position_in_child"):
            assert np.array_equal(np.array(getattr(left, place)) * [-1, 1, 1], getattr(right, place))
    elbow = joints["elbow_r"].position_in_parent[1] - HUMERUS[1]
    np.testing.assert_allclose(-elbow, HUMERUS[2], atol=1e-4)
