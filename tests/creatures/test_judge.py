"""Plausibility of muscles: what no animal has is found, and nothing else."""

from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from small_creature import small_creature, small_in_space
from warpmuscle.core.errors import Error
from warpmuscle.creatures import judge
from warpmuscle.creatures.build import creature_scene
from warpmuscle.creatures.judge import one_arm, plausibility
from warpmuscle.formats import load
from warpmuscle.scene.initial_pose import initial_pose
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def scene():
    made = creature_scene(small_creature())
    return substitute(made, start_values(made))


class Motion(SimpleNamespace):
    """A motion that holds what is judged."""

    def __getitem__(self, name):
        return getattr(self, name)


def motion(scene, fibre=1.0, force=0.5):
    """Hips that swing through their range, and fibres and forces as told."""
    rest = Rollout(scene, 1, "cpu").state.coordinates.numpy()[0].astype(float)
    names = Rollout(scene, 1, "cpu").names
    angles = np.linspace(-0.5, 0.5, 11)
    coordinates = np.tile(rest, (len(angles), 1))
    for joint in ("lHip", "rHip"):
        coordinates[:, names.coordinate_start[names.body_of_joint(joint)]] = angles
    muscles = scene.character.muscles
    return Motion(
        frames=len(angles), coordinate=coordinates, muscle_names=tuple(muscles),
        muscle_fibre_length=np.tile([fibre * one.l_opt for one in muscles.values()], (len(angles), 1)),
        muscle_force=np.tile([force * one.f_max for one in muscles.values()], (len(angles), 1)),
    )  # fmt: skip


def test_muscles_that_keep_their_distance_and_fibres_are_plausible(scene):
    found = plausibility(scene, motion(scene))
    assert found.doubts == ()
    back = next(one for one in found.crossings if (one.muscle, one.joint) == ("lBack", "lHip"))
    assert 0.0199 < back.least < back.greatest < back.longest == pytest.approx(0.3 * 0.9, rel=0.1)


def test_a_muscle_through_a_joint_is_found(scene):
    through = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character))
    muscle = msgspec.structs.replace(scene.character.muscles["lFront"])
    trunk, leg = muscle.path
    straight = [
        msgspec.structs.replace(trunk, position=(0.1, -0.2, -0.05)),
        msgspec.structs.replace(leg, position=(0.0, 0.2, 0.0)),
    ]
    through.character.muscles = scene.character.muscles | {"lFront": msgspec.structs.replace(muscle, path=straight)}
    doubts = plausibility(through, motion(through)).doubts
    assert len(doubts) == 1
    assert doubts[0].startswith("lFront at lHip: goes through the joint")


@pytest.mark.parametrize(
    ("fibre", "force", "words"),
    [(1.6, 0.5, "fibres of 1.60 to 1.60 l_opt"), (0.4, 0.5, "fibres of 0.40"), (1.0, 1.9, "tension of 1.90 f_max")],
)
def test_fibres_and_tensions_beyond_bounds_are_found(scene, fibre, force, words):
    doubts = plausibility(scene, motion(scene, fibre, force)).doubts
    assert len(doubts) == len(scene.character.muscles)
    assert all(words in doubt for doubt in doubts)


def test_too_strong_a_muscle_is_found(scene):
    strong = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character))
    weight = scene.gravity * sum(body.mass for body in scene.character.bodies.values())
    heavy = msgspec.structs.replace(scene.character.muscles["lBack"], f_max=16.0 * weight)
    strong.character.muscles = scene.character.muscles | {"lBack": heavy}
    assert plausibility(strong, motion(strong)).doubts == ("lBack: strength of 16 body weights, more than 15",)


def test_a_body_without_muscles_is_refused(scene):
    bare = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, muscles={}))
    with pytest.raises(Error, match="has no muscles"):
        plausibility(bare, motion(scene))


def test_at_a_hip_of_two_axes_the_arm_is_a_vector_that_keeps_its_side():
    """A flexor may lift the leg outwards in one pose and pull it inwards in another, but not turn round."""
    flexor = np.array([[0.04, 0.01], [0.04, -0.01], [0.03, 0.0]])
    along, whole = one_arm(flexor)
    np.testing.assert_allclose(along, [0.04, 0.04, 0.03])
    np.testing.assert_allclose(whole, np.sqrt([0.0017, 0.0017, 0.0009]))
    assert one_arm(np.array([[0.03, 0.03], [0.03, 0.03], [-0.01, -0.01]]))[0].min() == pytest.approx(-0.01 * np.sqrt(2))
    single = np.array([[-0.02], [0.01]])
    np.testing.assert_array_equal(one_arm(single)[0], single[:, 0])


def test_muscles_of_a_hip_of_two_axes_are_judged_once():
    made = creature_scene(small_in_space())
    scene = substitute(made, start_values(made))
    hips = [one for one in plausibility(scene, motion(scene)).crossings if one.joint == "lHip"]
    assert sorted(one.muscle for one in hips) == ["lBack", "lFront", "lInner", "lLong", "lOuter"]
    outer = next(one for one in hips if one.muscle == "lOuter")
    assert 0.01 < outer.least <= outer.greatest < outer.longest


def test_a_thigh_whose_knee_slides_as_it_bends_is_as_long_as_it_stands():
    """In gait2392 the knee's place in the thigh is a function of its angle, 0.40 m below the hip (Delp 1990)."""
    scene = load("gait2392_stand")
    longest = judge._length(scene, scene.character.joints["hip_l"], initial_pose(scene)[0])
    assert longest == pytest.approx(0.40, abs=0.01)
