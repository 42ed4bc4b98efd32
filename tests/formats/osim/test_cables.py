"""Actuators, ligaments and springs along paths pull as OpenSim's do, and are written as they were read."""

from pathlib import Path

import msgspec
import mujoco
import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load, save
from warpmuscle.formats.mjcf import dumps as mjcf_text
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import BlankevoortLigament, Excitation, Ligament, PathActuator, Scene
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

POSES = ((0.3, 0.5), (-1.0, 0.3), (0.9, 0.0))  # rad, rad/s
CURVE = '<SimmSpline name="force_length_curve"><x>0.9 1 1.2 1.5 2</x><y>0 0 0.3 1.2 3</y></SimmSpline>'
REST = "<resting_length>0.25</resting_length>"
OPENSIM = {  # class, what is in it, and accelerations of the rod in OpenSim 4.6, rad/s^2
    "plain": ("Ligament", f"{REST}<pcsa_force>100</pcsa_force>", (-0.468186, 1.891878, -1.707070)),
    "curved": ("Ligament", f"{REST}<pcsa_force>100</pcsa_force>{CURVE}", (-0.114503, 1.927488, -1.707070)),
    "spring": (
        "PathSpring", f"{REST}<stiffness>300</stiffness><dissipation>0.3</dissipation>",
        (-0.289228, 1.866908, -1.707070),
    ),
    "toe": (
        "Blankevoort1991Ligament",
        "<slack_length>0.25</slack_length><linear_stiffness>900</linear_stiffness>"
        "<transition_strain>0.3</transition_strain><damping_coefficient>40</damping_coefficient>",
        (0.116319, 2.078534, -1.707070),
    ),
    "cable": ("PathActuator", "<optimal_force>30</optimal_force>", (0.175627, 1.854164, -0.641542)),
    "told": (
        "ExpressionBasedPathForce", f"{REST}<expression>(150*s + 900*s^2)*(1 + 0.3*ldot)</expression>",
        (-0.438547, 1.860038, -1.707070),
    ),
    "short": ("ExpressionBasedPathForce", "<expression>exp(3*s) - 1</expression>", (-0.585213, 1.835860, -1.656808)),
}  # fmt: skip
CONTROL = 0.6


def cable(kind: str, name: str, inner: str, rod: str) -> str:
    points = small.point("a", "ground", "0.1 0.1 0") + small.point("b", rod, "0.05 -0.2 0")
    path = f'<GeometryPath name="path"><PathPointSet><objects>{points}</objects></PathPointSet></GeometryPath>'
    return f'<{kind} name="{name}">{path}{inner}</{kind}>\n'


def scene_of(folder: Path, cables: str, rods: tuple[str, ...] = ("rod",)) -> tuple[Scene, list[Ignored]]:
    bodies = "".join(small.body(rod, center="0 -0.5 0") for rod in rods)
    joints = "".join(small.joint("PinJoint", f"pin_{rod}", "ground", rod, small.coordinate(f"q_{rod}")) for rod in rods)
    ignored: list[Ignored] = []
    return load(small.written(folder, small.model(bodies, joints, cables)), ignored=ignored), ignored


def one(folder: Path, kind: str, inner: str) -> tuple[Scene, list[Ignored]]:
    return scene_of(folder, cable(kind, "one", inner, "rod"))


def test_rods_accelerate_as_in_opensim(tmp_path: Path):
    cables = "".join(cable(kind, name, inner, name) for name, (kind, inner, _) in OPENSIM.items())
    scene, _ = scene_of(tmp_path, cables, tuple(OPENSIM))
    scene = msgspec.structs.replace(loads(dumps(scene)), time_step=1e-4, duration=1e-3)
    scene.character.muscles["cable"].excitation = Excitation([0.0], [CONTROL])
    rollout = Rollout(scene, len(POSES), "cpu")
    coordinates, speeds = rollout.state.coordinates.numpy().copy(), rollout.state.speeds.numpy().copy()
    rods = [rollout.names.body_of_joint(f"q_{name}") for name in OPENSIM]
    coordinates[:, [rollout.names.coordinate_start[rod] for rod in rods]] = np.array(POSES)[:, :1]
    columns = [rollout.names.speed_start[rod] for rod in rods]
    speeds[:, columns] = np.array(POSES)[:, 1:]
    rollout.state.coordinates.assign(coordinates)
    rollout.state.speeds.assign(speeds)
    rollout.step(1)
    found = (rollout.state.speeds.numpy() - speeds)[:, columns] / 1e-4
    np.testing.assert_allclose(found, np.transpose([expected for *_, expected in OPENSIM.values()]), atol=1e-3)
    activation = dict(zip(scene.character.muscles, rollout.state.muscles.activation.numpy()[0], strict=True))
    assert activation == dict.fromkeys(OPENSIM, 0.0) | {"cable": pytest.approx(CONTROL)}


