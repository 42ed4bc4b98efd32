"""Paths round and inside of MuJoCo's cylinders and spheres: shortest ones in float64, and MuJoCo's own."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels.path.wrap_mujoco import mujoco_cylinder_touch, mujoco_sphere_touch
from warpmuscle.kernels.path.wrap_touch import Touch
from warpmuscle.scene.wrapping.mujoco import mujoco_touch

RADIUS, COUNT = 0.05, 400
BESIDE, WITHIN = np.array([0.09, 0.05, 0.06]), np.array([0.01, -0.02, 0.01])
SIDES = {"no side": None, "beside": BESIDE, "within": WITHIN}
every_kind = pytest.mark.parametrize("kind", ["sphere", "cylinder"])
every_side = pytest.mark.parametrize("side", SIDES)


def ends(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Ends (n, 3) of segments about the origin, some of them inside."""
    random = np.random.default_rng(seed)
    places = random.normal(size=(2, COUNT, 3))
    places *= random.uniform(0.03, 0.2, (2, COUNT, 1)) / np.linalg.norm(places, axis=2, keepdims=True)
    return places[0], places[1]


@wp.func
def path_length(a: wp.vec3, b: wp.vec3, found: Touch) -> float:
    if found.kind == 0:
        return wp.length(b - a)
    return wp.length(found.first - a) + found.arc + wp.length(b - found.second)


@wp.func
def round_sphere(a: wp.vec3, b: wp.vec3, sided: int, side: wp.vec3) -> float:
    return path_length(a, b, mujoco_sphere_touch(a, b, RADIUS, sided, side))


@wp.func
def round_cylinder(a: wp.vec3, b: wp.vec3, sided: int, side: wp.vec3) -> float:
    return path_length(a, b, mujoco_cylinder_touch(a, b, RADIUS, sided, side))


KINDS = {"sphere": round_sphere, "cylinder": round_cylinder}


def host_length(a: np.ndarray, b: np.ndarray, side: np.ndarray | None, kind: str) -> float:
    touch = mujoco_touch(a, b, RADIUS, side, kind == "sphere")
    if touch.kind == 0:
        return float(np.linalg.norm(b - a))
    return float(np.linalg.norm(touch.first - a) + touch.length + np.linalg.norm(b - touch.second))


@every_kind
@every_side
def test_single_precision_gives_the_lengths_of_double(kind: str, side: str):
    a, b = ends(1)
    point = SIDES[side]
    got = evaluate(KINDS[kind], a, b, int(point is not None), np.zeros(3) if point is None else point)
    expected = [host_length(*pair, point, kind) for pair in zip(a, b, strict=True)]
    np.testing.assert_allclose(got, expected, atol=2e-7)


@wp.func
def touches_sphere(a: wp.vec3, b: wp.vec3) -> wp.vec3:
    return mujoco_sphere_touch(a, b, RADIUS, 0, wp.vec3(0.0)).first


@pytest.mark.parametrize("angle", [0.4, 2.0, 4.1])
@pytest.mark.parametrize("reach", [0.06, 0.3])
def test_ends_almost_opposite_are_joined_in_their_plane_however_near_they_are(angle: float, reach: float):
    """Only the sine of their angle, 4e-7 here, tells whether they have a plane."""
    beside = np.array([0.0, np.cos(angle), np.sin(angle)])
    a, b = np.array([0.1, 0.0, 0.0]), np.array([-reach, 0.0, 0.0]) + 4e-7 * reach * beside
    first = evaluate(touches_sphere, a, b)[0]
    np.testing.assert_allclose(first[1:], np.sqrt(RADIUS**2 - first[0] ** 2) * beside[1:], atol=1e-5)
    assert first[0] == pytest.approx(RADIUS**2 / 0.1, rel=1e-4)


@every_kind
@every_side
def test_lengths_are_those_of_mujoco(kind: str, side: str):
    mujoco = pytest.importorskip("mujoco", minversion="4.0")
    point = SIDES[side]
    place = " ".join(map(repr, map(float, BESIDE if point is None else point)))
    beside = "" if point is None else 'sidesite="s"'
    ends_of = "".join(f'<body mocap="true"><site name="{name}"/></body>' for name in "ab")
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody>{ends_of}<geom name="g" type="{kind}" size="{RADIUS} 0.3"/><site name="s" pos="{place}"/>'
        '</worldbody><tendon><spatial><site site="a"/>'
        f'<geom geom="g" {beside}/><site site="b"/></spatial></tendon></mujoco>'
    )
    data = mujoco.MjData(model)
    for a, b in zip(*ends(2), strict=True):
        data.mocap_pos[:] = a, b
        mujoco.mj_kinematics(model, data)
        mujoco.mj_tendon(model, data)
        assert host_length(a, b, point, kind) == pytest.approx(data.ten_length[0], abs=1e-9)


@every_kind
def test_a_path_inside_touches_where_it_is_shortest(kind: str):
    """Every other point of the circle, in the plane of the sphere or along the cylinder's slope, is farther."""
    a, b = np.array([0.12, 0.01, 0.0]), np.array([0.03, 0.11, 0.0])
    touch = mujoco_touch(a, b, RADIUS, WITHIN, kind == "sphere")
    angles = np.linspace(0.0, 2.0 * np.pi, 100_001)
    circle = RADIUS * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    least = (np.linalg.norm(circle - a, axis=1) + np.linalg.norm(circle - b, axis=1)).min()
    assert touch.length == 0.0
    assert host_length(a, b, WITHIN, kind) == pytest.approx(least, abs=1e-9)
    assert np.linalg.norm(touch.first) == pytest.approx(RADIUS)


def test_a_side_point_chooses_the_way_that_does_not_pass_behind():
    a, b = np.array([-0.1, 0.02, 0.0]), np.array([0.1, 0.02, 0.0])
    above, below = (mujoco_touch(a, b, RADIUS, np.array([0.0, y, 0.0]), False) for y in (0.2, -0.2))
    assert above.first[1] > 0.0 > below.first[1]
    beyond = np.array([0.0, 0.1, 0.0])
    free = mujoco_touch(a + beyond, b + beyond, RADIUS, 2.0 * beyond, False)
    assert free.kind == 0
