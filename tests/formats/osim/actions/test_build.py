"""Forces of functions and expressions, and actuators with controls, accelerate bodies as OpenSim's do."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

import osim_models as small
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*centre of mass starts"),
    pytest.mark.usefixtures("unoptimized_kernels"),
]
STEP, STATES, CLOSE = 1e-2, 50, 2e-6  # s; drawn states; part of the greatest acceleration
WORDS = ("a1", "a2", "a3", "x1", "x2", "x3"), ("b1", "b2", "b3", "y1", "y2", "y3")


def line(slope: float, offset: float, name: str = "function") -> str:
    return f'<LinearFunction name="{name}"><coefficients>{slope} {offset}</coefficients></LinearFunction>'


def powers(text: str, name: str = "function") -> str:
    return f'<PolynomialFunction name="{name}"><coefficients>{text}</coefficients></PolynomialFunction>'


def spline(name: str) -> str:
    return f'<SimmSpline name="{name}"><x>-1 -0.3 0.1 0.4 1</x><y>-90 -8 3 40 60</y></SimmSpline>'


def functions(tag: str, *members: str) -> str:
    return f'<FunctionSet name="{tag}"><objects>{"".join(members)}</objects></FunctionSet>'


FRAMES = "".join(
    f'<PhysicalOffsetFrame name="f{k}"><socket_parent>/bodyset/{body}</socket_parent><translation>{place}</translation>'
    f"<orientation>{turn}</orientation></PhysicalOffsetFrame>"
    for k, body, place, turn in ((1, "one", "0.1 0.02 0.03", "0.2 -0.1 0.3"), (2, "two", "-0.05 0 0.1", "0.1 0.2 -0.2"))
)
ENDS = f"<socket_frame1>f1</socket_frame1><socket_frame2>f2</socket_frame2><frames>{FRAMES}</frames>"
POINTS = "<point1>0.3 0.1 -0.2</point1><point2>0.1 0.4 0.05</point2>"
DAMPING = "<rotational_damping>0.5 0.6 0.7</rotational_damping><translational_damping>5 6 7</translational_damping>"
FORCES = {
    "coordinate": (
        "ExpressionBasedCoordinateForce",
        "<coordinate>b2</coordinate><expression>-30*q^3 - 2*qdot*abs(q) + exp(sin(4*q)) - max(q, 0.2)^2</expression>",
    ),
    "points": (
        "ExpressionBasedPointToPointForce",
        f"<body1>one</body1><body2>two</body2>{POINTS}<expression>90*(d-0.2)^2 + 12*ddot</expression>",
    ),
    "spring": (
        "PointToPointSpring",
        f"<socket_body1>/ground</socket_body1><socket_body2>/bodyset/two</socket_body2>{POINTS}"
        "<stiffness>300</stiffness><rest_length>0.4</rest_length>",
    ),
    "pull": (
        "PointToPointActuator",
        "<bodyA>one</bodyA><bodyB>two</bodyB><pointA>0.3 0.1 -0.2</pointA><pointB>0.1 0.4 0.05</pointB>"
        "<optimal_force>50</optimal_force>",
    ),
    "functions": (
        "FunctionBasedBushingForce",
        f"{ENDS}{DAMPING}<m_x_theta_x_function>{spline('f')}</m_x_theta_x_function>"
        f"<m_z_theta_z_function>{line(40, 1)}</m_z_theta_z_function>"
        f"<f_y_delta_y_function>{powers('900 0 20 3')}</f_y_delta_y_function>",
    ),
    "curved": (
        "ExpressionBasedBushingForce",
        f"{ENDS}{DAMPING}<Mx_expression>30*theta_x^3 - 4*theta_y*delta_z</Mx_expression>"
        "<Fz_expression>sqrt(1 + 900*delta_z^2)*10</Fz_expression>",
    ),
    "told": (
        "PrescribedForce",
        "<socket_frame>/bodyset/two</socket_frame><pointIsGlobal>false</pointIsGlobal>"
        "<forceIsGlobal>false</forceIsGlobal>"
        + functions("forceFunctions", line(10, 4, "a"), spline("b"), line(0, 7, "c"))
        + functions("pointFunctions", line(0, 0.2, "d"), line(1, 0.1, "e"), line(0, -0.1, "f"))
        + functions("torqueFunctions", line(5, 1, "g"), line(0, 0, "h"), line(0, 3, "i")),
    ),
    "told_in_ground": (
        "PrescribedForce",
        "<socket_frame>/bodyset/two</socket_frame><pointIsGlobal>true</pointIsGlobal>"
        "<forceIsGlobal>true</forceIsGlobal>"
        + functions("forceFunctions", line(10, 4, "a"), line(3, -9, "b"), line(0, 7, "c"))
        + functions("pointFunctions", line(0, 0.2, "d"), line(1, 0.1, "e"), line(0, -0.1, "f")),
    ),
    "push": (
        "PointActuator",
        "<body>two</body><point>0.1 0.3 -0.1</point><direction>1 2 -2</direction><optimal_force>60</optimal_force>",
    ),
    "torque": (
        "TorqueActuator",
        "<bodyA>two</bodyA><bodyB>one</bodyB><torque_is_global>false</torque_is_global><axis>1 -2 2</axis>"
        "<optimal_force>30</optimal_force>",
    ),
    "torque_in_ground": (
        "TorqueActuator",
        "<bodyA>two</bodyA><bodyB>one</bodyB><axis>0 1 0</axis><optimal_force>30</optimal_force>",
    ),
    "drive": ("CoordinateActuator", "<coordinate>y2</coordinate><optimal_force>80</optimal_force>"),
}  # fmt: skip


def file_of(folder: Path, forces: str, controller: str) -> Path:
    bodies = small.body("one", 2.0, "0.1 0.2 0") + small.body("two", 1.0, "0 -0.3 0.1")
    joints = small.joint_of_six("first", "ground", "one", WORDS[0]) + small.joint_of_six(
        "second", "one", "two", WORDS[1]
    )
    text = small.model(bodies, joints, forces)
    return small.written(folder, text.replace("</Model>", f"{controller}</Model>"))


def controlled(names: list[str]) -> str:
    """A controller of actuators, each with another line over time."""
    sets = "".join(line(2.0 + k, 0.5 - k, name) for k, name in enumerate(names))
    who = " ".join(f"/forceset/{name}" for name in names)
    return (
        f'<ControllerSet><objects><PrescribedController name="control"><socket_actuators>{who}</socket_actuators>'
        f"{functions('ControlFunctions', sets)}</PrescribedController></objects></ControllerSet>"
    )


def scene_of(path: Path) -> tuple[Scene, list[Ignored]]:
    ignored: list[Ignored] = []
    scene = load(path, ignored=ignored)
    return msgspec.structs.replace(loads(dumps(scene)), time_step=STEP, duration=STEP), ignored


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.4, 0.4, (STATES, 12)), rng.uniform(-1.0, 1.0, (STATES, 12))


def alone(scene: Scene, name: str) -> Scene:
    """The scene with one of its forces, of the same kinds, so that nothing is compiled anew."""
    forces = {}
    for other, force in scene.forces.items():
        off = {key: 0.0 for key in force.parameters if key.startswith(("stiffness", "damping"))}
        quiet = msgspec.structs.replace(force, parameters=force.parameters | off, expressions={})
        forces[other] = force if other == name else quiet
    return msgspec.structs.replace(scene, forces=forces)


def accelerations(scene: Scene, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
    rollout = Rollout(scene, STATES, "cpu")
    coordinates, speeds = rollout.state.coordinates.numpy().copy(), rollout.state.speeds.numpy().copy()
    bodies = [rollout.names.body_of_joint(name) for words in WORDS for name in words]
    coordinates[:, [rollout.names.coordinate_start[body] for body in bodies]] = q
    columns = [rollout.names.speed_start[body] for body in bodies]
    speeds[:, columns] = rate
    rollout.state.coordinates.assign(coordinates)
    rollout.state.speeds.assign(speeds)
    before = rollout.state.speeds.numpy()[:, columns].astype(float)
    rollout.step(1)
    return (rollout.state.speeds.numpy()[:, columns] - before) / STEP


def accelerations_in_opensim(path: Path, name: str, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
    opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    opensim.Logger.setLevelString("error")
    model = opensim.Model(str(path))
    state = model.initSystem()
    for other in FORCES:
        model.getForceSet().get(other).setAppliesForce(state, other == name)
    state.setTime(0.5 * STEP)
    own = [model.getCoordinateSet().get(one) for words in WORDS for one in words]
    found = np.zeros_like(q)
    for pose in range(len(q)):
        for k, coordinate in enumerate(own):
            coordinate.setValue(state, q[pose, k], False)
            coordinate.setSpeedValue(state, rate[pose, k])
        model.realizeAcceleration(state)
        found[pose] = [coordinate.getAccelerationValue(state) for coordinate in own]
    return found


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Scene]:
    forces = "".join(f'<{kind} name="{name}">{inner}</{kind}>\n' for name, (kind, inner) in FORCES.items())
    actuators = [name for name, (kind, _) in FORCES.items() if kind.endswith("Actuator")]
    path = file_of(tmp_path_factory.mktemp("model"), forces, controlled(actuators))
    return path, scene_of(path)[0]


@pytest.mark.parametrize("name", FORCES)
def test_bodies_accelerate_as_in_opensim(name: str, both: tuple[Path, Scene]):
    path, scene = both
    assert list(scene.forces) == list(FORCES)
    q, rate = drawn(1)
    expected = accelerations_in_opensim(path, name, q, rate)
    found = accelerations(alone(scene, name), q, rate)
    np.testing.assert_allclose(found, expected, atol=CLOSE * np.abs(expected).max())


def test_what_cannot_act_is_left_out_and_told(tmp_path: Path):
    odd = "<coordinate>b1</coordinate><expression>sec(q)</expression>"
    one = "<socket_frame>two</socket_frame>" + functions("forceFunctions", line(0, 1))
    on_ground = "<socket_frame>/ground</socket_frame>" + functions("forceFunctions", *(line(0, 1, n) for n in "abc"))
    forces = {
        "odd": ("ExpressionBasedCoordinateForce", odd, "'sec'"),
        "still": ("PrescribedForce", on_ground, "does not move"),
        "alone": ("TorqueActuator", "<bodyA>two</bodyA><bodyB>two</bodyB>", "bodies are one"),
        "lost": ("PointToPointSpring", "<socket_body1>two</socket_body1>", "names no <body2>"),
        "two": ("PrescribedForce", one, "three"),
        "free": ("TorqueActuator", "<bodyA>two</bodyA><bodyB>one</bodyB>", "no controller prescribes its control"),
    }
    text = "".join(f'<{kind} name="{name}">{inner}</{kind}>\n' for name, (kind, inner, _) in forces.items())
    scene, ignored = scene_of(file_of(tmp_path, text, ""))
    assert list(scene.forces) == ["free"]
    told = {note.text.split()[-1]: note.reason for note in ignored}
    for name, (*_, reason) in forces.items():
        assert reason in told[name]


def test_muscles_get_the_controls_that_are_prescribed(tmp_path: Path):
    points = small.point("a", "one", "0.1 0.1 0") + small.point("b", "two", "0.05 -0.2 0")
    path = f'<GeometryPath name="path"><PathPointSet><objects>{points}</objects></PathPointSet></GeometryPath>'
    actuator = f'<PathActuator name="cable">{path}<optimal_force>30</optimal_force></PathActuator>'
    other = '<ControlSetController name="other"><controls_file>a.xml</controls_file></ControlSetController>'
    controller = controlled(["cable"]).replace("</objects></ControllerSet>", f"{other}</objects></ControllerSet>")
    scene, ignored = scene_of(file_of(tmp_path, actuator, controller))
    excitation = scene.character.muscles["cable"].excitation
    assert excitation is not None
    expected = np.clip(2.0 * np.array(excitation.time) + 0.5, 0.0, 1.0)
    np.testing.assert_allclose(excitation.value, expected, atol=1e-12)
    reasons = [note.reason for note in ignored]
    assert any("cut to be from 0 to 1" in reason for reason in reasons)
    assert any("only a PrescribedController is known" in reason for reason in reasons)
