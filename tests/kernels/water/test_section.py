"""Bodies in water against closed forms: Archimedes, terminal velocity, added mass, and the energy of an ideal fluid."""

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.core.pose import rotate
from warpmuscle.kernels.water import section
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Body, Capsule, Character, Failure, Ground, InitialState, Scene, Shape, Sphere, Water
from warpmuscle.scene.number import Free
from warpmuscle.scene.water.capsules import added_mass
from warpmuscle.simulation.rollout import Rollout

G, RHO, R = 9.8, 1000.0, 0.1
BALL, BALL_VOLUME = Sphere((0.0, 0.0, 0.0), R), 4.0 / 3.0 * np.pi * R**3
ROD = Capsule((0.0, -0.4, 0.0), (0.0, 0.4, 0.0), R)
ROD_VOLUME = np.pi * R**2 * 0.8 + BALL_VOLUME
FLAT = tuple(np.array([np.sin(np.pi / 4), 0.0, 0.0, np.cos(np.pi / 4)]))  # y of the body along z


def afloat(
    shape: Shape, mass, water: Water, y: float = 0.0, duration: float = 2.0, inertia=(0.05, 0.05, 0.05), **start
) -> Scene:
    body = Body(mass, inertia, [shape])
    water.volume = "shapes"
    return Scene(
        "afloat", Character("buoy", {"buoy": body}), initial_state=InitialState((0.0, y, 0.0), **start),
        ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0), duration=duration, water=water,
        time_step=0.001,
    )  # fmt: skip


def recorded(scene: Scene) -> Recording:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0)
    rollout.run()
    return rollout.recording(0)


def test_the_part_of_a_disc_below_the_surface_is_that_of_a_circular_segment():
    height = np.linspace(-1.5, 1.5, 301)
    x = np.linspace(-1.0, 1.0, 20001)
    below = [np.trapezoid(2.0 * np.sqrt(1.0 - x**2) * (x < -h), x) / np.pi for h in height]
    np.testing.assert_allclose(evaluate(section.part_below, height, 1.0), below, atol=2e-4)


def test_a_ball_sinks_at_its_terminal_velocity():
    mass, drag = 6.0, 0.47
    recording = recorded(afloat(BALL, mass, Water(level=100.0, drag=drag, axial_drag=drag), duration=3.0))
    expected = np.sqrt(2.0 * (mass - RHO * BALL_VOLUME) * G / (RHO * drag * np.pi * R**2))
    np.testing.assert_allclose(recording.root_velocity[-1], [0.0, -expected, 0.0], atol=1e-3 * expected)


def test_a_ball_starts_to_sink_with_half_of_the_displaced_water():
    mass = 6.0
    recording = recorded(afloat(BALL, mass, Water(level=100.0, drag=0.0, axial_drag=0.0), duration=0.1))
    displaced = RHO * BALL_VOLUME
    expected = -(mass - displaced) * G / (mass + 0.5 * displaced)
    assert recording.root_velocity[-1, 1] / recording.time[-1] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(("turn", "index"), [(FLAT, 1), ((0.0, 0.0, 0.0, 1.0), 0)], ids=["across", "along"])
def test_a_rod_takes_as_much_water_along_as_a_spheroid(turn: tuple[float, ...], index: int):
    mass = 40.0
    water = Water(level=100.0, drag=0.0, axial_drag=0.0)
    recording = recorded(afloat(ROD, mass, water, duration=0.1, root_orientation=turn))
    displaced = RHO * ROD_VOLUME
    added = float(added_mass(np.array([0.5]), np.array([R]))[index][0])
    expected = -(mass - displaced) * G / (mass + added * displaced)
    assert recording.root_velocity[-1, 1] / recording.time[-1] == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("share", [0.25, 0.5, 0.8])
def test_a_rod_floats_as_deep_as_archimedes_says(share: float):
    mass = share * RHO * ROD_VOLUME
    water = Water(drag=5.0, axial_drag=5.0)
    recording = recorded(afloat(ROD, mass, water, 0.02, 20.0, root_orientation=FLAT))
    angle = np.linspace(0.0, np.pi, 4001)
    depths = -np.cos(angle) * R  # of the surface over the rod's middle, with the volume below it
    segment = R**2 * (angle - np.sin(angle) * np.cos(angle))
    cap = np.pi * (R + depths) ** 2 * (2.0 * R - depths) / 3.0
    expected = -np.interp(mass / RHO, segment * 0.8 + cap, depths)
    assert np.mean(recording.root_position[-5000:, 1]) == pytest.approx(expected, abs=0.02 * R)


