"""Shipped gaits that muscles drive: upright, at the speed of the original program, within the bounds of muscles."""

import numpy as np
import pytest

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gait.measures import measure
from warpmuscle.gait.quality import gait_measures
from warpmuscle.scene import Actuation, Failure, MuscleModel, Scene
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.simulation.rollout import Rollout

TENDONS = ["rigid", "compliant"]


def pushed(scene: Scene, duration: float, instances: int = 4, noise: float = 0.01, rate: float = 100.0) -> Rollout:
    """Some seconds, each instance with its own small push at the start."""
    scene.duration = duration
    rollout = Rollout(scene, instances, "cpu", record=range(instances), record_rate=rate)
    rollout.reset(velocity_noise=noise, seed=1)
    rollout.run()
    return rollout


@pytest.mark.parametrize("tendon", TENDONS)
def test_biped_walks_on_muscles_alone(tendon: str):
    scene = load("walk56")
    scene.muscle_model = MuscleModel(tendon=tendon)
    rollout = pushed(scene, 10.0)
    assert rollout.alive == 4
    for i in range(4):
        gait = measure(rollout.recording(i), *scene.controller.feet, start=5.0)
        assert 0.8 < gait.speed_forward < 1.15
        assert gait.cadence == pytest.approx(105.3, rel=0.03)


def test_steps_four_times_as_long_make_the_same_gait_if_what_is_stiff_is_implicit():
    fine, coarse = load("walk56"), load("walk56")
    coarse.time_step, coarse.implicit_pd, coarse.muscle_model.implicit_damping = 1.0 / 500.0, True, True
    gaits = []
    for scene in (fine, coarse):
        rollout = pushed(scene, 10.0)
        assert rollout.alive == 4
        each = [measure(rollout.recording(i), *scene.controller.feet, start=5.0) for i in range(4)]
        gaits.append([np.mean([getattr(g, n) for g in each]) for n in ("speed_forward", "step_length", "cadence")])
    np.testing.assert_allclose(gaits[1], gaits[0], rtol=0.03)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "slowest", "fastest"),
    [
        ("walk44_but_hips", 1.15, 1.35),
        ("walk50_but_back", 1.15, 1.35),
        ("legs28", 0.8, 1.15),
        ("jog56", 1.7, 1.9),
        ("inplace56", -0.05, 0.05),
        ("back56", -0.7, -0.5),
        ("wang2012", 0.84, 0.94),  # it is asked for 1 m/s, and walks slower to stay upright
    ],
)
def test_gait_with_muscles_stays_upright(name: str, slowest: float, fastest: float):
    scene = load(name)
    rollout = pushed(scene, 5.0)
    assert rollout.alive == 4
    speeds = [measure(rollout.recording(i), *scene.controller.feet, start=2.5).speed_forward for i in range(4)]
    assert slowest < min(speeds)
    assert max(speeds) < fastest


def test_one_scene_walks_like_a_person_at_the_speed_that_is_asked_for():
    scene, speeds = load("walk56_speeds"), [0.8, 1.0, 1.25, 1.5]
    assert {end.name for end in free_parameters(scene)} == {"objective.target_speed"}
    rollout = Rollout(scene, 4, "cpu", record=range(4), record_rate=200.0)
    rollout.set_parameters(np.array(speeds)[:, None])
    rollout.run()
    assert rollout.alive == 4
    for i, speed in enumerate(speeds):
        numeric = substitute(scene, np.array([speed]))
        measures = gait_measures(rollout.recording(i), numeric)
        assert measures["speed"] == pytest.approx(speed, rel=0.05)
        assert measures["deviation of the three angles"] < 1.2
        assert measures["maximum slide of the stance foot"] < 2.0


@pytest.mark.parametrize("tendon", TENDONS)
def test_muscles_stay_within_their_bounds_while_the_biped_falls(tendon: str):
    """Pushed hard, and simulated on through the fall."""
    scene = load("walk56")
    scene.failure, scene.muscle_model = Failure(0.0, 0.0), MuscleModel(tendon=tendon)
    rollout = pushed(scene, 2.0, noise=1.0, rate=2000.0)
    recordings = [rollout.recording(i) for i in range(4)]
    assert min(recording.com[:, 1].min() for recording in recordings) < 0.6
    muscles = substitute(scene, start_values(scene)).character.muscles.values()
    f_max, l_opt = np.array([muscle.f_max for muscle in muscles]), np.array([muscle.l_opt for muscle in muscles])
    for recording in recordings:
        assert recording.muscle_force.min() >= 0.0
        assert np.all(recording.muscle_force.max(axis=0) <= (1.8 + 1.5 + scene.muscle_model.damping) * f_max)
        assert np.all(recording.muscle_fibre_length.min(axis=0) >= 0.05 * l_opt * (1.0 - 1e-5))
        for name in ("excitation", "activation"):
            assert recording[f"muscle_{name}"].min() >= 0.0
            assert recording[f"muscle_{name}"].max() <= 1.0
        assert np.any(recording.muscle_force.max(axis=0) > 0.9 * f_max)


# The original program's own muscles.


@pytest.mark.parametrize(("name", "least", "most"), [("walk56_legacy", 0.9, 1.5), ("walk44_legacy", 1.4, 2.1)])
def test_walk_on_the_original_muscles_falls_when_it_did(name: str, least: float, most: float):
    rollout = pushed(load(name), 6.0, instances=60)
    assert np.all(rollout.status() == Status.FELL)
    assert least < np.median(rollout.end_time()) < most


def test_original_muscles_walk_with_their_own_gains_and_hips_on_torques():
    """Fig. 17b of Bergmann 2017: stable, with very short steps."""
    rollout = pushed(load("walk44_legacy_short_steps"), 20.0, instances=8)
    assert np.all(rollout.status() == Status.COMPLETED)
    for i in range(8):
        gait = measure(rollout.recording(i), "lFoot", "rFoot", start=5.0)
        assert gait.speed_horizontal == pytest.approx(0.59, abs=0.05)  # the original program: 0.61 m/s forward
        assert gait.step_length == pytest.approx(0.245, abs=0.03)  # 0.245 +- 0.05 m
        assert gait.cadence == pytest.approx(153.7, rel=0.04)


def test_original_muscles_fall_with_hips_on_muscles_and_a_torque_at_the_back():
    """Fig. 17c."""
    for name, least, most in (("walk56_legacy", 0.7, 1.6), ("walk44_legacy_short_steps", 1.5, 1.9)):
        scene = load(name)
        scene.actuation = {"pelvis_torso": Actuation("torque")}
        rollout = pushed(scene, 6.0, instances=20)
        assert np.all(rollout.status() == Status.FELL)
        assert least < np.median(rollout.end_time()) < most
