"""Recordings of known floors: soles, heights and belts come back, and feet are told."""

import numpy as np
import pytest

import small_leg
import small_squat
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyLoads, BodyModel, Dynamics
from warpmuscle.inverse.simulated_ground.floor_fit import Recorded, fit_floor, fit_floors, recorded
from warpmuscle.inverse.simulated_ground.foot_contact import HERTZ, RADIUS, feet_of, has_contact, scene_on_ground
from warpmuscle.scene.geometry import contact_points

TIMES = np.arange(101) / 100.0
SOLE = np.array([0.012, 0.008, 0.01, 0.011, 0.009, 0.01])
ALONG = np.array([-0.06, -0.06, 0.12, 0.12, 0.18, 0.18])


def walk(belt: float, height: float = 0.0, drift: float = 0.0) -> Recorded:
    """Feet that stand by turns on a belt and press as spheres do, while the recorded floor rises."""
    place = np.zeros((len(TIMES), 2, 6, 3))
    for side in (0, 1):
        swing = np.maximum(np.sin(2.0 * np.pi * (TIMES + 0.5 * side)), 0.0)
        rock = 0.02 * np.sin(2.0 * np.pi * (2.0 * TIMES + 0.5 * side))
        place[:, side, :, 2] = ALONG + belt * np.mod(TIMES + 0.5 * side, 1.0)[:, None]
        place[:, side, :, 1] = 0.2 * swing[:, None] + rock[:, None] * (ALONG - 0.06)
    force = np.zeros((len(TIMES), 2, 3))
    pressed = HERTZ * np.maximum(SOLE - place[..., 1], 0.0) ** 1.5
    force[..., 1] = pressed.sum(axis=2)
    moment = np.einsum("nfp,nfp->nf", pressed, place[..., 2])[..., None]
    place[..., 1] += (height + drift * TIMES)[:, None, None]
    return Recorded(TIMES, place, force, moment, (2,))


@pytest.mark.parametrize("belt", [0.0, -1.2])
def test_soles_heights_and_belts_come_back(belt):
    floor = fit_floor(walk(belt, 0.04, 0.01))
    assert floor.belt == pytest.approx([0.0, 0.0, belt], abs=0.02)
    assert floor.firmness == pytest.approx(1.0, rel=0.2)
    lift = np.interp(TIMES, floor.times, floor.lift)
    lowest = lift[:, None] - floor.sole + (0.04 + 0.01 * TIMES)[:, None]  # what a sphere's place lies above the ground
    assert lowest == pytest.approx(np.tile(-SOLE, (len(TIMES), 1)), abs=0.003)


def test_trials_of_one_subject_have_the_same_soles():
    first, second = fit_floors([walk(0.0, 0.0), walk(0.0, 0.03)])
    assert first.sole.tolist() == second.sole.tolist()
    assert first.firmness == second.firmness
    assert second.lift - first.lift == pytest.approx(-0.03, abs=1e-3)


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_squat.small_squat(tmp_path_factory.mktemp("squat")), "cpu")


def test_spheres_lie_as_far_below_the_points_of_the_feet_as_soles_are_thick(body):
    feet = feet_of(body)
    assert not has_contact(body, feet)
    scene = scene_on_ground(body, feet, SOLE, 2.0)
    assert scene.ground.material.stiffness == 2.0e6
    for foot in feet:
        shapes = scene.character.bodies[body.topology.bodies[foot.body]].shapes
        below = [np.array(place) - [0.0, radius, 0.0] for shape in shapes for place, radius in contact_points(shape)]
        assert np.array(below) == pytest.approx(foot.points - SOLE[:, None] * [0.0, 1.0, 0.0], abs=1e-9)
        assert all(shape.radius == RADIUS for shape in shapes)
        inner, outer = foot.points[::2, 0], foot.points[1::2, 0]
        assert (np.sign(outer - inner) == (1.0 if foot is feet[0] else -1.0)).all()  # x is to the left


def test_a_model_with_shapes_on_its_feet_keeps_them(body):
    feet = feet_of(body)
    own = BodyModel(scene_on_ground(body, feet, SOLE), "cpu")
    assert has_contact(own, feet_of(own))
    again = scene_on_ground(own, feet_of(own), None)
    assert again.ground == own.scene.ground
    assert again.character.bodies == own.scene.character.bodies


def test_feet_and_forces_below_them_are_needed(body, tmp_path):
    with pytest.raises(ArgumentError, match="needs two feet"):
        feet_of(BodyModel(small_leg.small_leg(tmp_path), "cpu"))
    bodies, nothing = len(body.topology.bodies), np.zeros((2, 1, 3))
    still = Dynamics(
        np.zeros((2, 9)), np.zeros((2, 9)), *(np.zeros((2, bodies, 3)) for _ in range(3)),
        np.tile([0.0, 0.0, 0.0, 1.0], (2, bodies, 1)),
    )  # fmt: skip
    with pytest.raises(ArgumentError, match="give loads, or find them"):
        recorded(body, feet_of(body), TIMES[:2], still, BodyLoads([0], nothing, nothing, nothing))
