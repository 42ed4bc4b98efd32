"""Explicit damping beside the step: inertia as the device has it, the bound of joints and scenes, what is said."""

import numpy as np
import pytest
from msgspec.structs import replace

from muscle_arm import ABOUT_JOINT, arm
from warpmuscle import Rollout
from warpmuscle.core.shipped import is_scene, scenes_folder
from warpmuscle.formats import load
from warpmuscle.scene import Actuation, Controller, Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.damping import damping_warnings, explicit_damping, mass_matrix
from warpmuscle.simulation.stages import Stages

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


def test_inertia_at_the_start_is_that_of_the_device():
    for name in ("walker16", "gait2392"):  # a planar and a free root, and coupled joints with patellae
        scene = at_start(load(name))
        device = Stages(scene, 1, "cpu").mass_matrix()[0].astype(float)
        np.testing.assert_allclose(mass_matrix(scene), device, atol=2e-5 * np.abs(device).max())


def held(kind: str, share: float, **changes: object) -> Scene:
    """A joint on a fixed root, whose damping over a step is a share of the inertia that hangs on it."""
    gains = {"others": {"kp": 0.0, "kd": share * ABOUT_JOINT / 0.002, "angle": 0.0}}
    scene = arm(kind, actuation={"elbow": Actuation("torque")}, controller=Controller(type="joint_pd", by_joint=gains))
    scene.character.muscles.clear()
    scene.time_step = 0.002
    return replace(scene, **changes)


def test_the_share_of_a_joint_is_damping_times_step_over_its_inertia():
    """Of a ball about the axis of its smallest inertia. `test_joint_pd` shows that speeds grow beyond 1."""
    (one,) = explicit_damping(held("hinge", 0.7))
    assert (one.joint, one.key) == ("elbow", "controller.by_joint.others.kd")
    assert one.share == pytest.approx(0.7, rel=1e-5)
    (ball,) = explicit_damping(held("ball", 0.7))
    assert ball.share == pytest.approx(0.7 * ABOUT_JOINT / 0.01, rel=1e-5)
    assert explicit_damping(held("hinge", 0.7, implicit_pd=True)) == []


def test_what_is_too_stiff_is_told_with_its_key_and_what_to_do():
    assert damping_warnings(held("hinge", 0.99)) == []
    (doubt,) = damping_warnings(held("hinge", 1.25))
    assert doubt.key == "controller.by_joint.others.kd"
    assert doubt.message == (
        "steps of 0.002 s are too long for the damping of elbow, which is explicit: its speed may grow from step to "
        "step until the run diverges; set implicit_pd = true, or take steps of 0.0016 s"
    )


def sprung(share: float, **changes: object) -> Scene:
    """A joint with a damper that takes a share of what hangs on it in a step."""
    scene = arm("hinge", actuation={"elbow": Actuation("passive", 0.0, share * ABOUT_JOINT / 0.002)})
    scene.time_step, scene.gravity = 0.002, 0.0
    return replace(scene, **changes)


def test_a_spring_in_a_joint_is_told_where_its_speed_grows_and_only_there():
    for share, grows in ((1.9, False), (2.1, True)):
        scene = sprung(share)
        (one,) = explicit_damping(scene)
        assert (one.joint, one.key) == ("elbow", "actuation.elbow.damping")
        assert one.share == pytest.approx(share / 2.0, rel=1e-5)
        assert len(damping_warnings(scene)) == grows
        rollout = Rollout(scene, 1, "cpu")
        rollout.state.speeds.assign(np.ones((1, 1), dtype=np.float32))
        rollout.step(40)
        assert (abs(rollout.state.speeds.numpy()[0, 0]) > 1.0) == grows


def test_springs_that_are_implicit_and_joints_that_torques_drive_are_none_of_these():
    assert explicit_damping(sprung(2.1, implicit_pd=True)) == []
    scene = sprung(2.1)
    assert explicit_damping(replace(scene, muscle_model=replace(scene.muscle_model, implicit_damping=True))) == []
    assert (
        explicit_damping(replace(scene, actuation={"elbow": replace(scene.actuation["elbow"], drive="torque")})) == []
    )


def test_hips_of_the_walking_controller_need_implicit_damping():
    """Its gains are relative: kd m g L sqrt(L/g); the lightest turn of a leg is that about its own length."""
    scene = at_start(replace(load("steer"), implicit_pd=False))
    hips = [one for one in explicit_damping(scene) if one.joint.endswith("Hip")]
    assert all(1.0 < one.share < 1.2 for one in hips)
    # Both are alike but for rounding.
    assert damping_warnings(scene)[0].key in {f"controller.by_joint.{side}Hip.kd" for side in "lr"}


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_simbicon_damps_about_axes_by_their_scale_and_bears_twice_as_much(scale: float):
    scene = at_start(load("fwalk"))
    before = {one.joint: one.share for one in explicit_damping(scene)}
    scene.controller.pd["lToeJoint"].scale = (scale, 1.0, 1.0)
    knee = scene.controller.pd["lKnee"]
    scene.controller.pd["lKnee"] = replace(knee, kd=3.0 * knee.kd)
    after = {one.joint: one.share for one in explicit_damping(scene)}
    assert after["lKnee"] == pytest.approx(3.0 * before["lKnee"], rel=1e-6)
    assert after["rKnee"] == pytest.approx(before["rKnee"], rel=1e-9)


def test_which_scenes_are_near_the_bound():
    """No shipped scene is beyond it, as `test_start` shows. Ankles of `fwalk` are near it, as its feet swing."""
    shares = {}
    for path in [path for folder in ("torques", "worlds", "terrain") for path in scenes_folder().glob(f"{folder}/*")]:
        if is_scene(path):
            found = [one.share for one in explicit_damping(at_start(load(path.stem)))]
            shares[path.stem] = max(found, default=0.0)
    near = {name for name, share in shares.items() if share > 0.6}
    assert near == {f"fwalk{kind}" for kind in ("", "_ball", "_box", "_bumps", "_treadmill", "_water")}
    assert max(shares.values()) < 0.85
