"""Scenes as device arrays: start states, shapes, and one row an instance."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from biped import biped
from muscle_arm import arm
from warpmuscle.core.arrays import arrays_of
from warpmuscle.core.pose import about, multiply, rotate, twist_angle
from warpmuscle.formats import load
from warpmuscle.kernels.structs import HINGE, ROOT_FREE, UNIVERSAL
from warpmuscle.model.build import (
    PARTS,
    ModelInputs,
    ReferenceGait,
    build_model,
    muscles_model,
    replaced,
    start_of,
    update_model,
)
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import Actuation, Ground, InitialState, JointState, Motion, Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages

X, Y, Z = np.eye(3)


def scene_with(state: InitialState, root_joint: str = "free") -> Scene:
    character = biped()
    character.root_joint = root_joint
    return Scene("model", character, initial_state=state, ground=Ground(stiffness=0.0))


def motion_of(scene: Scene) -> dict[str, np.ndarray]:
    """Poses and velocities of the bodies at the start."""
    return {name: value[0].astype(float) for name, value in Stages(scene, 1, "cpu").forward_kinematics().items()}


def test_start_of_the_root_is_the_initial_state_with_a_unit_quaternion():
    state = InitialState((1.0, 2.0, 3.0), (0.0, 2.0, 0.0, 2.0), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0))
    start = start_of(scene_with(state), topology(biped()))
    np.testing.assert_allclose(start.coordinates[0, :7], [1.0, 2.0, 3.0, 0.0, 0.5**0.5, 0.0, 0.5**0.5])
    np.testing.assert_allclose(start.speeds[0, :6], [4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    assert np.all(start.speeds[0, 6:] == 0.0)


def test_heading_turns_orientation_and_velocities_about_the_vertical():
    tilted = multiply(about(Y, 2.0), about(X, 0.3))
    velocity, spin = np.array([0.1, 0.2, 1.0]), np.array([0.5, 0.6, 0.7])
    state = InitialState((1.0, 1.0, 0.0), tuple(tilted), tuple(velocity), tuple(spin), heading=0.5)
    start, turn = start_of(scene_with(state), topology(biped())), about(Y, 0.5 - 2.0)
    assert twist_angle(start.coordinates[0, 3:7], Y) == pytest.approx(0.5)
    np.testing.assert_allclose(start.coordinates[0, 3:7], multiply(turn, tilted), atol=1e-12)
    np.testing.assert_allclose(start.speeds[0, :6], [*rotate(turn, velocity), *rotate(turn, spin)], atol=1e-12)
    np.testing.assert_allclose(start.coordinates[0, :3], [1.0, 1.0, 0.0])


def test_joints_start_as_described():
    """The kinematics give back the relative orientation and angular velocity of every kind of joint."""
    ankle = multiply(about(Z, 0.2), about(X, -0.4))
    ankle_rate = 0.5 * rotate(about(Z, 0.2), X) - 0.3 * Z
    given = {
        "lHip": JointState(tuple(about(X, -0.5)), (0.1, 0.2, 0.3)),
        "lKnee": JointState(tuple(about(X, 0.7)), (2.0, 0.0, 0.0)),
        "lAnkle": JointState(tuple(ankle), tuple(ankle_rate)),
    }
    scene = scene_with(InitialState(joints=given))
    now, names = motion_of(scene), topology(scene.character)
    for joint, state in given.items():
        child = names.body_of_joint(joint)
        parent = names.parents[child]
        expected = multiply(now["orientation"][parent], state.orientation)
        assert abs(expected @ now["orientation"][child]) == pytest.approx(1.0, abs=1e-6)
        relative = now["angular_velocity"][child] - now["angular_velocity"][parent]
        np.testing.assert_allclose(relative, rotate(now["orientation"][parent], state.angular_velocity), atol=1e-6)


@pytest.mark.parametrize(("root_joint", "moves"), [("planar", 1.0), ("fixed", 0.0)])
def test_a_root_that_is_not_free_starts_as_far_as_it_can_move(root_joint: str, moves: float):
    state = InitialState((1.0, 2.0, 3.0), tuple(about(X, 0.3)), (4.0, 5.0, 6.0), (7.0, 8.0, 9.0))
    now = motion_of(scene_with(state, root_joint))
    np.testing.assert_allclose(now["position"][0], [0.0 if moves else 1.0, 2.0, 3.0])
    assert abs(now["orientation"][0] @ about(X, 0.3)) == pytest.approx(1.0)
    np.testing.assert_allclose(now["velocity"][0], [0.0, 5.0 * moves, 6.0 * moves])
    np.testing.assert_allclose(now["angular_velocity"][0], [7.0 * moves, 0.0, 0.0])


def test_numbers_that_all_instances_share_are_stored_once():
    scene = scene_with(InitialState())
    scene.character.bodies["torso"].mass = np.array([20.0, 22.0, 24.0])
    names = topology(scene.character)
    skeleton = build_model(scene, structure_of(scene), "cpu").skeleton
    np.testing.assert_allclose(skeleton.row.numpy()["mass"][:, names.bodies.index("torso")], [20.0, 22.0, 24.0])
    assert skeleton.limits.shape == (1, 15)
    np.testing.assert_allclose(skeleton.total_mass.numpy()[:, 0], [70.4 - 2.5, 70.4 - 0.5, 70.4 + 1.5], rtol=1e-6)


def test_only_a_model_with_prescribed_joints_has_their_curves():
    free = arm()
    moved = arm(actuation={"elbow": Actuation("kinematic")}, motion={"elbow": Motion([0.0, 0.5, 2.0], [0.0, 0.3, 0.1])})
    curves = {
        name: build_model(scene, structure_of(scene), "cpu").motion for name, scene in (("f", free), ("m", moved))
    }
    assert curves["m"].angle.shape == (1, 3)
    assert curves["f"].angle is None or len(curves["f"].angle) == 0


def test_starts_may_differ_by_instance():
    state = InitialState((0.0, np.array([1.0, 2.0]), 0.0), joints={"lKnee": JointState((0.1, 0.0, 0.0, 1.0))})
    start = start_of(scene_with(state), topology(biped()))
    np.testing.assert_allclose(start.coordinates[:, 1], [1.0, 2.0])
    assert np.array_equal(start.coordinates[0, 2:], start.coordinates[1, 2:])


def test_bodies_hang_on_their_joints():
    """In the reference pose a body's centre of mass is where the joint positions of the scene put it."""
    scene = scene_with(InitialState((0.0, 1.0, 0.0)))
    now, names = motion_of(scene), topology(scene.character)
    for name, joint in scene.character.joints.items():
        child, parent = names.body_of_joint(name), names.bodies.index(joint.parent)
        offset = np.array(joint.position_in_parent) - joint.position_in_child
        np.testing.assert_allclose(now["position"][child] - now["position"][parent], offset, atol=1e-6)
    mass = np.array([scene.character.bodies[body].mass for body in names.bodies])
    np.testing.assert_allclose(now["com"][0], mass @ now["position"] / mass.sum(), atol=1e-6)


