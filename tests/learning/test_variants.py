"""Masses, strengths and slopes that differ between episodes act as if the scene had them."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.learning import EpisodeBatch, Task, Variation
from warpmuscle.learning.starts import controller_gait
from warpmuscle.learning.variants import drawn, drawn_commands, with_strengths
from warpmuscle.scene import Command, Scene
from warpmuscle.scene.joints.symmetry import side_of
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.perturbations import with_masses
from warpmuscle.simulation.rollout import Rollout

VARIED = Variation(velocity_noise=0.0, mass=0.2, strength=0.3, slope=0.1, variants=5)
TASK = Task(variation=VARIED, episode_time=0.05)
DECISIONS = 4


@pytest.fixture(scope="module")
def batch() -> EpisodeBatch:
    return EpisodeBatch("reflex_planar", 6, "cpu", TASK, threads=1)


def acted(batch: EpisodeBatch) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates after some decisions, and the variant of each instance."""
    batch.reset(4)
    variant = batch.episodes.variant.numpy().copy()
    for _ in range(DECISIONS):
        batch.actions.requested.fill_(0.5)
        batch.step()
    return batch.rollout.state.coordinates.numpy().copy(), variant


def test_an_instance_moves_as_its_variant_does_in_a_scene_of_its_own(batch: EpisodeBatch):
    coordinates, variant = acted(batch)
    assert len(set(variant)) > 2
    scene = load("reflex_planar")
    numeric = substitute(scene, start_values(scene))
    mass, strength, slope, _ = drawn(VARIED, batch.rollout, 5)
    for instance in (0, int(np.flatnonzero(variant != variant[0])[0])):
        which = variant[instance]
        own = with_strengths(with_masses(numeric, mass[which : which + 1]), strength[which : which + 1])
        plain = msgspec.json.decode(msgspec.json.encode(own, enc_hook=lambda array: float(array[0])), type=type(own))
        normal = (0.0, float(np.cos(slope[which])), -float(np.sin(slope[which])))
        plain = msgspec.structs.replace(plain, ground=msgspec.structs.replace(plain.ground, normal=normal))
        still = msgspec.structs.replace(TASK, variation=Variation(velocity_noise=0.0))
        alone, _ = acted(EpisodeBatch(plain, 1, "cpu", still, threads=1))
        np.testing.assert_allclose(coordinates[instance], alone[0], rtol=0.0, atol=2e-6)
    assert np.abs(coordinates - coordinates[0]).max() > 1e-3


def test_another_episode_has_another_variant_and_its_numbers(batch: EpisodeBatch):
    batch.reset(4)
    before = batch.episodes.variant.numpy().copy()
    rows = batch._stepper.model.skeleton.total_mass.numpy()[:, 0].copy()
    for _ in range(5):
        batch.step()
    after = batch.episodes.variant.numpy()
    assert (before != after).any()
    changed = batch._stepper.model.skeleton.total_mass.numpy()[:, 0]
    for values, variant in ((rows, before), (changed, after)):
        mass, *_ = drawn(VARIED, batch.rollout, 5)
        bodies = [body.mass for body in batch.rollout.numeric.character.bodies.values()]
        np.testing.assert_allclose(values[:6], (mass * bodies).sum(axis=1)[variant], rtol=1e-6)


