"""Hunt-Crossley contact: OpenSim's forces, restitution and friction of a sphere, foot forces, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.kernels.contact import hunt_crossley
from warpmuscle.model.bodies import material_columns
from warpmuscle.scene import (
    Body,
    Box,
    Character,
    ContactMaterial,
    Failure,
    Ground,
    InitialState,
    Scene,
    Sphere,
    Terrain,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.tiles import Flat, Patch
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

LAWS = ["hunt_crossley", "smooth_hunt_crossley"]
RADIUS, PLACE, MASS = 0.04, (0.02, -0.1, 0.05), 1.0
MATERIAL = ContactMaterial(
    stiffness=1e6, dissipation=1.5, static_friction=0.9, dynamic_friction=0.6, viscous_friction=0.3,
    transition_velocity=0.15,
)  # fmt: skip
# Depth m, sphere's centre from the body's m, velocity m/s, angular velocity rad/s of the body -> force N, moment N m,
# of OpenSim 4.6 (pip install opensim): HuntCrossleyForce and SmoothSphereHalfSpaceForce with the numbers above.
STATES = [
    (0.001747, 0.047703, -0.097175, -0.034373, 0.817392, 0.136384, -0.616664, -1.105295, -1.569561, 1.497492),
    (0.011572, 0.013749, -0.111818, 0.01441, -0.161219, -0.003381, -0.222668, -2.544156, 1.227986, -2.393415),
    (0.006355, 0.027528, -0.098953, -0.048482, -0.360658, -0.25988, 0.080113, 0.530182, -0.928489, -0.957277),
]
OPENSIM = {
    "hunt_crossley": [
        (-3.81272, 4.25515, 1.38668, -0.04274, 0.06491, -0.31669),
        (90.71314, 117.26314, -24.2822, 1.85626, 1.64101, 14.85933),
        (60.05046, 75.76784, -4.53961, 4.28971, -2.78637, 10.23913),
    ],
    "smooth_hunt_crossley": [
        (-8.3937, 9.36774, 3.05277, -0.09409, 0.14289, -0.6972),
        (95.65387, 123.65212, -25.60474, 1.95733, 1.73039, 15.66868),
        (69.35449, 87.50919, -5.24297, 4.95445, -3.21808, 11.82561),
    ],
}


def ball(law: str, material: ContactMaterial | None = MATERIAL, place: Any = PLACE, **changes: Any) -> Scene:
    """A sphere on a body of 1 kg in no gravity."""
    body = Body(MASS, (1.0, 1.0, 1.0), [Sphere(place, RADIUS, material)])
    scene = Scene(
        "ball", Character("ball", {"ball": body}), ground=Ground(law=law), failure=Failure(0.0, 0.0), gravity=0.0
    )
    for field, value in changes.items():
        setattr(scene, field, value)
    return scene


def expected(law: str, depth: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Force (n, 3) at depths and velocities of the point in the middle of the depth, in float64; y is up."""
    p = MATERIAL
    k = 0.5 * p.stiffness ** (2 / 3)
    hertz = 4 / 3 * k * np.sqrt(RADIUS * k)
    rate, slip = -velocity[:, 1], velocity * [1.0, 0.0, 1.0]
    if law == "hunt_crossley":
        along = np.maximum(hertz * np.maximum(depth, 0.0) ** 1.5 * (1 + 1.5 * p.dissipation * rate), 0.0)
        speed = np.linalg.norm(slip, axis=1)
    else:
        elastic = hertz * (depth**2 + 1e-5) ** 0.75 * (0.5 + 0.5 * np.tanh(300.0 * depth))
        along = elastic * (1 + 1.5 * p.dissipation * rate)
        along *= 0.5 + 0.5 * np.tanh(50.0 * (rate + 2 / (3 * p.dissipation)))
        speed = np.sqrt(np.sum(slip**2, axis=1) + 1e-5)
    relative = speed / p.transition_velocity
    friction = p.dynamic_friction + 2 * (p.static_friction - p.dynamic_friction) / (1 + relative**2)
    across = along * (np.minimum(relative, 1.0) * friction + p.viscous_friction * speed) / speed
    return along[:, None] * [0.0, 1.0, 0.0] - across[:, None] * slip


