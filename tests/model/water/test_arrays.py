"""Numbers of capsules in water against closed forms: a ball is dragged alike along every axis, a rod is not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from biped import biped
from warpmuscle.kernels.water.section import SECTIONS
from warpmuscle.model.water.arrays import put_water
from warpmuscle.scene import Body, Character, Scene, Water
from warpmuscle.scene.topology import topology

BALL, ROD = "lUpperleg", "lLowerleg"
DRAG, AXIAL, MASS, DENSITY = 0.9, 0.3, 5.0, 1050.0  # 1, 1, kg, kg/m^3
LENGTH, RADIUS = 0.5, 0.055  # m, of the rod as a cylinder


def test_a_ball_is_dragged_along_every_axis_alike_and_a_rod_less_along_its_length():
    character = biped()
    ball = (3.0 * MASS / DENSITY / (4.0 * np.pi)) ** (1.0 / 3.0)
    around, along = MASS * (3.0 * RADIUS**2 + LENGTH**2) / 12.0, 0.5 * MASS * RADIUS**2
    character.bodies[BALL].mass = character.bodies[ROD].mass = MASS
    character.bodies[BALL].inertia = (0.4 * MASS * ball**2,) * 3
    character.bodies[ROD].inertia = (around, along, around)
    scene = Scene("pool", character, water=Water(drag=DRAG, axial_drag=AXIAL, body_density=DENSITY))
    names, made = topology(character), SimpleNamespace()
    put_water(made, scene, names, "cpu")
    rows = made.row.numpy()[0]
    of_ball, of_rod = (rows[names.bodies.index(name)] for name in (BALL, ROD))
    assert of_ball["radius"] == of_ball["reach"] == pytest.approx(ball, rel=1e-5)
    assert of_ball["along"] == of_ball["across"] == pytest.approx(DRAG * np.pi * ball**2, rel=1e-5)
    assert of_ball["added_along"] == pytest.approx(of_ball["added_across"], rel=1e-3)
    end = np.pi * of_rod["radius"] ** 2
    assert of_rod["along"] == pytest.approx(AXIAL * end, rel=1e-5)
    broadside = end + 4.0 * of_rod["radius"] * (of_rod["reach"] - of_rod["radius"])
    assert of_rod["across"] == pytest.approx(DRAG * broadside, rel=1e-5)
    assert of_rod["across"] > 5.0 * of_rod["along"]


def test_a_body_alone_in_the_water_is_one_capsule():
    ball, mass = 0.1, 4.0 / 3.0 * np.pi * 0.1**3 * DENSITY
    body = Body(mass, (0.4 * mass * ball**2,) * 3)
    scene = Scene("pool", Character("one", {"one": body}), water=Water(body_density=DENSITY))
    made = SimpleNamespace()
    put_water(made, scene, topology(scene.character), "cpu")
    assert made.row.numpy()["radius"].ravel() == pytest.approx([ball], rel=1e-5)


def test_sections_of_a_ball_share_its_volume_by_their_squared_radii():
    """Slice k of n has the squared radius r^2 (1 - x^2) at x = (2 k + 1)/n - 1; the sum of all shares is 1."""
    ball, character = 0.1, biped()
    character.bodies[BALL].mass = 4.0 / 3.0 * np.pi * ball**3 * DENSITY
    character.bodies[BALL].inertia = (0.4 * character.bodies[BALL].mass * ball**2,) * 3
    scene = Scene("pool", character, water=Water(body_density=DENSITY))
    names, made = topology(character), SimpleNamespace()
    put_water(made, scene, names, "cpu")
    row = made.row.numpy()[0][names.bodies.index(BALL)]
    places = (2.0 * np.arange(SECTIONS) + 1.0) / SECTIONS - 1.0
    assert row["volume"] == pytest.approx(4.0 / 3.0 * np.pi * ball**3, rel=1e-5)
    assert row["share"] * np.sum(ball**2 * (1.0 - places**2)) == pytest.approx(1.0, rel=1e-5)
