"""Joints that depend on two coordinates: ConstantCurvatureJoint, couplers and axes of several coordinates."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from reduced_tree import check_energy_stays, put
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.osim.placement import WORLD
from warpmuscle.formats.osim.read import read
from warpmuscle.inverse.chain import chain_of
from warpmuscle.model.build import start_of
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

TOOLS = Path(__file__).parents[4] / "tools"
ROD = "<length>0.3</length><neutral_angle_x_z_y>0.1 0.4 -0.2</neutral_angle_x_z_y>"
BODY = ("trunk", 3.0, "0.01 0.1 0.02", "0.03 0.04 0.02 0.001 0 0.002")
PRODUCT = (
    '<MultivariatePolynomialFunction name="function"><coefficients>0.1 -0.3 0.2 0.7 0.5 -0.4</coefficients>'
    "<dimension>2</dimension><order>2</order></MultivariatePolynomialFunction>"
)  # 0.1 - 0.3 b + 0.2 b^2 + 0.7 a + 0.5 a b - 0.4 a^2
NOTHING = '<Constant name="function"><value>0</value></Constant>'
SUM = '<LinearFunction name="function"><coefficients>0.6 -0.4 0.05</coefficients></LinearFunction>'


def spine_text(of_x: str = "", rod: str = ROD, more: str = "", extra: str = "") -> str:
    """A trunk on a rod that stands on a pelvis, which leans, and an arm on it."""
    coordinates = "".join(small.coordinate(name, of_x if name == "x" else "") for name in "xzy") + extra
    bodies = small.body("pelvis", 2.0, "0 0.02 0", "0.02 0.03 0.02 0 0 0") + small.body(*BODY)
    bodies += small.body("arm", 1.5, "0.01 -0.15 0.02", "0.02 0.003 0.02 0 0.001 0")
    joints = small.joint("PinJoint", "base", "ground", "pelvis", small.coordinate("lean"), "", "0 0.9 0", "0.1 0.2 0")
    joints += small.joint("ConstantCurvatureJoint", "spine", "pelvis", "trunk", coordinates, rod, "0.02 0.1 0.03",
        "0.1 -0.3 0.2", "-0.06 -0.04 -0.05", "-0.5 -0.1 -0.3")  # fmt: skip
    joints += small.joint("PinJoint", "gleno", "trunk", "arm", small.coordinate("raise"), "", "0.05 0.2 0.1", "0.4 0 0")
    path = small.point("a", "pelvis", "-0.06 0.05 0.02") + small.point("b", "trunk", "-0.07 0.1 0.01")
    return small.model(bodies, joints, small.muscle("extensor", path), more)


def linkage_text(on_axis: str = PRODUCT, coupled: str = "") -> str:
    """A link whose second axis is a function of two coordinates, and one that is coupled to both."""
    bodies = small.body("first", 2.0, "0.02 -0.2 0", "0.02 0.03 0.02 0 0 0") + small.body(*BODY)
    bodies += small.body("last", 1.0, "0 -0.1 0.02", "0.01 0.02 0.01 0 0 0")
    turns = {"rotation1": ("a", "0 0 1", small.LINE), "rotation2": ("a b", "0.6 0 0.8", on_axis),
        "rotation3": ("b", "0 1 0", small.LINE), "translation1": ("", "1 0 0", NOTHING),
        "translation2": ("a b", "0 1 0", SUM), "translation3": ("", "0 0 1", NOTHING)}  # fmt: skip
    joints = small.joint("PinJoint", "base", "ground", "first", small.coordinate("lean"))
    joints += small.joint("CustomJoint", "both", "first", "trunk", small.coordinate("a") + small.coordinate("b"),
        small.axes(**turns), "0.03 -0.4 0", "0.3 0.1 0")  # fmt: skip
    joints += small.joint("PinJoint", "end", "trunk", "last", small.coordinate("c"), "", "0 0.3 0.02", "0.2 0 0.5")
    path = small.point("p", "first", "0.05 -0.1 0.02") + small.point("q", "last", "-0.03 0.1 0.01")
    more = f"<ConstraintSet><objects>{coupled}</objects></ConstraintSet>" if coupled else ""
    return small.model(bodies, joints, small.muscle("flexor", path), more)


def knee_text() -> str:
    """The same where the first coordinate turns the last axis, too, as flexion turns a shank."""
    last = f'<TransformAxis name="rotation3"><coordinates>b</coordinates><axis>0 1 0</axis>{small.LINE}'
    turn = '<PolynomialFunction name="function"><coefficients>0.3 -0.2 0.4 0</coefficients></PolynomialFunction>'
    text = linkage_text(SUM)
    assert last in text
    return text.replace(last, last.replace(">b<", ">a<").replace(small.LINE, turn))


def coupler(function: str, names: str = "a lean") -> str:
    return (
        f'<CoordinateCouplerConstraint name="c_follows"><coupled_coordinates_function>{function}'
        f"</coupled_coordinates_function><independent_coordinate_names>{names}</independent_coordinate_names>"
        "<dependent_coordinate_name>c</dependent_coordinate_name></CoordinateCouplerConstraint>"
    )


def loaded(folder: Path, text: str) -> Scene:
    return load(small.written(folder, text), ignored=[])


def states(scene: Scene, count: int = 20) -> tuple[np.ndarray, dict[str, int]]:
    """Coordinates drawn at random, and which are whose."""
    names = topology(scene.character)
    q = np.repeat(start_of(scene, names).coordinates, count, axis=0)
    own = {name: names.coordinates_of(names.body_of_joint(name)) for name in scene.character.joints}
    moving = {name: place.start for name, place in own.items() if place.stop > place.start}
    moving = {name: column for name, column in moving.items() if not scene.character.joints[name].follows}
    q[:, list(moving.values())] = np.random.default_rng(5).uniform(-0.8, 0.8, (count, len(moving)))
    return q, moving


def arc(angles: np.ndarray, length: float, steps: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """The end of a rod with the same curvature all along, added up piece by piece, and its axes."""
    x, z, y = angles
    turns = [np.array([[1.0, 0.0, 0.0], [0.0, np.cos(x), -np.sin(x)], [0.0, np.sin(x), np.cos(x)]])]
    turns.append(np.array([[np.cos(z), -np.sin(z), 0.0], [np.sin(z), np.cos(z), 0.0], [0.0, 0.0, 1.0]]))
    up = turns[0] @ turns[1] @ [0.0, 1.0, 0.0]
    theta, aside = np.arccos(up[1]), np.array([up[0], 0.0, up[2]]) / np.hypot(up[0], up[2])
    middle = (np.arange(steps) + 0.5) / steps * theta
    place = length / steps * np.sum(np.outer(np.sin(middle), aside) + np.outer(np.cos(middle), [0.0, 1.0, 0.0]), axis=0)
    twist = np.array([[np.cos(y), 0.0, np.sin(y)], [0.0, 1.0, 0.0], [-np.sin(y), 0.0, np.cos(y)]])
    return place, turns[0] @ turns[1] @ twist


def test_the_child_is_at_the_end_of_an_arc(tmp_path: Path):
    text = small.model(small.body("trunk"), small.joint("ConstantCurvatureJoint", "spine", "ground", "trunk",
        "".join(map(small.coordinate, "xzy")), ROD))  # fmt: skip
    scene = loaded(tmp_path, text)
    q, own = states(scene)
    place, turn = body_points(scene, q)["trunk"]
    angles = q[:, [own[name] for name in "xzy"]] + [0.1, 0.4, -0.2]
    first = arc(angles[0], 0.3)[1]
    for k, values in enumerate(angles):
        expected, axes = arc(values, 0.3)
        np.testing.assert_allclose(WORLD.T @ place[k], expected, atol=1e-8)
        turned = rotate(turn[k], np.eye(3)).T @ rotate(turn[0], np.eye(3))
        np.testing.assert_allclose(WORLD.T @ turned @ WORLD, axes @ first.T, atol=1e-12)


@pytest.mark.parametrize("text", [spine_text(), linkage_text(coupled=coupler(PRODUCT))])
def test_energy_stays(tmp_path: Path, text: str):
    scene = loaded(tmp_path, text)
    scene.character.muscles.clear()
    scene.duration, scene.time_step = 0.4, 1.0 / 8000.0
    for name, joint in scene.character.joints.items():
        joint.limits = []
        if joint.type == "hinge":
            scene.initial_state.joints[name] = JointState(angular_velocity=tuple(5.0 * x for x in joint.axes[0]))
    check_energy_stays(scene)


@pytest.mark.parametrize("text", [spine_text(), linkage_text(), knee_text(), linkage_text(coupled=coupler(PRODUCT))])
def test_accelerations_need_no_force_in_float64(tmp_path: Path, text: str):
    scene = loaded(tmp_path, text)
    scene.character.muscles.clear()
    q, _ = states(scene)
    v = np.random.default_rng(6).normal(scale=2.0, size=(len(q), topology(scene.character).speeds))
    stages = put(scene, q, v)
    a = stages.forward_dynamics()["speed_rate"].astype(float)
    needed = inverse_dynamics(scene, q, v, a)
    still = inverse_dynamics(scene, q, v, np.zeros_like(a))
    assert np.abs(needed).max() < 2e-5 * np.abs(still).max()


def test_lengths_are_those_of_opensim_and_arms_their_slopes(tmp_path: Path):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    from warpmuscle.studies.moment_arms import muscle_geometry

    file = small.written(tmp_path, spine_text())
    scene = load(file, ignored=[])
    q, own = states(scene)
    length, arm = muscle_geometry(scene, q)
    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(file))
    state = model.initSystem()

    def theirs(values: np.ndarray) -> float:
        for name, column in own.items():
            model.getCoordinateSet().get(name).setValue(state, float(values[column]), False)
        model.realizePosition(state)
        return float(model.getMuscles().get(0).getLength(state))

    names = topology(scene.character)
    for row, values in enumerate(q):
        assert length[row, 0] == pytest.approx(theirs(values), abs=2e-7)
        for name, column in own.items():
            step = 1e-5 * np.eye(len(values))[column]
            slope = (theirs(values - step) - theirs(values + step)) / 2e-5
            speed = names.speeds_of(names.body_of_joint(name)).start
            assert arm[row, 0, speed] == pytest.approx(slope, abs=1e-6)


@pytest.mark.parametrize("coupled", ["", coupler(PRODUCT), coupler(SUM, "b lean")])
def test_dynamics_of_several_coordinates_are_those_of_opensim(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, coupled: str
):
    pytest.importorskip("opensim", reason="OpenSim is not installed")
    monkeypatch.setenv("WARPMUSCLE_OPENSIM_CACHE", str(tmp_path / "kept"))
    monkeypatch.syspath_prepend(str(TOOLS))
    import opensim_agreement

    report = opensim_agreement.compare(small.written(tmp_path, linkage_text(SUM, coupled)), 10, 1, 0, False)
    found = {one["name"]: one for one in report["measures"]}
    assert found["path length"]["worst"] < 2e-6
    for name in ("mass matrix", "inverse dynamics", "gravity"):
        assert found[name]["worst"] < 1e-8


@pytest.mark.parametrize("held", ["x", "z"])
def test_a_locked_turn_leaves_an_arc_of_the_other(tmp_path: Path, held: str):
    free = loaded(tmp_path, spine_text())
    lock = "<default_value>0.3</default_value><locked>true</locked>"
    text = spine_text(lock) if held == "x" else spine_text().replace(
        small.coordinate("z"), small.coordinate("z", lock))  # fmt: skip
    locked = loaded(tmp_path, text)
    assert not any(joint.beside for joint in locked.character.joints.values())
    q, own = states(free)
    q[:, own[held]] = 0.3
    at, there = states(locked)
    for name, column in there.items():
        at[:, column] = q[:, own[name]]
    np.testing.assert_allclose(body_points(locked, at)["arm"][0], body_points(free, q)["arm"][0], atol=1e-8)


def test_a_rod_is_scaled_as_its_child_is_along_y(tmp_path: Path):
    """OpenSim 4.6 makes a rod of 0.3 m between bodies scaled by (1.1, 1.2, 1.3) and (2, 3, 4) 0.9 m long."""
    model = read(small.written(tmp_path, spine_text()), Notes())
    scaled = scaled_model(model, {"pelvis": np.array([1.1, 1.2, 1.3]), "trunk": np.array([2.0, 3.0, 4.0])})
    lengths = [joint.rod.length for joint in scaled.joints if joint.rod is not None]
    np.testing.assert_allclose(lengths, [0.9])


def test_markers_cannot_be_fitted_and_say_so(tmp_path: Path):
    with pytest.raises(SceneError, match="markers cannot be fitted through a joint that depends on two coordinates"):
        chain_of(loaded(tmp_path, spine_text()))


CUBIC = PRODUCT.replace("<dimension>2", "<dimension>3").replace("0.1 -0.3 0.2 0.7 0.5 -0.4", " ".join(["0.1"] * 20))
CUBIC = CUBIC.replace("<order>2", "<order>3")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (spine_text(rod="<length>0</length>"), "greater than 0"),
        (spine_text(rod="<length>nan</length>"), "nan"),
        (spine_text(rod="<length>0.3</length><neutral_angle_x_z_y>1 2</neutral_angle_x_z_y>"), "3 numbers"),
        (spine_text(extra=small.coordinate("w")), "has 4 coordinates, a joint of its class 3"),
        (linkage_text(PRODUCT.replace("-0.4<", "<")), "6 numbers"),
        (linkage_text(PRODUCT.replace("<dimension>2", "<dimension>3")), "is 3 for 2 coordinates"),
        (linkage_text(PRODUCT.replace("<order>2", "<order>-1")), "a whole number from 0 on"),
        (linkage_text(PRODUCT.replace("<order>2", "<order>1e9")), "a whole number from 0 on"),
        (linkage_text(small.spline("SimmSpline", "0 1 2", "0 1 3")), "of several, lines and polynomials"),
        (linkage_text(coupled=coupler(CUBIC, "a b lean")), "products of two are known"),
        (linkage_text(coupled=coupler(PRODUCT, "a c")), "make a circle"),
        (linkage_text(coupled=coupler(PRODUCT, "a nobody")), "there is no coordinate 'nobody'"),
        (linkage_text(SUM).replace("<coordinates>a</coordinates>", "<coordinates>b</coordinates>"), ""),
    ],
)
def test_what_cannot_be_taken_is_refused_in_one_sentence(tmp_path: Path, text: str, said: str):
    if not said:
        loaded(tmp_path, text)
        return
    with pytest.raises(SceneError, match=said):
        loaded(tmp_path, text)
