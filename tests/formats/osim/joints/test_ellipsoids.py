"""Joints whose child slides on an ellipsoid: where it is, that its motion is exact, and OpenSim's own numbers."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from reduced_tree import check_energy_stays
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about, rotate
from warpmuscle.formats import load
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.osim.frames import turned
from warpmuscle.formats.osim.placement import WORLD
from warpmuscle.formats.osim.read import read
from warpmuscle.model.build import start_of
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import body_points

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

TOOLS = Path(__file__).parents[4] / "tools"
TAGS = {"EllipsoidJoint": "radii_x_y_z", "ScapulothoracicJoint": "thoracic_ellipsoid_radii_x_y_z"}
WINGING = (
    "<scapula_winging_axis_origin>0.03 0.04</scapula_winging_axis_origin>"
    "<scapula_winging_axis_direction>0.6</scapula_winging_axis_direction>"
)
PLACE, TURN, OWN, OWN_TURN = "0.02 0.1 0.03", "0.1 -0.87 0.2", "-0.06 -0.04 -0.05", "-0.5 -1.1 -0.3"


def shoulder_text(kind: str, radii: str, of_first: str = "") -> str:
    """A thorax that leans, a scapula on it, and an arm on that."""
    count = 3 if kind == "EllipsoidJoint" else 4
    more = "" if kind == "EllipsoidJoint" else WINGING
    own = "".join(small.coordinate(f"q{k}", of_first if k == 0 else "") for k in range(count))
    bodies = (
        small.body("thorax", 3.0, "0.01 0.05 0", "0.03 0.04 0.02 0.001 0 0.002")
        + small.body("scapula", 0.7, "0.02 -0.03 0.05", "0.002 0.003 0.0025 0.0002 0.0001 -0.0001")
        + small.body("arm", 1.5, "0.01 -0.15 0.02", "0.02 0.003 0.02 0 0.001 0")
    )
    joints = (
        small.joint("PinJoint", "base", "ground", "thorax", small.coordinate("lean"))
        + small.joint(kind, "slide", "thorax", "scapula", own, f"<{TAGS[kind]}>{radii}</{TAGS[kind]}>{more}", PLACE,
            TURN, OWN, OWN_TURN)
        + small.joint("PinJoint", "gleno", "scapula", "arm", small.coordinate("raise"), "", "0.05 0.02 0.03", "0.4 0 0")
    )  # fmt: skip
    paths = {
        "serratus": small.point("a", "thorax", "0.1 0.05 0.08") + small.point("b", "scapula", "0.01 -0.08 0.02"),
        "deltoid": small.point("a", "thorax", "0.03 0.2 0.05") + small.point("b", "arm", "0.02 -0.1 0.01"),
    }
    return small.model(bodies, joints, "".join(small.muscle(*one) for one in paths.items()))


def shoulder(folder: Path, kind: str, radii: str, of_first: str = "") -> Scene:
    return load(small.written(folder, shoulder_text(kind, radii, of_first)), ignored=[])


def vector(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def turn(axis: int | np.ndarray, angle: float) -> np.ndarray:
    return rotate(about(np.eye(3)[axis] if isinstance(axis, int) else axis, angle), np.eye(3)).T


def on_ellipsoid(kind: str, radii: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The child's frame in the parent's, as OpenSim's documentation says it."""
    if kind == "EllipsoidJoint":
        axes = turn(0, q[0]) @ turn(1, q[1]) @ turn(2, q[2])
        return axes, radii * axes[:, 2]
    axes, place = on_ellipsoid("EllipsoidJoint", radii[[1, 0, 2]], q)
    quarter = turn(2, np.pi / 2.0)
    axes, place = quarter @ axes @ quarter.T, quarter @ place
    origin, wing = np.array([0.03, 0.04, 0.0]), turn(np.array([-np.sin(0.6), np.cos(0.6), 0.0]), q[3])
    return axes @ wing, place + axes @ (origin - wing @ origin)


@pytest.mark.parametrize(
    "radii", ["0.08 0.15 0.11", "0.1 0.1 0.1", "0.15 0.08 0.08", "0.08 0.08 0.15", "-0.08 -0.15 -0.11"]
)
@pytest.mark.parametrize("kind", TAGS)
def test_the_child_is_on_the_ellipsoid_with_its_z_axis_along_the_normal(tmp_path: Path, kind: str, radii: str):
    names = [f"q{k}" for k in range(3 if kind == "EllipsoidJoint" else 4)]
    more = f"<{TAGS[kind]}>{radii}</{TAGS[kind]}>" + (WINGING if len(names) == 4 else "")
    joint = small.joint(kind, "slide", "ground", "scapula", "".join(map(small.coordinate, names)), more, PLACE, TURN,
        OWN, OWN_TURN)  # fmt: skip
    scene = load(
        small.written(tmp_path, small.model(small.body("scapula", center="0.02 -0.03 0.05"), joint)), ignored=[]
    )
    numbers = topology(scene.character)
    q = np.random.default_rng(4).uniform(-1.5, 1.5, (20, len(names)))
    coordinates = np.repeat(start_of(scene, numbers).coordinates, 20, axis=0)
    coordinates[:, [numbers.coordinates_of(numbers.body_of_joint(name)).start for name in names]] = q
    place, orientation = body_points(scene, coordinates)["scapula"]
    own = next(one.position_in_child for one in scene.character.joints.values() if one.child == "scapula")
    center = place - rotate(orientation, np.array(own))
    near, far = turned(vector(TURN)), turned(vector(OWN_TURN))
    sizes, upright = np.array(vector(radii)), near @ far.T
    for k, values in enumerate(q):
        axes, at = on_ellipsoid(kind, sizes, values)
        body = near @ axes @ far.T
        expected = np.array(vector(PLACE)) + near @ at + body @ (np.array([0.02, -0.03, 0.05]) - vector(OWN))
        np.testing.assert_allclose(WORLD.T @ center[k], expected, atol=1e-14)
        found = rotate(orientation[k], np.eye(3)).T
        np.testing.assert_allclose(WORLD.T @ found @ WORLD, body @ upright.T, atol=1e-14)


