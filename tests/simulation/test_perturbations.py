"""Pushes give their impulse, slopes let things slide, and robust costs come from runs that are drawn once."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Robustness, Scene, Sphere
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation import perturbations
from warpmuscle.simulation.perturbations import Perturbations
from warpmuscle.simulation.rollout import Rollout

MASS = 2.0


def ball(height: float = 0.1, friction: float = 0.0) -> Scene:
    """A ball of 0.1 m that lies on the ground, or is above it."""
    body = Body(MASS, (0.01, 0.01, 0.01), [Sphere((0.0, 0.0, 0.0), 0.1)], friction=friction)
    state = InitialState((0.0, height, 0.0))
    return Scene(
        "ball", Character("ball", {"ball": body}), initial_state=state, failure=Failure(0.0, 0.0), duration=1.0
    )


def disturbed(instances: int, **changes: np.ndarray) -> Perturbations:
    return Perturbations(**(vars(perturbations.none(instances)) | changes))


def test_a_push_gives_the_root_its_impulse_while_it_lasts():
    scene = msgspec.structs.replace(ball(10.0), gravity=0.0)
    push = np.array([[4.0, 0.0, 0.0], [0.0, 0.0, -6.0], [0.0, 0.0, 0.0]])
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2])
    rollout.disturb(disturbed(3, push=push, push_start=np.array([0.2, 0.5, 0.0])))
    rollout.run()
    for i, start in enumerate((0.2, 0.5, 0.0)):
        motion = rollout.recording(i)
        before, after = motion.time <= start, motion.time >= start + 0.1 + 0.001
        np.testing.assert_allclose(motion.root_velocity[before], 0.0, atol=1e-6)
        np.testing.assert_allclose(
            motion.root_velocity[after] * MASS, push[i] + 0.0 * motion.root_velocity[after], atol=1e-4
        )


def test_on_a_slope_a_ball_without_friction_slides_with_gravity_times_its_sine():
    slope = np.array([0.1, 0.0, -0.2])
    rollout = Rollout(ball(), 3, "cpu", record=[0, 1, 2])
    rollout.disturb(disturbed(3, slope=slope))
    rollout.run()
    for i, angle in enumerate(slope):
        velocity = rollout.recording(i).root_velocity[-1]
        expected = -9.8 * np.sin(angle) * np.cos(angle) * 0.99
        np.testing.assert_allclose(velocity[2], expected, atol=0.1)


def test_who_goes_downhill_has_not_fallen_and_who_sinks_has():
    scene = msgspec.structs.replace(ball(), failure=Failure(0.9, 0.0))
    rollout = Rollout(scene, 2, "cpu", record=[0])
    rollout.disturb(disturbed(2, slope=np.array([-0.3, 0.0]), velocity=np.array([[0.0] * 3, [0.0, -10.0, 0.0]])))
    rollout.run()
    assert rollout.status().tolist() == [Status.COMPLETED, Status.FELL]
    assert rollout.recording(0).com[-1, 1] < -0.3


def test_velocities_are_added_to_the_start_and_parameters_keep_the_disturbances():
    rollout = Rollout(load("fwalk"), 2, "cpu", record=[0, 1])
    given = np.array([[0.0, 0.0, 0.0], [0.1, 0.2, -0.3]])
    rollout.disturb(disturbed(2, velocity=given))
    rollout.set_parameters(np.array([p.value for p in rollout.parameters]))
    rollout.run(0.02)
    plain, changed = (rollout.recording(i).root_velocity[0] for i in (0, 1))
    np.testing.assert_allclose(changed - plain, given[1], atol=1e-6)


def test_runs_are_drawn_once_and_the_first_of_several_is_not_disturbed():
    robustness = Robustness(runs=5, velocity_noise=0.1, push=10.0, slope=0.05)
    one, two = (perturbations.drawn(robustness, 10.0) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(vars(one).values(), vars(two).values(), strict=True))
    assert not one.push[0].any()
    assert not one.velocity[0].any()
    assert one.slope[0] == 0.0
    np.testing.assert_allclose(np.linalg.norm(one.push[1:], axis=1), 10.0)
    assert np.all(np.abs(one.slope) <= 0.05)
    assert np.all((one.push_start >= 1.0) & (one.push_start <= 9.0))
    assert len(one.tiled(3)) == 15
    assert np.array_equal(one.tiled(3).push[7], one.push[2])


def test_costs_of_runs_become_their_mean_or_the_worst():
    costs = np.array([[1.0, 2.0, 6.0], [4.0, 4.0, 4.0]])
    assert perturbations.combined(costs, Robustness(runs=3)).tolist() == [3.0, 4.0]
    assert perturbations.combined(costs, Robustness(runs=3, cost="worst")).tolist() == [6.0, 4.0]


def test_another_number_of_instances_is_an_error():
    with pytest.raises(RolloutError, match="2 disturbances for 3"):
        Rollout(ball(), 3, "cpu").disturb(perturbations.none(2))


@pytest.mark.parametrize(
    ("field", "value"), [("runs", 0), ("push", -1.0), ("push_duration", 0.0), ("velocity_noise", -0.1), ("slope", -1.0)]
)
def test_impossible_robustness_is_named_by_its_key(field: str, value: float):
    scene = msgspec.structs.replace(ball(), ground=Ground(), robustness=Robustness(**{field: value}))
    with pytest.raises(SceneError) as caught:
        check_scene(scene)
    assert caught.value.key == f"robustness.{field}"


def test_a_heavier_body_has_more_inertia_in_proportion():
    """A body of the same shape and another density: both its mass and its moments of inertia go with the density."""
    scene = perturbations.with_masses(ball(), np.array([[1.0], [1.25]]))
    body = scene.character.bodies["ball"]
    np.testing.assert_allclose(body.mass, [2.0, 2.5])
    for moment in body.inertia:
        np.testing.assert_allclose(moment, [0.01, 0.0125])


def test_a_stronger_muscle_moves_its_instance_as_a_scene_that_says_so_does():
    scene = load("reflex_planar", set={"duration": 0.1, "objective.heading": 10.0})  # a step that other tests have
    muscles = list(scene.character.muscles)
    factors = np.ones((3, len(muscles)))
    factors[1, 0::2], factors[2] = 0.5, 1.3
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2])
    rollout.disturb(disturbed(3, strength=factors))
    rollout.run()
    for i in range(3):
        own = {
            name: msgspec.structs.replace(muscle, f_max=muscle.f_max * factors[i, k])
            for k, (name, muscle) in enumerate(scene.character.muscles.items())
        }
        plain = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, muscles=own))
        alone = Rollout(plain, 1, "cpu", record=[0])
        alone.run()
        np.testing.assert_allclose(rollout.recording(i).com, alone.recording(0).com, rtol=0.0, atol=1e-6)
    assert np.abs(rollout.recording(1).com[-1] - rollout.recording(2).com[-1]).max() > 1e-4


def test_strengths_go_with_their_instances():
    factors = np.arange(6.0).reshape(3, 2)
    one = disturbed(3, strength=factors)
    assert one.any
    np.testing.assert_array_equal(one.part(slice(1, 3)).strength, factors[1:])
    np.testing.assert_array_equal(one.tiled(2).strength[3:], factors)


@pytest.mark.parametrize("name", ["mass", "strength"])
def test_factors_of_another_number_of_parts_are_an_error(name: str):
    with pytest.raises(RolloutError, match=f"factors of {name} have shape \\(2, 3\\); this rollout takes \\(2, "):
        Rollout(ball(), 2, "cpu").disturb(disturbed(2, **{name: np.ones((2, 3))}))