def states(stages: Stages, depth: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Put spheres at depths, at random orientations and speeds: their centres from the bodies', and velocities."""
    random = np.random.default_rng(seed)
    turned = random.normal(size=(len(depth), 4))
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    centre = rotate(turned, np.array(PLACE))
    coordinates = np.zeros((len(depth), 7))
    coordinates[:, 1], coordinates[:, 3:] = RADIUS - depth - centre[:, 1], turned
    speeds = np.concatenate([2.0 * random.normal(size=(len(depth), 3)), 0.5 * random.normal(size=(len(depth), 3))], 1)
    stages.state.coordinates.assign(coordinates.astype(np.float32))
    stages.state.speeds.assign(speeds.astype(np.float32))
    return centre, speeds[:, :3], speeds[:, 3:]


@pytest.mark.parametrize("law", LAWS)
def test_typed_forces_of_opensim_are_those_of_the_law(law: str) -> None:
    given, theirs = np.array(STATES), np.array(OPENSIM[law])
    depth, centre, velocity, spin = given[:, 0], given[:, 1:4], given[:, 4:7], given[:, 7:]
    arm = centre - (RADIUS - 0.5 * depth)[:, None] * [0.0, 1.0, 0.0]
    force = expected(law, depth, velocity + np.cross(spin, arm))
    np.testing.assert_allclose(np.hstack([force, np.cross(arm, force)]), theirs, atol=0.01)


@pytest.mark.parametrize("law", LAWS)
def test_forces_of_random_states_are_those_of_the_law(law: str) -> None:
    """1000 states from 2 cm above the ground to 3 cm in it: within 2e-5 of the greatest force, moments as well."""
    stages = Stages(ball(law), 1000, "cpu")
    depth = np.random.default_rng(0).uniform(-0.02, 0.03, 1000)
    centre, velocity, spin = states(stages, depth, 1)
    force, moment = (part[:, 0].astype(float) for part in stages.contact_forces())
    arm = centre - (RADIUS - 0.5 * depth)[:, None] * [0.0, 1.0, 0.0]
    wanted = expected(law, depth, velocity + np.cross(spin, arm))
    assert np.abs(wanted).max() > 1000.0
    np.testing.assert_allclose(force, wanted, atol=2e-5 * np.abs(wanted).max())
    np.testing.assert_allclose(moment, np.cross(arm, wanted), atol=2e-5 * np.abs(wanted).max())


@pytest.mark.parametrize("law", LAWS)
def test_a_patch_that_is_slippery_bounds_friction_at_rest_and_in_motion(law: str) -> None:
    """By its own number alone at 5 m/s, 33 times the transition velocity, without viscous friction."""
    material = ContactMaterial(1e6, dissipation=0.0, static_friction=0.9, dynamic_friction=0.6, viscous_friction=0.0)
    scene = ball(law, material, (0.0, 0.0, 0.0))
    scene.ground.terrain = Terrain([Flat(patches=[Patch((-1.0, 1.0), (-1.0, 1.0), friction=0.05)])])
    stages = Stages(scene, 1, "cpu")
    stages.state.coordinates.assign(np.float32([[0.0, RADIUS - 0.005, 0.0, 0.0, 0.0, 0.0, 1.0]]))
    stages.state.speeds.assign(np.float32([[3.0, 0.0, 4.0, 0.0, 0.0, 0.0]]))
    force = stages.contact_forces()[0][0, 0].astype(float)
    assert force[1] > 10.0
    np.testing.assert_allclose(force[[0, 2]], -0.05 * force[1] * np.array([0.6, 0.8]), rtol=0.01)


@pytest.mark.parametrize("law", LAWS)
def test_a_ball_bounces_as_the_law_says_without_steps(law: str) -> None:
    """Restitution e of a fall at v solves g(v) = g(-e v), g(v) = v/c - ln(1 + c v)/c^2, c = 3/2 dissipation."""
    speed = 1.0
    scene = ball(law, place=(0.0, 0.0, 0.0), duration=0.1)
    scene.initial_state = InitialState((0.0, RADIUS + 0.02, 0.0), root_velocity=(0.0, -speed, 0.0))
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    c = 1.5 * MATERIAL.dissipation
    tried = np.linspace(0.0, 0.999 / c, 100001)
    g = tried / -c - np.log(1.0 - c * tried) / c**2
    wanted = np.interp(speed / c - np.log(1.0 + c * speed) / c**2, g, tried)
    assert rollout.state.speeds.numpy()[0, 1] == pytest.approx(wanted, abs=0.02 if law == "hunt_crossley" else 0.05)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rate", [2000.0, 500.0])
def test_without_dissipation_no_energy_is_lost_and_none_comes(law: str, rate: float) -> None:
    material = ContactMaterial(stiffness=1e6, dissipation=0.0, static_friction=0.8)
    scene = ball(law, material, (0.0, 0.0, 0.0), duration=0.1, time_step=1.0 / rate)
    scene.initial_state = InitialState((0.0, RADIUS + 0.02, 0.0), root_velocity=(0.0, -1.0, 0.0))
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.state.speeds.numpy()[0, 1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rate", [2000.0, 500.0])
def test_a_light_ball_on_a_stiff_ground_comes_to_rest_with_its_weight_on_the_foot(law: str, rate: float) -> None:
    """100 g on 1e7 N/m^2, thrown sideways: friction stops it, and the recorded force of the foot is its weight."""
    material = ContactMaterial(stiffness=1e7, dissipation=2.0)
    scene = ball(law, material, (0.0, 0.0, 0.0), duration=1.5, time_step=1.0 / rate, gravity=9.81)
    bodies = {"base": Body(0.1, (1e-4, 1e-4, 1e-4), [Sphere((0.0, 0.0, 0.0), RADIUS, material)])}
    bodies |= {"other": Body(0.01, (1e-5, 1e-5, 1e-5))}
    scene.character = Character("base", bodies, {"w": weld()}, feet=("base", "other"))
    scene.initial_state = InitialState((0.0, RADIUS + 0.01, 0.0), root_velocity=(0.3, 0.0, 0.0))
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    force = rollout.recording().foot_force_left[-10:, 1]
    np.testing.assert_allclose(force, 0.11 * 9.81, rtol=0.02)
    assert np.abs(rollout.state.speeds.numpy()[0, 1]) < 1e-3


def weld() -> Any:
    from warpmuscle.scene import Joint

    return Joint("fixed", "base", "other", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_materials_may_be_free_and_each_sphere_has_its_own() -> None:
    """k = 4/3 sqrt(R) (E^(2/3)/2)^(3/2) is in proportion to E."""
    scene = ball("hunt_crossley", ContactMaterial(stiffness=Free(1e6, 1e5, 1e7), dissipation=0.0))
    rollout = Rollout(scene, 2, "cpu")
    rollout.set_parameters(np.array([[1e6], [2e6]]))
    hertz = rollout.model.contacts.material.numpy()["hertz"][:, 0]
    assert hertz[1] / hertz[0] == pytest.approx(2.0, rel=1e-5)
    own = material_columns(MATERIAL, RADIUS, "hunt_crossley")
    assert own["hertz"][0] == pytest.approx(4 / 3 * np.sqrt(RADIUS) * (1e4 / 2) ** 1.5)


@pytest.mark.parametrize("smooth", [False, True])
def test_slopes_are_derivatives(smooth: bool) -> None:
    depth = np.linspace(-0.009, 0.03, 100)
    function, own = (hunt_crossley.smooth_hertz_force, (300.0, 1e-5)) if smooth else (hunt_crossley.hertz_force, ())
    force, h = evaluate(function, depth, 1e5, *own), 1e-4
    before, after = (evaluate(function, depth + shift, 1e5, *own)[:, 0] for shift in (-h, h))
    np.testing.assert_allclose(force[:, 1], (after - before) / (2 * h), atol=0.01 * force[:, 1].max())


@pytest.mark.parametrize("smooth", [False, True])
def test_rates_of_dissipation_are_derivatives(smooth: bool) -> None:
    """Hunt, Crossley 1975: 1 + 3/2 c v, which ends at 0; the smooth one goes over into that within some 1/300 m/s."""
    rate, c, h = np.linspace(-1.5, 1.0, 100), 0.8, 1e-3
    function, own = (hunt_crossley.smoothly_dissipated, (30.0,)) if smooth else (hunt_crossley.dissipated, ())
    factor = evaluate(function, rate, c, *own)
    away = np.abs(rate + 1.0 / 1.2) > (0.2 if smooth else 2.0 * h)  # from where it ends
    np.testing.assert_allclose(factor[away, 0], np.maximum(1.0 + 1.2 * rate, 0.0)[away], atol=2e-4)
    before, after = (evaluate(function, rate + shift, c, *own)[:, 0] for shift in (-h, h))
    slope = np.maximum((after - before) / (2.0 * h), 0.0)
    near = np.ones(len(rate), dtype=bool) if smooth else away
    np.testing.assert_allclose(factor[near, 1], slope[near], atol=5e-3)


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"law": "spring"}, "shapes.0.material", "set `ground.law`"),
        ({"shape": Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))}, "shapes.0", "spheres or capsules"),
        ({"static_friction": -0.1}, "material.static_friction", "negative"),
        ({"transition_velocity": 0.0}, "material.transition_velocity", "greater than 0"),
        ({"dissipation": -1.0}, "material.dissipation", "negative"),
    ],
)
def test_what_cannot_touch_is_refused(change: dict, key: str, words: str) -> None:
    scene = ball(change.pop("law", "hunt_crossley"))
    shapes = scene.character.bodies["ball"].shapes
    shape = change.pop("shape", None)
    if shape is not None:
        shapes[0] = shape
    elif isinstance(shapes[0], Sphere):
        shapes[0] = Sphere(PLACE, RADIUS, ContactMaterial(**{f: getattr(MATERIAL, f) for f in FIELDS} | change))
    with pytest.raises(SceneError) as caught:
        check_scene(scene)
    assert caught.value.key.endswith(key)
    assert words in str(caught.value)


FIELDS = MATERIAL.__struct_fields__


def test_materials_come_back_from_toml() -> None:
    scene = ball("smooth_hunt_crossley")
    scene.ground.material = ContactMaterial(dissipation=0.5)
    assert loads(dumps(scene)) == loads(dumps(loads(dumps(scene))))
    assert loads(dumps(scene)).character.bodies["ball"].shapes == scene.character.bodies["ball"].shapes
    assert loads(dumps(scene)).ground == scene.ground
