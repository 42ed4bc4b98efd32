"""Contacts that are soft constraints: bounce, rest, slide, what is refused, and the original program's fast gaits."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.kernels.contact.soft_constraint import leaving_speed
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Scene, Sphere
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

MASS, RADIUS, STEP, GRAVITY = 5.0, 0.1, 0.0005, 9.8
HIGH = 0.3  # m, from which the ball falls


def test_points_bounce_from_a_hundredth_of_a_millimetre_a_second_on_and_are_pushed_out_at_a_metre_a_second_at_most():
    speed = np.array([-9.0e-6, -9.9e-6, -1.01e-5, -2.0, 3.0])
    found = evaluate(leaving_speed, 0.0, speed, 0.2, 0.5, STEP)
    np.testing.assert_allclose(found, [0.0, 0.0, 5.05e-6, 1.0, 0.0], rtol=1e-5)
    depth = np.array([0.0009, 0.0011, 0.002, 0.0034, 0.0036, 0.1])
    out = evaluate(leaving_speed, depth, 0.0, 0.2, 0.5, STEP)
    np.testing.assert_allclose(out, [0.0, 0.04, 0.4, 0.96, 1.0, 1.0], rtol=1e-4, atol=1e-6)


def ball(height: float, speed: tuple[float, float, float] = (0.0, 0.0, 0.0), **ground: Any) -> Scene:
    """A ball that cannot be turned, over the ground."""
    body = Body(MASS, (1e6, 1e6, 1e6), [Sphere((0.0, 0.0, 0.0), RADIUS)], friction=0.6)
    return Scene(
        "ball",
        Character("ball", {"ball": body}),
        initial_state=InitialState(root_position=(0.0, RADIUS + height, 0.0), root_velocity=speed),
        ground=Ground(law="soft_constraint", **ground),
        failure=Failure(0.0, 0.0),
        gravity=GRAVITY,
        duration=1.0,
        time_step=STEP,
    )


def motion(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Places and velocities (steps, 3) of the ball, at every step."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / STEP)
    rollout.run()
    return rollout.recorded("coordinates")[0][:, :3], rollout.recorded("speeds")[0][:, :3]


def exact_height(height: float, restitution: float, softness: float, penalty: float, steps: int) -> np.ndarray:
    """The same ball in float64: the force that leaves it at the speed wanted, and never pulls; leapfrog."""
    y, v, places = height, 0.0, []
    for step in range(steps):
        places.append(y)
        force = 0.0
        if y < 0.0:
            wanted = min(penalty / STEP * max(-y - 0.001, 0.0), 1.0)
            if -v > 1e-5:
                wanted = max(wanted, -restitution * v)
            if wanted > v:  # (wanted - v - h (f/m - g)) / s = f
                force = (wanted - v + STEP * GRAVITY) / (softness + STEP / MASS)
        v += (0.5 if step == 0 else 1.0) * STEP * (force / MASS - GRAVITY)
        y += STEP * v
    return np.array(places)


@pytest.mark.parametrize(("restitution", "softness"), [(0.35, 2e-4), (0.0, 2e-4), (0.8, 2e-5)])
def test_ball_falls_bounces_and_rests_as_computed_in_float64(restitution: float, softness: float) -> None:
    places, _ = motion(ball(HIGH, restitution=restitution, softness=softness))
    wanted = exact_height(HIGH, restitution, softness, 0.2, len(places))
    assert np.abs(places[:, 1] - RADIUS - wanted).max() < 2e-3 * HIGH


def test_hard_ball_bounces_to_the_square_of_the_restitution() -> None:
    places, _ = motion(ball(HIGH, restitution=0.6, softness=1e-7))
    height = places[:, 1] - RADIUS
    landed = int(np.argmax(height < 0.0))
    assert height[landed:].max() == pytest.approx(0.36 * HIGH, rel=0.02)


def test_ball_rests_at_the_depth_of_the_spring_that_the_constraint_is() -> None:
    """A constraint is a spring of stiffness p/(h s) (Smith 2006, section 3.8), below the depth that is not pushed."""
    places, velocities = motion(ball(-0.001))
    assert -(places[-1, 1] - RADIUS) == pytest.approx(0.001 + MASS * GRAVITY * STEP * 2e-4 / 0.2, abs=2e-6)
    assert np.abs(velocities[-1]).max() < 1e-4


def test_ball_that_slides_is_slowed_by_friction() -> None:
    _, velocities = motion(ball(-0.001 - MASS * GRAVITY * STEP * 2e-4 / 0.2, (0.0, 0.0, 2.0)))
    slowed = (velocities[0, 2] - velocities[400, 2]) / (400 * STEP)
    assert slowed == pytest.approx(0.6 * GRAVITY, rel=0.03)


def test_speeds_after_a_step_are_those_of_the_equation() -> None:
    depth, speed = np.array([0.0, 0.0005, 0.0015, 0.01, 0.0015]), np.array([-1.0, 0.1, 0.0, -0.1, -1.0])
    own = evaluate(leaving_speed, depth, speed, *np.full((3, 5), [[0.2], [0.35], [STEP]]))
    pushed = np.minimum(0.2 / STEP * np.maximum(depth - 0.001, 0.0), 1.0)
    assert own == pytest.approx(np.where(speed < -1e-5, np.maximum(pushed, -0.35 * speed), pushed), abs=1e-6)


def test_restitution_may_be_searched() -> None:
    scene = ball(HIGH, restitution=Free(0.35, 0.0, 0.9), softness=1e-6)
    rollout = Rollout(scene, 2, "cpu")
    rollout.set_parameters([[0.1], [0.8]])
    rollout.run(0.4)
    low, high = rollout.state.coordinates.numpy()[:, 1]
    assert high > low + 0.05


@pytest.mark.parametrize(
    ("ground", "key"),
    [
        ({"restitution": 1.5}, "ground.restitution"),
        ({"softness": 0.0}, "ground.softness"),
        ({"penalty": -0.1}, "ground.penalty"),
        ({"law": "spring", "restitution": 0.5}, "ground.restitution"),
    ],
)
def test_what_cannot_be_is_refused(ground: dict[str, Any], key: str) -> None:
    scene = ball(HIGH)
    for name, value in ground.items():
        setattr(scene.ground, name, value)
    with pytest.raises(SceneError) as caught:
        check_scene(scene)
    assert caught.value.key == key


def test_ground_comes_back_from_toml() -> None:
    scene = ball(HIGH, restitution=0.5, softness=1e-4, penalty=0.4)
    assert loads(dumps(scene)).ground == scene.ground


@pytest.mark.parametrize(
    ("character", "gait"), [("bigBird", "run"), pytest.param("raptor", "bWalk", marks=pytest.mark.long)]
)
def test_fast_gaits_of_the_original_program_are_as_fast(character: str, gait: str, reference_data: Path) -> None:
    """Within 4 %, 5 to 20 s of a recording; with springs both are 6 % off."""
    folder = reference_data / "simbicon"
    recorded = np.load(folder / f"reference/{character}_{gait}.npz")
    files = [folder / f"controllers/{character}/{gait}{end}" for end in (".sbc", "State.rs")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what the files have and a scene has not
        scene = load(folder / f"characters/{character}/{character}.rbs", *files)
    scene.ground.law, scene.duration = "soft_constraint", 20.0
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    ours, theirs = rollout.recorded("coordinates")[0][:, 2], recorded["root_pos"][:, 2]
    assert rollout.status_names() == ("completed",)
    assert (ours[1999] - ours[500]) / (theirs[1999] - theirs[500]) == pytest.approx(1.0, abs=0.04)
