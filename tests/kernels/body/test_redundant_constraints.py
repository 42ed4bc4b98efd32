"""Constraints that hold what joints hold anyhow: the motion is that without them, whichever way the model is turned."""

import copy
from itertools import pairwise

import numpy as np
import pytest

from reduced_tree import energy
from warpmuscle.core.pose import about, conjugate, multiply, normalized, rotate
from warpmuscle.scene import Body, Character, Constraint, Failure, Ground, Joint, JointState, Scene
from warpmuscle.scene.constraints.pose import bodies_at, meeting_speeds, start_coordinates
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
ANGLES, OUT = {"ja": -0.5, "jb": -0.3, "jc": 0.4}, 0.02  # rad; m, of the slide
RATE = 2.0  # rad/s
YAWS = [about(Y, angle) for angle in (0.0, 0.3, 0.785, 2.0)]
ANY = [normalized(np.array(turn)) for turn in ((0.0, 0.0, 0.0, 1.0), (0.1, -0.1, 0.6, 0.1), (-0.5, 0.4, 1.3, 0.9))]


def clipped(joint: Joint, kind: str = "", axis: tuple[float, float, float] = X) -> Scene:
    """An arm of two links and a clip on the second one, by a joint and a constraint; and a third link of its own."""
    bodies = {
        name: Body(mass, (0.02 * mass, 0.03 * mass, 0.01 * mass))
        for name, mass in {"base": 1.0, "a": 1.2, "b": 0.8, "clip": 0.3, "c": 0.5}.items()
    }
    joints = {
        "ja": Joint("hinge", "base", "a", (0.0, 0.1, 0.0), (0.0, 0.2, 0.0), [X]),
        "jb": Joint("hinge", "a", "b", (0.0, -0.2, 0.0), (0.0, 0.2, 0.0), [axis]),
        "clip": joint,
        "jc": Joint("hinge", "base", "c", (0.1, 0.1, 0.3), (0.0, 0.2, 0.0), [axis]),
    }
    character = Character("base", bodies, joints, "fixed")
    scene = Scene("clip", character, ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))
    scene.duration, scene.time_step = 0.5, 1.0 / 2000.0
    for name, angle in ANGLES.items():
        along = normalized(np.array(joints[name].axes[0]))
        scene.initial_state.joints[name] = JointState(tuple(map(float, about(along, angle))), tuple(RATE * along))
    if joint.type != "fixed":
        scene.initial_state.joints["clip"] = JointState(coordinate=OUT if joint.type == "slide" else 0.0)
    if kind:
        hold(scene, kind)
    return scene


def hold(scene: Scene, kind: str) -> None:
    """Hold the clip to the second link where it starts; speeds of it that this allows are none."""
    character, names = scene.character, topology(scene.character)
    q = start_coordinates(scene, names)
    (place, turn), (other, other_turn) = (bodies_at(character, names, q)[name] for name in ("clip", "b"))
    here = rotate(conjugate(other_turn), place - other)[0]
    beside = here + np.array([0.04, 0.08, 0.03]) if kind == "distance" else here
    character.constraints["held"] = Constraint(
        kind, "clip", "b", other_position=tuple(map(float, beside)), axis=(0.6, 0.1, 0.4),
        other_orientation=tuple(map(float, multiply(conjugate(other_turn), turn)[0])),
        distance=float(np.linalg.norm(beside - here)),
    )  # fmt: skip
    single = [names.coordinates_of(names.body_of_joint(name)).start for name in scene.initial_state.joints]
    v = meeting_speeds(character, names, q, single, np.full(len(single), RATE))
    np.testing.assert_allclose(v[: len(ANGLES)], RATE, atol=1e-6)


def runs(scene: Scene, turns: list[np.ndarray], gravity: float = 9.8) -> tuple[np.ndarray, float]:
    """Angles of the links (turns, frames, 3) where the base is turned, and by how much of it energy changes."""
    scene, names = copy.deepcopy(scene), topology(scene.character)
    scene.gravity = gravity
    places = [names.coordinates_of(names.body_of_joint(name)).start for name in ANGLES]
    found, lost = [], 0.0
    for turn in turns:
        scene.initial_state.root_orientation = tuple(map(float, turn))
        rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=50.0)
        rollout.run()
        assert rollout.status_names() == ("completed",)
        q, v = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))
        found.append(q[:, places])
        both = energy(scene, q, v)
        lost = max(lost, np.ptp(both.sum(axis=0)) / both[0].max())
    return np.array(found), lost


SLIDE = Joint("slide", "b", "clip", (0.0, -0.1, 0.02), (0.0, 0.03, 0.01), [Y])
HINGE = Joint("hinge", "b", "clip", (0.0, -0.1, 0.02), (0.0, 0.03, 0.01), [X])
FIXED = {
    "slide": Joint("fixed", "b", "clip", (0.0, -0.1 + OUT, 0.02), (0.0, 0.03, 0.01)),
    "hinge": Joint("fixed", "b", "clip", (0.0, -0.1, 0.02), (0.0, 0.03, 0.01)),
}


@pytest.mark.parametrize("joint", [SLIDE, HINGE])
def test_a_clip_that_is_held_moves_as_one_that_is_fixed(joint: Joint):
    """In planes along world axes and between, so that a slide comes to lie across them; in shorter steps, too."""
    for axis in (X, (0.3, 0.2, 1.0)):
        scene, other = clipped(joint, "weld", axis), clipped(FIXED[joint.type], axis=axis)
        right, _ = runs(other, YAWS[:1])
        assert np.ptp(right, axis=1).max() > 1.0
        found, lost = runs(scene, YAWS)
        np.testing.assert_allclose(found, np.repeat(right, len(YAWS), axis=0), atol=5e-5)
        assert lost < 1e-4
    scene.time_step = other.time_step = 2.5e-5
    scene.duration = other.duration = 0.04
    right, _ = runs(other, YAWS[:1])
    found, _ = runs(scene, YAWS[:2])
    np.testing.assert_allclose(found, np.repeat(right, 2, axis=0), atol=5e-6)


def test_a_turned_model_without_weight_moves_as_it_would():
    found, lost = runs(clipped(SLIDE, "weld", (0.3, 0.2, 1.0)), ANY, gravity=0.0)
    for one, other in pairwise(found):
        np.testing.assert_allclose(one, other, atol=2e-5)
    assert lost < 1e-4
