"""Muscles of creatures: within their boxes, alike on both sides, with fibres at their optimum in the standing pose."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

import warpmuscle.examples
from small_creature import small_creature
from warpmuscle.creatures.build import creature_scene, read_creature
from warpmuscle.creatures.skeleton import middle
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.scene import InitialState
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.moment_arms import joint_range, moment_arms, muscle_geometry

EXAMPLES = Path(warpmuscle.examples.__file__).parent / "files"


@pytest.fixture(scope="module")
def scene():
    return creature_scene(small_creature())


def standing(scene):
    """The coordinates (1, C) in which the creature is drawn."""
    upright = msgspec.structs.replace(scene, initial_state=InitialState(scene.initial_state.root_position))
    return Rollout(substitute(upright, start_values(upright)), 1, "cpu").state.coordinates.numpy()


def test_points_begin_and_stay_in_their_boxes(scene):
    creature = small_creature()
    for name, muscle in creature.muscles.items():
        for point, made in zip(muscle.path, scene.character.muscles[f"l{name}"].path, strict=True):
            centre = middle(creature.segments[point.on])
            for low, high, at, c in zip(point.low, point.high, made.position, centre, strict=True):
                ends = (at.min, at.max) if isinstance(at, Free) else (at, at)
                np.testing.assert_allclose(np.array(ends) + c, (low, high), atol=1e-8)
    start = scene.character.muscles["lBack"].path[1].position
    assert [part.value if isinstance(part, Free) else part for part in start] == pytest.approx([0, 0.15, -0.02])


def test_both_sides_have_the_same_numbers_whatever_a_search_chooses(scene):
    parameters = free_parameters(scene)
    assert not any(".rBack" in p.name or ".rFront" in p.name or ".rLong" in p.name for p in parameters)
    drawn = np.random.default_rng(1).uniform([p.min for p in parameters], [p.max for p in parameters])
    character = substitute(scene, drawn).character
    for name in ("Back", "Front", "Long"):
        left, right = (character.muscles[f"{side}{name}"] for side in "lr")
        for field in ("f_max", "l_opt", "l_slack"):
            assert getattr(left, field) == getattr(right, field)
        for one, other in zip(left.path, right.path, strict=True):
            np.testing.assert_allclose(np.array(other.position) * [-1, 1, 1], one.position, atol=1e-12)
    assert character.surfaces["lBack_0"].radius == character.surfaces["rBack_0"].radius
    np.testing.assert_allclose(
        np.array(character.surfaces["rBack_0"].position) * [-1, 1, 1], character.surfaces["lBack_0"].position
    )


def test_fibres_begin_at_their_optimal_length_in_the_standing_pose(scene):
    length, _ = muscle_geometry(scene, standing(scene))
    numeric = substitute(scene, start_values(scene))
    for k, muscle in enumerate(numeric.character.muscles.values()):
        assert length[0, k] - muscle.l_slack == pytest.approx(muscle.l_opt, abs=2e-5)
        low, high = (length[0, k] * part for part in (0.2, 0.6))
        assert muscle.l_opt == pytest.approx(np.sqrt(low * high), rel=1e-4)


def test_a_muscle_over_a_cylinder_keeps_its_side_and_distance(scene):
    hip = scene.character.joints["lHip"]
    arms = moment_arms(scene, "lHip", 0, np.linspace(*joint_range(hip, 0), 9))
    back = arms.arm[:, arms.muscles.index("lBack")]
    assert np.all(back >= 0.02 - 1e-5)  # it pulls the leg backwards, at least as far as the cylinder is wide
    assert back.min() == pytest.approx(0.02, abs=1e-4)
    front = arms.arm[:, arms.muscles.index("lFront")]
    assert np.all(front < 0.0)


def stepped(scene, values):
    """A batch with these parameters (n, P), some steps on."""
    rollout = Rollout(scene, len(values), "cpu", threads=1)
    rollout.set_parameters(values)
    rollout.step(20)
    return rollout


def test_a_batch_has_muscles_of_each_instance_as_if_it_were_alone(scene):
    """Attachments, radii, forces and lengths of one instance are no other's: the same bits as by itself."""
    parameters = free_parameters(scene)
    low, high = (np.array([getattr(p, end) for p in parameters]) for end in ("min", "max"))
    values = np.random.default_rng(2).uniform(low, high, (3, len(parameters)))
    for k, parameter in enumerate(parameters):
        if not parameter.name.startswith(("character.", "controller.")):
            values[:, k] = parameter.value
    batch = stepped(scene, values)
    lengths = batch.state.muscles.moment_arm.numpy()
    assert len({row.tobytes() for row in lengths}) == 3
    for k in range(3):
        alone = stepped(scene, values[k : k + 1])
        for name in ("coordinates", "speeds"):
            np.testing.assert_array_equal(getattr(batch.state, name).numpy()[k], getattr(alone.state, name).numpy()[0])


def test_a_path_over_two_joints_keeps_its_side_of_both():
    """A hip flexor that straightens the knee: its two cylinders are gone round in their order."""
    walker = creature_scene(read_creature(EXAMPLES / "walker.toml"))
    generator = np.random.default_rng(1)
    joints = topology(walker.character)
    place = [joints.coordinate_start[joints.joints.index(name) + 1] for name in ("lHip", "lKnee")]
    poses = np.repeat(standing(walker), 60, axis=0)
    poses[:, place[0]], poses[:, place[1]] = generator.uniform(-1.0, 0.4, 60), generator.uniform(0.0, 1.6, 60)
    _, arm = muscle_geometry(walker, poses)
    own = arm[:, list(walker.character.muscles).index("lRF")]
    across = own[:, [joints.speed_start[joints.joints.index(name) + 1] for name in ("lHip", "lKnee")]]
    assert np.all(across < -0.019)  # forwards of both, as far as the cylinders are wide