def test_a_ball_under_water_by_half_is_carried_by_half_of_its_volume():
    mass = 0.5 * RHO * BALL_VOLUME
    recording = recorded(afloat(BALL, mass, Water(), 0.0, 0.5))
    np.testing.assert_allclose(recording.root_position[:, 1], 0.0, atol=1e-5)


def test_two_balls_of_one_body_are_carried_by_the_water_that_both_displace():
    small = Sphere((0.3, 0.0, 0.0), 0.5 * R)
    scene = afloat(BALL, RHO * BALL_VOLUME * 1.125, Water(level=100.0), 0.0, 0.5, inertia=(1e4, 1e4, 1e4))
    scene.character.bodies["buoy"].shapes.append(small)
    recording = recorded(scene)
    np.testing.assert_allclose(recording.root_position[:, 1], 0.0, atol=1e-4)


def test_a_rod_upright_floats_with_the_length_that_its_weight_displaces():
    mass = 0.6 * RHO * ROD_VOLUME
    water = Water(drag=5.0, axial_drag=50.0)
    recording = recorded(afloat(ROD, mass, water, 0.0, 20.0, inertia=(1e4, 1e4, 1e4)))
    under = mass / RHO / (np.pi * R**2) + R / 3.0  # of its length, the round end's missing third added
    assert recording.root_position[-1, 1] == pytest.approx(0.5 - under, abs=0.015)


def test_an_ideal_fluid_keeps_the_energy_of_a_rod_that_tumbles_through_it():
    mass = RHO * ROD_VOLUME  # it neither sinks nor rises
    water = Water(level=100.0, drag=0.0, axial_drag=0.0)
    start = {"root_velocity": (1.0, 0.0, 0.3), "root_angular_velocity": (3.0, 0.2, 1.0)}
    inertia = (1.0, 0.1, 1.0)
    recording = recorded(afloat(ROD, mass, water, 0.0, 2.0, inertia, **start))
    along, across = (float(one[0]) for one in added_mass(np.array([0.5]), np.array([R])))
    axis = rotate(recording.root_orientation, np.array([0.0, 1.0, 0.0]))
    own = rotate(recording.root_orientation * [-1, -1, -1, 1], recording.root_angular_velocity)
    energy = 0.5 * mass * np.sum(recording.root_velocity**2, axis=1) + 0.5 * np.sum(np.array(inertia) * own**2, axis=1)
    places = (np.arange(section.SECTIONS) + 0.5) / section.SECTIONS - 0.5
    squares = R**2 - np.maximum(np.abs(places) - 0.4, 0.0) ** 2
    for place, square in zip(places, squares, strict=True):
        v = recording.root_velocity + np.cross(recording.root_angular_velocity, axis * place)
        tangential = np.sum(v * axis, axis=1)
        moved = along * tangential**2 + across * (np.sum(v**2, axis=1) - tangential**2)
        energy = energy + 0.5 * RHO * ROD_VOLUME * square / squares.sum() * moved
    np.testing.assert_allclose(energy, energy[0], rtol=4e-3)
    assert np.ptp(axis[:, 1]) > 1.5


def test_each_instance_has_its_own_level_and_a_current_takes_what_swims_along():
    scene = afloat(BALL, 0.3 * RHO * BALL_VOLUME, Water(level=Free(0.0, -1.0, 1.0), current=0.5), 0.0, 8.0)
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2], record_rate=100.0)
    rollout.set_parameters(np.array([[-0.2], [0.0], [0.3]]))
    rollout.run()
    motions = [rollout.recording(k) for k in range(3)]
    heights = [float(np.mean(motion.root_position[-200:, 1])) for motion in motions]
    np.testing.assert_allclose(np.diff(heights), [0.2, 0.3], atol=0.01)
    np.testing.assert_allclose([motion.root_velocity[-1, 2] for motion in motions], 0.5, atol=0.08)
