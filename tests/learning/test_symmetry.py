"""Mirror images of observations and actions: twice is nothing, and a body moves as its image does."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.learning import EpisodeBatch, Sense, Task, Variation
from warpmuscle.learning.senses import GROUPS
from warpmuscle.scene import Character, Joint
from warpmuscle.scene.displacement import Displacement
from warpmuscle.scene.joints.symmetry import QUATERNION, TURN, VECTOR, is_symmetric, joint_image
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

STILL = Variation(velocity_noise=0.0)
SEEN = ("trunk", "trunk_speed", "head", "coordinates", "speeds", "foot_force", "activation", "fibre_length",
        "fibre_velocity", "tendon_force", "command", "action", "phase")  # fmt: skip


def put_image(rollout: Rollout) -> None:
    """Let the second instance be the image of the first one."""
    q, v = (array.numpy() for array in (rollout.state.coordinates, rollout.state.speeds))
    q[1, :7] = np.concatenate([q[0, :3] * VECTOR, q[0, 3:7] * QUATERNION])
    v[1, :6] = np.concatenate([v[0, :3] * VECTOR, v[0, 3:6] * TURN])
    for names, values, kind in ((rollout.coordinate_names, q, "coordinates"), (rollout.speed_names, v, "speeds")):
        for joint in rollout.names.joints:
            image = joint_image(rollout.numeric.character, joint)
            mine, theirs = (
                [k for k, name in enumerate(names) if name.split(".")[0] == one] for one in (joint, image.name)
            )
            values[1, mine] = values[0, theirs] * getattr(image, kind)
    rollout.state.coordinates.assign(q)
    rollout.state.speeds.assign(v)


def batch_of(**task: object) -> EpisodeBatch:
    """Two bodies whose shoulders, unlike those of walk56, have the same gains."""
    observations = {name: Sense(delay=0.005) for name in SEEN}
    scene = load("walk56")
    assert scene.controller is not None
    pd = scene.controller.pd
    even = {**pd, "rShoulder": msgspec.structs.replace(pd["rShoulder"], scale=pd["lShoulder"].scale)}
    scene = msgspec.structs.replace(scene, controller=msgspec.structs.replace(scene.controller, pd=even))
    wanted = Task(symmetric=True, observations=observations, variation=STILL, **task)
    return EpisodeBatch(scene, 2, "cpu", wanted, threads=1)


@pytest.mark.parametrize("actions", ["excitation", "joint_targets"])
def test_the_image_of_a_body_that_acts_as_the_image_of_another_moves_as_its_image(actions: str):
    assert set(SEEN) == set(GROUPS) - {"clock", "goal", "ground", "ground_behind", "footing"}
    batch = batch_of(actions=actions)
    images, random = batch.images, np.random.default_rng(3)
    assert images is not None
    state = batch.rollout.state
    v = state.speeds.numpy()
    v[0] += random.normal(0.0, 0.3, v.shape[1])
    state.speeds.assign(v)
    put_image(batch.rollout)
    heading, stance = batch.episodes.heading.numpy(), state.simbicon.stance.numpy()
    batch.episodes.command.assign(np.array([[1.1, 0.3], [1.1, -0.3]], dtype=np.float32))
    batch.episodes.heading.assign(heading * [1.0, -1.0])
    state.simbicon.stance.assign(np.array([stance[0], 1 - stance[0]]))
    for _ in range(4):
        action = random.normal(0.0, 0.4, (1, len(batch.actions.names)))
        batch.actions.requested.assign(np.concatenate([action, images.action.of(action)]).astype(np.float32))
        batch.step()
    for row, image in ((batch.senses.observation, images.observation), (batch.senses.critic, images.critic)):
        seen = row.numpy().astype(float)
        assert np.abs(seen[0]).max() > 0.5
        np.testing.assert_allclose(image.of(seen[0]), seen[1], atol=0.01)
        assert np.abs(seen[0] - seen[1]).max() > 0.2  # it is not its own image
    np.testing.assert_allclose(*batch.judge.gains.reward.numpy(), rtol=0.05)


def test_an_image_of_an_image_is_what_it_was():
    images = batch_of(actions="joint_targets").images
    assert images is not None
    for image in images:
        values = np.random.default_rng(1).normal(size=(5, len(image.place)))
        np.testing.assert_allclose(image.of(image.of(values)), values, atol=1e-6)


def test_an_imported_model_has_images():
    character = load("gait2392_walk").character
    images = {name: joint_image(character, name) for name in character.joints}
    assert images["knee_angle_r"].name == "knee_angle_l"
    assert {image.name for image in images.values()} == set(character.joints)


def test_who_is_not_like_his_image_is_refused():
    scene = load("walk56")
    muscles = scene.character.muscles
    weak = msgspec.structs.replace(muscles["lSOL"], f_max=1000.0)
    character = msgspec.structs.replace(scene.character, muscles={**muscles, "lSOL": weak})
    one_sided = msgspec.structs.replace(scene, character=character)
    with pytest.raises(SceneError, match="is not like its image 'rSOL'") as caught:
        EpisodeBatch(one_sided, 1, "cpu", Task(symmetric=True), threads=1)
    assert caught.value.key == "character.muscles.lSOL"


def test_a_joint_that_moves_otherwise_than_its_counterpart_is_refused():
    character = load("gait2392_walk").character
    joint = character.joints["ankle_angle_l"]
    turned = msgspec.structs.replace(joint, axes=[(1.0, 0.5, 0.0)])
    other = msgspec.structs.replace(character, joints={**character.joints, "ankle_angle_l": turned})
    with pytest.raises(SceneError, match="does not move as the mirror image of 'ankle_angle_r'"):
        joint_image(other, "ankle_angle_l")


@pytest.mark.parametrize(("scene", "even"), [("walk56", True), ("gait2392_walk", True), ("throw18", False)])
def test_a_body_is_symmetric_if_some_of_it_is_on_two_sides_that_are_alike(scene: str, even: bool):
    loaded = load(scene)
    assert is_symmetric(substitute(loaded, start_values(loaded)).character) is even


def with_kneecaps(slope_of_the_right: float) -> Character:
    """The legs of an imported model, with kneecaps that follow the knees as those of Rajagopal2016 do."""
    character = load("gait2392_walk").character
    bodies, joints = dict(character.bodies), dict(character.joints)
    for side, slope in (("l", 0.5), ("r", slope_of_the_right)):
        bodies[f"patella_{side}"] = bodies[f"toes_{side}"]
        joints[f"knee_angle_{side}_beta"] = Joint(
            "coupled", f"femur_{side}", f"patella_{side}", (0.0, -0.2, 0.05), (0.0, 0.0, 0.0),
            rotations=[Displacement((1.0, 0.0, 0.0), slope=slope)], follows=f"knee_angle_{side}",
        )  # fmt: skip
    return msgspec.structs.replace(character, bodies=bodies, joints=joints)


def test_a_kneecap_that_follows_a_knee_has_the_other_one_as_its_image():
    image = joint_image(with_kneecaps(0.5), "knee_angle_r_beta")
    assert image.name == "knee_angle_l_beta"
    assert len(image.coordinates) == len(image.speeds) == 0
    with pytest.raises(SceneError, match="does not move as the mirror image of 'knee_angle_r_beta'"):
        joint_image(with_kneecaps(-0.5), "knee_angle_l_beta")
    swapped = with_kneecaps(0.5)
    swapped.joints["knee_angle_l_beta"] = msgspec.structs.replace(
        swapped.joints["knee_angle_l_beta"], follows="knee_angle_r"
    )
    with pytest.raises(SceneError, match="does not move as the mirror image"):
        joint_image(swapped, "knee_angle_l_beta")


def test_a_joint_that_follows_two_others_has_the_image_that_follows_theirs():
    character = with_kneecaps(0.5)
    for side in "lr":
        name = f"knee_angle_{side}_beta"
        character.joints[name] = msgspec.structs.replace(
            character.joints[name], rotations=[],
            translations=[Displacement((0.0, 0.0, 1.0), terms=[(0.02, 1, 1), (0.01, 2, 0)])],
            beside=f"ankle_angle_{side}",
        )  # fmt: skip
    assert joint_image(character, "knee_angle_l_beta").name == "knee_angle_r_beta"
    other = character.joints["knee_angle_r_beta"]
    character.joints["knee_angle_r_beta"] = msgspec.structs.replace(other, beside="ankle_angle_l")
    with pytest.raises(SceneError, match="does not move as the mirror image"):
        joint_image(character, "knee_angle_l_beta")