def test_model_of_a_shipped_scene_names_its_parts():
    scene = load("iwalk")
    names = topology(scene.character)
    model = build_model(scene, structure_of(scene), "cpu")
    plan = model.skeleton.plan.numpy()
    kinds = dict(zip(names.bodies, plan["joint_type"], strict=True))
    assert (kinds["pelvis"], kinds["lLowerleg"], kinds["lFoot"]) == (ROOT_FREE, HINGE, UNIVERSAL)
    assert names.bodies[model.feet.left] == "lFoot"
    assert names.bodies[model.simbicon.right_hip] == "rUpperleg"
    slots = {body: slot for body, slot in zip(names.bodies, plan["foot_slot"], strict=True) if slot >= 0}
    assert set(slots) == {"lFoot", "lToes", "rFoot", "rToes"}
    assert plan["end_point"][-1] == 3 * 1 + 8 * 2 + 2 * 8 + 2  # spheres, capsules, boxes, toes


def shipped(name: str) -> Scene:
    """A shipped scene with numbers in place of its free parameters."""
    return substitute(load(name), start_values(load(name)))


def values_of(model) -> list[bytes]:
    return [array.numpy().tobytes() for array in arrays_of(model)]


def test_parts_made_again_from_other_numbers_are_those_of_a_new_model():
    scene = load("walk56_search")
    structure, low = structure_of(scene), start_values(scene)
    first, second = (substitute(scene, values) for values in (low, low * 1.01))
    model = build_model(first, structure, "cpu")
    assert values_of(model) != values_of(build_model(second, structure, "cpu"))
    update_model(model, PARTS, second, structure, "cpu")
    assert values_of(model) == values_of(build_model(second, structure, "cpu"))
    update_model(model, ["controller"], first, structure, "cpu")
    changed = [a != b for a, b in zip(values_of(model), values_of(build_model(second, structure, "cpu")), strict=True)]
    of_controller = values_of(build_model(first, structure, "cpu").simbicon)
    assert any(changed)
    assert values_of(model.simbicon) == of_controller
    assert sum(changed) <= len(of_controller)


