"""Bushings between two bodies accelerate them as OpenSim's do; expressions are read as straight functions, or told."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.osim.expressions import NotStraight, straight
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import Force, Scene
from warpmuscle.scene.expressions.parse import NESTED
from warpmuscle.scene.opensim_root import root_motion
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*centre of mass starts"), pytest.mark.usefixtures("unoptimized_kernels")
]  # fmt: skip

FIRST, SECOND = ("a1", "a2", "a3", "x1", "x2", "x3"), ("b1", "b2", "b3", "y1", "y2", "y3")
Q = (0.1, 0.2, 0.3, 0.05, 0.06, -0.07, 0.3, -0.1, 0.25, 0.12, 0.03, -0.02)
RATE = (0.5, -0.3, 0.2, 0.1, 0.2, -0.1, -0.4, 0.6, 0.1, 0.3, -0.2, 0.4)
DAMPING = "<rotational_damping>0.5 0.6 0.7</rotational_damping><translational_damping>5 6 7</translational_damping>"
BUSHING = (
    "<rotational_stiffness>10 20 30</rotational_stiffness>"
    "<translational_stiffness>1000 2000 3000</translational_stiffness>"
)
EXPRESSIONS = (
    "<Mx_expression>10*theta_x+3*theta_y</Mx_expression><Fy_expression>2000*delta_y-5*(theta_z-0.1)</Fy_expression>"
)
OPENSIM = {  # the force, and accelerations of the second joint's coordinates in OpenSim 4.6, rad/s^2 and m/s^2
    "BushingForce": (BUSHING, (53.9208, -36.7287, 117.2306, 59.4417, -127.6083, 167.8471)),
    "ExpressionBasedBushingForce": (EXPRESSIONS, (-24.7371, -8.9826, 39.4072, 31.8306, -108.7553, -23.6809)),
}


def bushing(kind: str, inner: str) -> str:
    frames = "".join(
        f'<PhysicalOffsetFrame name="f{k}"><socket_parent>/bodyset/{body}</socket_parent>'
        f"<translation>{place}</translation><orientation>{turn}</orientation></PhysicalOffsetFrame>"
        for k, body, place, turn in (
            (1, "one", "0.1 0.02 0.03", "0.2 -0.1 0.3"),
            (2, "two", "-0.05 0.04 0.01", "0.1 0.2 -0.2"),
        )
    )
    return (
        f'<{kind} name="bush"><socket_frame1>f1</socket_frame1><socket_frame2>f2</socket_frame2>'
        f"<frames>{frames}</frames>{inner}{DAMPING}</{kind}>\n"
    )


def scene_of(folder: Path, force: str) -> tuple[Scene, list[Ignored]]:
    bodies = small.body("one", 1.0, "0.01 0.02 -0.03", "0.1 0.2 0.3 0 0 0")
    bodies += small.body("two", 2.0, "0.02 -0.01 0.03", "0.3 0.2 0.1 0 0 0")
    joints = small.joint_of_six("j1", "ground", "one", FIRST) + small.joint_of_six("j2", "one", "two", SECOND)
    ignored: list[Ignored] = []
    return load(small.written(folder, small.model(bodies, joints, force)), ignored=ignored), ignored


@pytest.mark.parametrize("kind", OPENSIM)
def test_bodies_accelerate_as_in_opensim(tmp_path: Path, kind: str):
    inner, expected = OPENSIM[kind]
    scene, _ = scene_of(tmp_path, bushing(kind, inner))
    scene = loads(dumps(msgspec.structs.replace(scene, time_step=1e-4, duration=1e-3)))
    rollout = Rollout(scene, 1, "cpu")
    assert scene.opensim is not None
    root, names = root_motion(scene.opensim, np.array([Q[:6]])), rollout.names
    coordinates, speeds = rollout.state.coordinates.numpy().copy(), rollout.state.speeds.numpy().copy()
    coordinates[0, :7] = np.concatenate([root.position[0], root.orientation[0]])
    speeds[0, :6] = RATE[:6] @ np.concatenate([root.moving, root.turning], axis=2)[0]
    own = [names.body_of_joint(word) for word in SECOND]
    coordinates[0, [names.coordinate_start[body] for body in own]] = Q[6:]
    speeds[0, [names.speed_start[body] for body in own]] = RATE[6:]
    rollout.state.coordinates.assign(coordinates)
    rollout.state.speeds.assign(speeds)
    rollout.step(1)
    found = (rollout.state.speeds.numpy() - speeds)[0, [names.speed_start[body] for body in own]] / 1e-4
    np.testing.assert_allclose(found, expected, atol=3e-3)


def test_bushing_that_is_not_understood_is_left_out_and_told(tmp_path: Path):
    expression = "<Mz_expression>5*theta_w^3</Mz_expression>"
    scene, ignored = scene_of(tmp_path, bushing("ExpressionBasedBushingForce", expression))
    assert not scene.forces
    assert any("'theta_w' is not known" in note.reason and "holds nothing" in note.reason for note in ignored)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0", [0, 0, 0, 0, 0, 0, 0]),
        (" -2.5e1 * theta_x", [0, -25, 0, 0, 0, 0, 0]),
        ("-(delta_z - 3)*4/2 + theta_y", [6, 0, 1, 0, 0, 0, -2]),
    ],
)
def test_expressions_are_sums_products_and_quotients(text: str, value: list[float]):
    assert straight(text).tolist() == value


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("theta_x*theta_y", "multiplies variables"), ("1/theta_x", "divides by a variable"), ("1/0", "or by 0"),
        ("exp(theta_x)", "'exp' is not a sum, product or quotient"), ("(1", "not closed"),
        ("1 2", "'2' is not understood"),
        ("", "is empty"), ("2*", "ends too early"), ("__import__", "is not known; it may be of"),
        ("9" * 3000, "characters"),
        ("(" * (NESTED + 5), "parentheses"), ("1e308*1e308", "beyond"),
    ],
)  # fmt: skip
def test_other_expressions_are_refused_with_a_reason(text: str, message: str):
    with pytest.raises(NotStraight, match=message):
        straight(text)


def test_bushing_needs_another_body(tmp_path: Path):
    scene, _ = scene_of(tmp_path, bushing("BushingForce", BUSHING))
    for other, message in (
        ("", "name the other one"),
        ("one", "between two different bodies"),
        ("tow", "did you mean 'two'"),
    ):
        force = msgspec.structs.replace(scene.forces["bush"], other_body=other)
        with pytest.raises(SceneError, match=message):
            check_scene(msgspec.structs.replace(scene, forces={"bush": force}))
    drag = Force("air_drag", body="one", other_body="two", parameters={"drag_area": 1.0, "density": 1.2})
    with pytest.raises(SceneError, match="acts on one thing only"):
        check_scene(msgspec.structs.replace(scene, forces={"drag": drag}))