def test_a_round_ellipsoid_needs_fewer_turns(tmp_path: Path):
    rows = {
        radii: shoulder(tmp_path, "EllipsoidJoint", radii) for radii in ("0.1 0.1 0.1", "0.2 0.1 0.1", "0.3 0.2 0.1")
    }
    assert [len(scene.character.joints) for scene in rows.values()] == [5, 6, 9]
    assert {topology(scene.character).speeds for scene in rows.values()} == {5}


@pytest.mark.parametrize("kind", TAGS)
def test_energy_stays_where_a_scapula_slides_and_swings(tmp_path: Path, kind: str):
    scene = shoulder(tmp_path, kind, "0.08 0.15 0.11")
    scene.character.muscles.clear()
    scene.duration, scene.time_step = 0.4, 1.0 / 8000.0
    for name, joint in scene.character.joints.items():
        joint.limits = []
        if joint.type == "hinge" and name != "q1":  # which stays away from a right angle, where q0 and q2 are one
            scene.initial_state.joints[name] = JointState(angular_velocity=tuple(4.0 * x for x in joint.axes[0]))
    check_energy_stays(scene)


@pytest.mark.parametrize("kind", TAGS)
def test_lengths_arms_and_dynamics_are_those_of_opensim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str):
    pytest.importorskip("opensim", reason="OpenSim is not installed")
    monkeypatch.setenv("WARPMUSCLE_OPENSIM_CACHE", str(tmp_path / "kept"))
    monkeypatch.syspath_prepend(str(TOOLS))
    import opensim_agreement

    file = small.written(tmp_path, shoulder_text(kind, "0.08 0.15 0.11"))
    report = opensim_agreement.compare(file, 30, 1, 0, False)
    found = {one["name"]: one for one in report["measures"]}
    assert found["path length"]["worst"] < 2e-6
    assert found["moment arm, where OpenSim's is the slope"]["worst"] < 2e-5  # of the others it takes no angles' rates
    assert found["our moment arm and the slope of our length"]["worst"] < 1e-4
    for name in ("mass matrix", "inverse dynamics", "gravity"):
        assert found[name]["worst"] < 1e-11


def test_a_locked_turn_leaves_a_row_of_the_others(tmp_path: Path):
    values = (0.3, -0.4, 0.7)
    free = shoulder(tmp_path, "EllipsoidJoint", "0.08 0.15 0.11")
    held = shoulder(
        tmp_path, "EllipsoidJoint", "0.08 0.15 0.11", "<default_value>0.3</default_value><locked>true</locked>"
    )
    places = []
    for scene, known in ((free, (0, 1, 2)), (held, (1, 2))):
        names = topology(scene.character)
        q = start_of(scene, names).coordinates.copy()
        for k in known:
            q[:, names.coordinates_of(names.body_of_joint(f"q{k}"))] = values[k]
        poses = body_points(scene, q)
        places.append(poses["arm"][0] - poses["scapula"][0])
    np.testing.assert_allclose(np.linalg.norm(places[0]), np.linalg.norm(places[1]), atol=1e-12)


def test_radii_are_scaled_along_the_bodys_axes(tmp_path: Path):
    model = read(small.written(tmp_path, shoulder_text("EllipsoidJoint", "0.08 0.15 0.11")), Notes())
    scaled = scaled_model(model, {"thorax": np.array([1.1, 0.9, 1.3])})
    radii = next(joint.ellipsoid.radii for joint in scaled.joints if joint.ellipsoid is not None)
    np.testing.assert_allclose(radii, [0.088, 0.135, 0.143])


@pytest.mark.parametrize("kind", TAGS)
@pytest.mark.parametrize(
    ("radii", "said"), [("", "has no <"), ("0.1 0 0.1", "no radius of an ellipsoid is 0"), ("0.1 0.1", "3 numbers")]
)
def test_an_ellipsoid_without_radii_is_refused(tmp_path: Path, kind: str, radii: str, said: str):
    with pytest.raises(SceneError, match=said):
        shoulder(tmp_path, kind, radii)