def test_a_slope_turns_the_normal_of_each_instance_and_nothing_else():
    scene = shipped("fwalk")
    structure, slope = structure_of(scene), np.array([0.0, 0.1, -0.2])
    level, tilted = (build_model(scene, structure, "cpu", ModelInputs(slope=given)) for given in (None, slope))
    assert level.contacts.normal.shape == (1, 1)
    upright = np.stack([np.zeros(3), np.cos(slope), -np.sin(slope)], axis=1)
    np.testing.assert_allclose(tilted.contacts.normal.numpy()[:, 0], upright, atol=1e-7)
    tilted.contacts.normal = level.contacts.normal
    assert values_of(tilted) == values_of(level)


def test_a_reference_has_its_bins_for_each_stance():
    scene = shipped("fwalk")
    structure = structure_of(scene)
    bodies = len(structure.names.bodies)
    gait = ReferenceGait(np.tile([0.0, 0.0, 0.0, 1.0], (2 * 7, bodies, 1)), np.ones(bodies), by_contact=True)
    model = build_model(scene, structure, "cpu", ModelInputs(reference=gait))
    assert (model.reference_bins, model.reference_by_contact, model.reference.shape) == (7, 1, (14, bodies))


def test_replaced_fields_come_back_after_an_error_too():
    scene, walk = shipped("elbow_open_loop"), shipped("walk56")
    model = build_model(scene, structure_of(scene), "cpu")
    before, count = values_of(model), model.muscles.count
    other = {"muscles.count": 7, "paths": build_model(walk, structure_of(walk), "cpu").paths}
    within = []

    def fail() -> None:
        with replaced(model, other):
            within.append((model.muscles.count, values_of(model) == before))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert within == [(7, False)]
    assert (model.muscles.count, values_of(model)) == (count, before)


def test_a_model_of_muscles_has_those_that_are_named():
    scene = shipped("walk56")
    names = tuple(scene.character.muscles)[3:5]
    model = muscles_model(scene, names, "cpu")
    assert (model.muscles.count, model.body_count) == (2, 0)
    expected = [scene.character.muscles[name].f_max for name in names]
    np.testing.assert_allclose(model.muscles.row.numpy()["f_max"][0], expected)


# What files that write fields of something called so have in a line; others are not parsed.
WRITES = re.compile(r"\b_?model\b[^\n=]*\.\w+[^\n=]*=(?!=)|\bsetattr\b")


def written_models(file: Path) -> Iterator[str]:
    """Places in a file that write fields of a device model."""
    text = file.read_text()
    for node in ast.walk(ast.parse(text)) if WRITES.search(text) else ():
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AugAssign) else []
        )
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "setattr":
            targets = [ast.Attribute(node.args[0], "field", ast.Store())]
        for target in (part for whole in targets for part in (whole.elts if isinstance(whole, ast.Tuple) else [whole])):
            owner = ast.walk(target.value) if isinstance(target, ast.Attribute) else ()
            if any(getattr(part, "id", getattr(part, "attr", "")) in ("model", "_model") for part in owner):
                yield f"{file.name}:{node.lineno}: {ast.unparse(target)}"


def test_nothing_but_the_builder_writes_the_model():
    package = Path(__file__).parents[2] / "warpmuscle"
    builder = package / "model" / "build.py"
    assert len(list(written_models(builder))) == 1  # so that the test sees what it looks for
    assert [place for file in package.rglob("*.py") if file != builder for place in written_models(file)] == []
