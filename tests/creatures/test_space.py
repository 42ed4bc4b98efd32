"""Creatures that move in space: hips of two axes, balance to the sides, and what a search may not find."""

import msgspec
import numpy as np
import pytest

from small_creature import small_creature, small_in_space
from warpmuscle.core.errors import SceneError
from warpmuscle.creatures.build import OVERLAP, creature_scene
from warpmuscle.creatures.description import CreatureGait
from warpmuscle.creatures.gait import side_joints
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout

FLIP = np.array([-1.0, 1.0, 1.0])


def numeric(creature) -> Scene:
    made = creature_scene(creature)
    return substitute(made, start_values(made))


def test_hips_turn_to_both_sides_as_mirror_images():
    joints = creature_scene(small_in_space()).character.joints
    assert joints["lHip"].type == joints["rHip"].type == "universal"
    assert joints["lHip"].axes == [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    assert joints["lHip"].limits == [(-0.8, 0.6), (-0.3, 0.5)]
    assert joints["rHip"].limits == [(-0.8, 0.6), (-0.5, 0.3)]
    assert joints["lAnkle"].type == "hinge"


def test_a_plane_creature_is_as_it_was_without_sides():
    scene = creature_scene(small_creature())
    assert scene.character.root_joint == "planar"
    assert scene.failure.self_collision == 0.0
    assert all(len(t.components) == 1 for t in scene.controller.states[0].trajectories.values())


def test_legs_in_space_are_placed_to_the_side_and_do_not_pass_through_each_other():
    scene = creature_scene(small_in_space())
    assert scene.character.root_joint == "free"
    assert (scene.failure.self_collision, len(scene.failure.self_collision_pairs)) == (OVERLAP, 4)
    hip = scene.controller.states[0].trajectories["SWING_Hip"]
    assert [component.axis for component in hip.components] == [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    aside = hip.components[1]
    assert (aside.reverse_on, aside.feedback.axis, aside.angle[0].value) == ("left", (1.0, 0.0, 0.0), 0.05)
    assert scene.objective.heading > 0.0
    assert side_joints(small_in_space()) == {"Hip"}


def test_a_hopper_places_both_legs_outwards_from_its_middle():
    creature = small_in_space()
    gait = CreatureGait(
        kind="hop", speed=1.0, time=0.3, hips="Hip", feet="Foot", swing={"Hip": [0.0]}, stance={"Hip": [0.0]},
        apart={"Hip": 0.1},
    )  # fmt: skip
    scene = creature_scene(msgspec.structs.replace(creature, gait=gait))
    air, ground = scene.controller.states
    assert air.balance.distance_x.value == [-0.1]  # its feet are 0.1 m from the middle
    values = substitute(scene, start_values(scene)).controller.states[0].trajectories
    assert [values[name].components[1].angle for name in ("lHip", "rHip")] == [[0.1], [-0.1]]
    left, right = (air.trajectories[name].components[1].feedback for name in ("lHip", "rHip"))
    assert right.cd.same_as.endswith("lHip.components.1.feedback.cd")
    assert left.axis == right.axis == (1.0, 0.0, 0.0)
    assert ground.trajectories["lHip"].components[1].feedback is None


@pytest.mark.usefixtures("unoptimized_test")
def test_a_start_to_the_other_side_on_the_other_leg_is_the_mirror_image():
    """Bodies, limits, muscles and balance of both sides are mirror images, or it would not be."""
    scene = numeric(small_in_space())
    start = msgspec.structs.replace(scene.initial_state, root_velocity=(0.2, 0.0, 1.0))
    other = msgspec.structs.replace(
        start, root_velocity=(-0.2, 0.0, 1.0), joints={"lHip": start.joints["rHip"], "rHip": start.joints["lHip"]}
    )
    ways = []
    for state, stance in ((start, "left"), (other, "right")):
        controller = msgspec.structs.replace(scene.controller, start_stance=stance)
        rollout = Rollout(
            changed_scene(scene, initial_state=state, controller=controller, duration=0.3), 1, "cpu", record=[0]
        )
        rollout.run()
        ways.append(rollout.recording(0).com)
    assert np.abs(ways[0][-1, 0]) > 0.02  # it does go to the side
    np.testing.assert_allclose(ways[1], ways[0] * FLIP, atol=2e-4)


def changed_scene(scene: Scene, **fields) -> Scene:
    return msgspec.structs.replace(scene, **fields)


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"side": (0.3, -0.3)}, "segments.Leg.side", "low 0.3 is greater than high -0.3"),
        ({"side": (0.1, 0.3)}, "segments.Leg.side", "the standing pose, 0"),
        ({"range": None}, "segments.Leg.side", "turns about x, too"),
    ],
)
def test_what_is_wrong_with_a_side_is_said(change, key, words):
    creature = small_in_space()
    creature.segments["Leg"] = msgspec.structs.replace(creature.segments["Leg"], **change)
    with pytest.raises(SceneError) as caught:
        creature_scene(creature)
    assert caught.value.key == key
    assert words in str(caught.value)


def test_only_what_moves_in_space_turns_to_its_sides():
    creature = msgspec.structs.replace(small_in_space(), spatial=False)
    with pytest.raises(SceneError, match="spatial = true") as caught:
        creature_scene(creature)
    assert caught.value.key == "segments.Leg.side"


def test_only_joints_with_sides_are_held_apart():
    creature = small_in_space()
    creature.gait.apart = {"Ankle": 0.1}
    with pytest.raises(SceneError, match="no joint with a side") as caught:
        creature_scene(creature)
    assert caught.value.key == "gait.apart.Ankle"