@pytest.mark.parametrize("name", OPENSIM)
def test_what_is_written_is_read_again(tmp_path: Path, name: str):
    kind, inner, _ = OPENSIM[name]
    scene, _ = one(tmp_path, kind, inner)
    lost: list[Ignored] = []
    save(scene, tmp_path / "again.osim", lost)
    assert f"<{kind.replace('ExpressionBasedPathForce', 'Ligament')} " in (tmp_path / "again.osim").read_text()
    if name == "told":
        assert [told for told in lost if "only a tension that is straight over length has a dissipation" in told.reason]
        scene.character.muscles["one"].curve_shape.dissipation = 0.0
    assert load(tmp_path / "again.osim", ignored=[]).character.muscles == scene.character.muscles
    kinds = {"cable": PathActuator, "toe": BlankevoortLigament}
    assert isinstance(scene.character.muscles["one"].curve_shape, kinds.get(name, Ligament))


@pytest.mark.parametrize(
    ("kind", "inner", "message"),
    [
        ("Ligament", "<pcsa_force>100</pcsa_force>", "resting_length must be greater than 0"),
        ("Ligament", REST, "force is 0 at any length"),
        ("PathSpring", f"{REST}<stiffness>-3</stiffness>", "push along its path"),
        ("Blankevoort1991Ligament", "<linear_stiffness>9</linear_stiffness>", "must be greater than 0"),
        ("PathActuator", "<optimal_force>-1</optimal_force>", "push along its path"),
    ],
)
def test_what_pulls_with_nothing_is_left_out_and_told(tmp_path: Path, kind: str, inner: str, message: str):
    scene, ignored = one(tmp_path, kind, inner)
    assert not scene.character.muscles
    (note,) = [note for note in ignored if note.text == f"{kind} one"]
    assert message in note.reason


def test_mujoco_pulls_as_much(tmp_path: Path):
    rest = f"{REST}<stiffness>300</stiffness>"
    cables = cable("PathSpring", "spring", rest, "rod") + cable("PathActuator", "cable", OPENSIM["cable"][1], "rod")
    scene, _ = scene_of(tmp_path, cables)
    model = mujoco.MjModel.from_xml_string(mjcf_text(scene))
    data = mujoco.MjData(model)
    data.qpos[0] = data.qpos[0] - 1.0
    data.ctrl[0] = CONTROL
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] > 0.25
    arm = data.ten_J[0] if np.ndim(data.ten_J) == 1 else data.ten_J[0, 0]
    assert float(data.qfrc_spring[0]) == pytest.approx(float(-300.0 * (data.ten_length[0] - 0.25) * np.ravel(arm)[0]))
    assert float(data.qfrc_actuator[0]) == pytest.approx(float(-30.0 * CONTROL * np.ravel(arm)[0]))


def test_mujoco_has_no_curved_ligaments(tmp_path: Path):
    scene, _ = one(tmp_path, "Ligament", OPENSIM["plain"][1])
    with pytest.raises(SceneError, match="springs without damping"):
        mjcf_text(scene)


def test_other_functions_of_a_ligament_become_splines_or_lines(tmp_path: Path):
    curve = "<force_length_curve><{0}><coefficients>{1}</coefficients></{0}></force_length_curve>"
    inner = f"{REST}<pcsa_force>100</pcsa_force>"
    for kind, coefficients, count in (("LinearFunction", "3 -3", 2), ("PolynomialFunction", "1 0 -1", 401)):
        scene, _ = one(tmp_path, "Ligament", inner + curve.format(kind, coefficients))
        shape = scene.character.muscles["one"].curve_shape
        assert isinstance(shape, Ligament)
        assert len(shape.x) == count
        assert np.interp(2.0, shape.x, shape.y) == pytest.approx(3.0, abs=1e-9)


@pytest.mark.parametrize(
    ("inner", "note"),
    [
        (f"{REST}<expression>90*s + 20*ldot</expression>", "its tension depends on speed otherwise than by a factor"),
        (f"{REST}<expression>90*s*(1 - 2*ldot)</expression>", "its tension depends on speed otherwise than"),
        (f"{REST}<expression>90*s - 5</expression>", "its tension pushes where it is negative"),
        (f"{REST}<expression>90*s + 5</expression>", "pulls on paths that are shorter than at rest"),
        (f"{REST}<clamp_stretch>false</clamp_stretch><expression>s</expression>", "pulls on paths that are shorter"),
    ],
)  # fmt: skip
def test_what_is_not_kept_of_a_tension_that_is_an_expression_is_told(tmp_path: Path, inner: str, note: str):
    scene, ignored = one(tmp_path, "ExpressionBasedPathForce", inner)
    assert isinstance(scene.character.muscles["one"].curve_shape, Ligament)
    assert [told for told in ignored if note in told.reason]


@pytest.mark.parametrize(
    ("inner", "message"),
    [
        ("", "has no <expression>"), ("<expression>90*x</expression>", "<expression>"),
        ("<expression>1/s</expression>", "has no number at some stretch"),
        ("<resting_length>-1</resting_length><expression>s</expression>", "must not be negative, is -1"),
        ("<expression>open('a')</expression>", "<expression>"),
    ],
)  # fmt: skip
def test_a_tension_that_is_no_expression_is_refused_in_one_line(tmp_path: Path, inner: str, message: str):
    with pytest.raises(SceneError, match=message) as error:
        one(tmp_path, "ExpressionBasedPathForce", inner)
    assert "\n" not in str(error.value)
