"""Forces of joints of which one coordinate turns several axes, in float64, beside masses on a frame in plain NumPy.

Simbody turns the second and third axis of such a joint as if each coordinate moved one rotation alone, so that
OpenSim's own accelerations are not the rates of its velocities there: what is right is shown without it.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.formats import load
from warpmuscle.model.build import start_of
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

Floats = np.ndarray
G = 9.80665  # m/s^2, as OpenSim has it
STEP = 2e-3  # s and rad, of differences of fourth order
CORNERS = 0.1 * np.array([[1.0, 0.2, 0.1], [-0.6, 1.0, 0.3], [0.1, -0.8, 0.9], [0.2, 0.4, -1.1], [-0.7, -0.3, 0.2]])
MASSES = np.array([0.5, 0.9, 0.4, 0.7, 0.6])  # kg, at these places, m, of each of the two bodies
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 1.0, 0.0]])  # of a knee that bends, leans and turns
TURNING = [0.3, -0.17, 0.37, 0.05]  # coefficients from the highest order on
SHIFTS = [[0.02, -0.1, 0.18, 0.0], [-0.05, 0.05, -0.11, 0.04], [0.12, -0.04, 0.06, 0.0]]
LEANING = [0.2, 0.1, -0.3, 0.0]
ANCHOR = np.array([0.03, -0.4, 0.02])


def turned(axis: Floats, angle: float) -> Floats:
    x, y, z = axis / np.linalg.norm(axis)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def knee(coordinates: int) -> tuple[str, Callable[[Floats], Floats]]:
    """A shank on a thigh that swings: its file, and where the masses of both are at given coordinates.

    Args:
        coordinates: of the joint, 2 where the second axis is a coordinate's own, 1 where all follow the first.
    """
    centre = MASSES @ CORNERS / MASSES.sum()
    apart = CORNERS - centre
    tensor = np.einsum("k,kij->ij", MASSES, np.einsum("ka,ka,ij->kij", apart, apart, np.eye(3))
                       - apart[:, :, None] * apart[:, None, :])  # fmt: skip
    inertia = " ".join(f"{tensor[i, j]:.17g}" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    text = [small.body(name, MASSES.sum(), " ".join(map(repr, centre.tolist())), inertia)
            for name in ("thigh", "shank")]  # fmt: skip
    names = [("bend", small.LINE), ("lean", small.LINE) if coordinates == 2 else ("bend", polynomial(LEANING)),
             ("bend", polynomial(TURNING))]  # fmt: skip
    turns = {f"rotation{k + 1}": (name, " ".join(map(str, AXES[k])), function)
             for k, (name, function) in enumerate(names)}  # fmt: skip
    turns |= {f"translation{k + 1}": ("bend", " ".join("1" if i == k else "0" for i in range(3)), polynomial(shift))
              for k, shift in enumerate(SHIFTS)}  # fmt: skip
    own = "".join(map(small.coordinate, ("bend", "lean")[:coordinates]))
    joints = small.joint("PinJoint", "hip", "ground", "thigh", small.coordinate("swing"))
    joints += small.joint("CustomJoint", "knee", "thigh", "shank", own, small.axes(**turns),
        " ".join(map(str, ANCHOR)))  # fmt: skip
    path = small.point("a", "thigh", "0.05 -0.1 0.02") + small.point("b", "shank", "-0.03 0.1 0.01")

    def places(q: Floats) -> Floats:
        swing, bend = q[:2]
        lean = q[2] if coordinates == 2 else np.polyval(LEANING, bend)
        first = turned(np.array([0.0, 0.0, 1.0]), swing)
        turn = turned(AXES[0], bend) @ turned(AXES[1], lean) @ turned(AXES[2], np.polyval(TURNING, bend))
        shift = ANCHOR + np.array([np.polyval(one, bend) for one in SHIFTS])
        return np.concatenate([CORNERS @ first.T, (shift + CORNERS @ turn.T) @ first.T])

    return small.model("".join(text), joints, small.muscle("flexor", path)), places


def polynomial(coefficients: list[float]) -> str:
    words = " ".join(map(str, coefficients))
    return f'<PolynomialFunction name="function"><coefficients>{words}</coefficients></PolynomialFunction>'


def slope(of: Callable[[float], Floats]) -> Floats:
    return (8.0 * (of(STEP) - of(-STEP)) - (of(2.0 * STEP) - of(-2.0 * STEP))) / (12.0 * STEP)


def bend(of: Callable[[float], Floats]) -> Floats:
    return (16.0 * (of(STEP) + of(-STEP)) - (of(2.0 * STEP) + of(-2.0 * STEP)) - 30.0 * of(0.0)) / (12.0 * STEP**2)


def expected(places: Callable[[Floats], Floats], q: Floats, v: Floats, a: Floats) -> Floats:
    """Generalised forces by d'Alembert's principle: what each mass takes, along what each coordinate does with it."""
    upward = bend(lambda t: places(q + v * t + 0.5 * a * t * t)) + np.array([0.0, G, 0.0])
    taken = np.tile(MASSES, 2)[:, None] * upward
    moved = [slope(lambda t, way=way: places(q + t * way)) for way in np.eye(len(q))]  # type: ignore[misc]
    return np.array([np.sum(taken * one) for one in moved])


def in_scene(scene: Scene, names: list[str], values: Floats, speeds: bool) -> Floats:
    """Values (n, K) of named coordinates, or their rates, in the scene's order."""
    own = topology(scene.character)
    found = np.zeros((len(values), own.speeds))
    if not speeds:
        found = np.repeat(start_of(scene, own).coordinates, len(values), axis=0).astype(np.float64)
    for k, name in enumerate(names):
        body = own.body_of_joint(name)
        found[:, (own.speeds_of(body) if speeds else own.coordinates_of(body)).start] = values[:, k]
    return found


@pytest.mark.parametrize("coordinates", [1, 2])
def test_forces_are_those_of_masses_that_move_with_the_bodies(tmp_path: Path, coordinates: int):
    text, places = knee(coordinates)
    scene = load(small.written(tmp_path, text), ignored=[])
    names = ["swing", "bend", "lean"][: coordinates + 1]
    generator = np.random.default_rng(3)
    q, v, a = (generator.uniform(-high, high, (12, len(names))) for high in (1.0, 3.0, 8.0))
    there = in_scene(scene, names, q, False), in_scene(scene, names, v, True), in_scene(scene, names, a, True)
    needed = inverse_dynamics(scene, *there)
    order = [int(in_scene(scene, [name], np.ones((1, 1)), True)[0].argmax()) for name in names]
    truth = np.array([expected(places, *row) for row in zip(q, v, a, strict=True)])
    np.testing.assert_allclose(needed[:, order], truth, atol=1e-7 * np.abs(truth).max())


def test_opensims_forces_agree_where_its_accelerations_are_the_rates_of_its_velocities(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    pytest.importorskip("opensim", reason="OpenSim is not installed")
    monkeypatch.setenv("WARPMUSCLE_OPENSIM_CACHE", str(tmp_path / "kept"))
    monkeypatch.syspath_prepend(str(Path(__file__).parents[4] / "tools"))
    import opensim_agreement

    report = opensim_agreement.compare(small.written(tmp_path, knee(2)[0]), 10, 1, 0, False)
    worst = {one["name"]: one["worst"] for one in report["measures"]}
    assert worst["mass matrix"] < 1e-12
    assert worst["inverse dynamics, with that rate"] < 1e-8
    assert worst["OpenSim's accelerations and the rate of its velocities"] > 1e-3
    assert worst["inverse dynamics"] > 1e-3