def test_all_muscles_of_a_side_are_stronger_or_weaker_together():
    scene = load("walk56")
    sided = Variation(velocity_noise=0.0, side_strength=0.2, variants=400)
    rollout = Rollout(scene, 1, "cpu", threads=1)
    mass, strength, slope, _ = drawn(sided, rollout, 400)
    names = list(scene.character.muscles)
    left, right = ([k for k, name in enumerate(names) if side_of(name, names) == side] for side in ("left", "right"))
    assert len(left) == len(right) > 20
    for side in (left, right):
        assert np.ptp(strength[:, side], axis=1).max() == 0.0
        assert 0.8 <= strength[:, side].min() < 0.82 < 1.18 < strength[:, side].max() <= 1.2
    assert abs(np.corrcoef(strength[:, left[0]], strength[:, right[0]])[0, 1]) < 0.2
    assert (mass == 1.0).all()
    assert (slope == 0.0).all()
    both, plain = (drawn(Variation(strength=0.3, side_strength=share), rollout, 400)[1] for share in (0.2, 0.0))
    of_side = both / plain  # one's own strength comes on top
    np.testing.assert_allclose(of_side[:, left], of_side[:, left[:1]].repeat(len(left), axis=1), rtol=1e-12)
    assert of_side.std(axis=0).min() > 0.1


def with_load(asked: float | None = None) -> Scene:
    """A walker whose first body is heavier by a commanded load, kg."""
    scene = load("reflex_planar")
    name, body = next(iter(scene.character.bodies.items()))
    loaded = msgspec.structs.replace(body, mass=Free(float(body.mass), per={"load": 1.0}))
    character = msgspec.structs.replace(scene.character, bodies={**scene.character.bodies, name: loaded})
    command = Command(0.0, 0.0, 20.0, asked, unit="kg")
    return msgspec.structs.replace(scene, character=character, commands={"load": command})


def test_episodes_start_in_the_gait_of_the_scene_whatever_it_is_commanded():
    plain, loaded = (controller_gait(Rollout(with_load(asked), 1, "cpu"), 2, 0.05, 1) for asked in (None, 20.0))
    assert len(plain.states) == 2
    for one, other in zip(plain.states, loaded.states, strict=True):
        np.testing.assert_array_equal(one["coordinates"], other["coordinates"])


def test_commands_of_the_scene_are_drawn_in_half_of_the_variants():
    scene = with_load()
    task = Task(variation=Variation(velocity_noise=0.0, commands=["load"], variants=40), episode_time=0.05)
    batch = EpisodeBatch(scene, 16, "cpu", task, threads=1)
    drawn = drawn_commands(task.variation, scene, 40)["load"]
    assert 12 <= (drawn == 0.0).sum() <= 28
    assert drawn.max() > 15.0
    variant = batch.episodes.variant.numpy()
    mass = batch._stepper.model.skeleton.total_mass.numpy()[:16, 0]
    plain = sum(one.mass for one in load("reflex_planar").character.bodies.values())
    np.testing.assert_allclose(mass, plain + drawn[variant], rtol=1e-6)
    np.testing.assert_allclose(batch._variants.described.numpy()[:, 3], drawn / 20.0, rtol=1e-6)
    unknown = Task(variation=Variation(commands=["lode"]))
    with pytest.raises(SceneError, match="did you mean 'load'"):
        EpisodeBatch(scene, 1, "cpu", unknown, threads=1)


def test_pushes_come_about_as_often_as_asked_and_move_the_body():
    push = Variation(velocity_noise=0.0, push=50.0, push_interval=0.03, push_duration=0.01)
    batch = EpisodeBatch("reflex_planar", 16, "cpu", Task(variation=push, episode_time=1.0), threads=1)
    still = EpisodeBatch("reflex_planar", 16, "cpu", Task(variation=Variation(velocity_noise=0.0)), threads=1)
    pushed = 0
    for _ in range(12):
        for one in (batch, still):
            one.actions.requested.fill_(0.0)
            one.step()
        steps, now = batch.rollout.state.push_steps.numpy(), batch.rollout.state.step.numpy()
        pushed += int(((steps[:, 1] > 0) & (now <= steps[:, 1])).sum())
    assert 16 * 12 / 3 * 0.6 < pushed < 16 * 12 / 3 * 1.5
    force = np.linalg.norm(batch.rollout.state.push.numpy(), axis=1)
    assert force.max() <= 50.0 / 0.01 * (1.0 + 1e-6)
    assert not np.allclose(batch.rollout.state.speeds.numpy(), still.rollout.state.speeds.numpy())
