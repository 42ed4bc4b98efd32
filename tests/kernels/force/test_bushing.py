"""Bushings by virtual power: what they do to both bodies has the power of their generalised force."""

from typing import Any

import msgspec
import numpy as np
import pytest
import warp as wp
from probes import filled
from scipy.spatial.transform import Rotation

from small_scene import muscle_scene
from warpmuscle.kernels.force.bushing import Bushing, bushing
from warpmuscle.kernels.force.devices import FORCES
from warpmuscle.kernels.force.expressions import BushingExpression, bushing_expression
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.muscle_structs import Muscles
from warpmuscle.kernels.structs import Model, Scratch, Skeleton, State
from warpmuscle.model.expressions.programs import expression_tables
from warpmuscle.scene import Force

AXES = ("x", "y", "z")
ROWS = ("mx", "my", "mz", "fx", "fy", "fz")
COM = np.array([[0.02, -0.1, 0.03], [-0.04, 0.08, 0.01]])  # m, from the joint points
PLACES = np.array([[0.1, 0.02, 0.03], [-0.05, 0.04, 0.01]])  # m, of the frames from the centres of mass
TURNS = np.array([[0.2, -0.1, 0.3], [0.1, 0.2, -0.2]])  # rad, of the frames in the bodies


@wp.kernel(enable_backward=False)
def push(given: Bushing, model: Model, state: State, work: Scratch, result: wp.array[Wrench]):
    second = wp.tid()
    its = work
    result[second] = bushing(0, second, 1 - second, second, model, state, its, given)


@wp.kernel(enable_backward=False)
def push_as_written(given: BushingExpression, model: Model, state: State, work: Scratch, result: wp.array[Wrench]):
    second = wp.tid()
    its = work
    result[second] = bushing_expression(0, second, 1 - second, second, model, state, its, given)


class Bodies:
    """Two bodies in space, in float64: centres of mass, rotations and velocities."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        first = Rotation.random(random_state=seed)
        self.rotations = [first, first * Rotation.from_rotvec(0.4 * rng.normal(size=3))]
        self.places, self.velocities, self.spins = (rng.normal(size=(2, 3)) * scale for scale in (0.1, 0.5, 0.8))

    def coordinates(self, dt: float = 0.0, moving: tuple[np.ndarray, np.ndarray] | None = None) -> np.ndarray:
        """Angles (body-fixed, x y z) and shifts of the second frame in the first one, after a time of a motion."""
        velocities, spins = moving or (self.velocities, self.spins)
        turned = [Rotation.from_rotvec(w * dt) * r for w, r in zip(spins, self.rotations, strict=True)]
        frames = [r * Rotation.from_rotvec(t) for r, t in zip(turned, TURNS, strict=True)]
        origins = self.places + velocities * dt + [r.apply(p) for r, p in zip(turned, PLACES, strict=True)]
        angles = (frames[0].inv() * frames[1]).as_euler("XYZ")
        return np.concatenate([angles, frames[0].inv().apply(origins[1] - origins[0])])

    def rates(self, moving: tuple[np.ndarray, np.ndarray] | None = None) -> np.ndarray:
        """Rates of the coordinates in a motion, by differences."""
        return (self.coordinates(1e-5, moving) - self.coordinates(-1e-5, moving)) / 2e-5


def wrenches(bodies: Bodies, rest: np.ndarray, stiffness: np.ndarray, damping: np.ndarray) -> tuple:
    """Forces (2, 3) on both bodies and moments about their centres of mass."""
    given, columns = placed_and_damped(damping), [f"t{a}" for a in AXES] + list(AXES)
    for k, row in enumerate(ROWS):
        given[row] = rest[k]
        given |= {f"{row}_{column}": stiffness[k, j] for j, column in enumerate(columns)}
    return launched(push, Bushing, given, bodies, np.zeros((0, 2)))


def wrenches_as_written(bodies: Bodies, texts: list[str], damping: np.ndarray) -> tuple:
    """`wrenches` of a bushing by six expressions."""
    force = Force("bushing_expression", expressions=dict(zip(ROWS, texts, strict=True)))
    table, starts = expression_tables(msgspec.structs.replace(muscle_scene(), forces={"bushing": force}))
    return launched(push_as_written, BushingExpression, placed_and_damped(damping) | starts["bushing"], bodies, table)


def placed_and_damped(damping: np.ndarray) -> dict[str, float]:
    """Where both frames are, and rows of damping."""
    given = {f"damping_{column}": damping[k] for k, column in enumerate([f"t{a}" for a in AXES] + list(AXES))}
    for k, which in enumerate(("first", "second")):
        given |= {f"{which}_{a}": PLACES[k, i] for i, a in enumerate(AXES)}
        given |= {f"{which}_turn_{a}": TURNS[k, i] for i, a in enumerate(AXES)}
    return given


def launched(kernel: Any, struct: Any, given: dict[str, float], bodies: Bodies, table: np.ndarray) -> tuple:
    from_joint = np.array([r.apply(c) for r, c in zip(bodies.rotations, COM, strict=True)])
    muscles = filled(Muscles, curve_table=np.float32(table))
    model = filled(Model, body_count=2, skeleton=filled(Skeleton, row={"com": COM[None]}))
    model.muscles = muscles
    work = filled(
        Scratch, rotation=np.float32([r.as_matrix() for r in bodies.rotations]),
        position=np.float32(bodies.places - from_joint), angular_velocity=np.float32(bodies.spins),
        velocity=np.float32(bodies.velocities - np.cross(bodies.spins, from_joint)),
    )  # fmt: skip
    result = wp.zeros(2, dtype=Wrench, device="cpu")
    one = filled(struct, **{name: float(value) for name, value in given.items()})
    wp.launch(kernel, 2, [one, model, State(), work, result], device="cpu")
    return result.numpy()["force"].astype(float), result.numpy()["moment"].astype(float)


@pytest.mark.parametrize("seed", range(4))
def test_the_power_on_both_bodies_is_that_of_the_generalised_force(seed: int):
    """Sum of F.v + M.w = -(f0 + K q + D q').dq/dt in any motion, with every element of K, D and f0 there."""
    bodies, rng = Bodies(seed), np.random.default_rng(100 + seed)
    rest, stiffness, damping = rng.normal(size=6), 10.0 * rng.normal(size=(6, 6)), rng.uniform(0.5, 3.0, 6)
    force, moment = wrenches(bodies, rest, stiffness, damping)
    acting = -(rest + stiffness @ bodies.coordinates() + damping * bodies.rates())
    for _ in range(8):
        v, w = rng.normal(size=(2, 2, 3))
        power = np.sum(force * v) + np.sum(moment * w)
        assert power == pytest.approx(acting @ bodies.rates((v, w)), abs=2e-3 * np.abs(acting).max())
    np.testing.assert_allclose(force[0], -force[1], atol=1e-5 * np.abs(force).max())
    assert np.abs(force).max() > 0.3


@pytest.mark.parametrize("seed", range(2))
def test_expressions_that_are_linear_push_both_bodies_as_the_linear_bushing_does(seed: int):
    bodies, rng = Bodies(seed), np.random.default_rng(200 + seed)
    rest, stiffness, damping = rng.normal(size=6), 10.0 * rng.normal(size=(6, 6)), rng.uniform(0.5, 3.0, 6)
    names = FORCES["bushing_expression"].variables
    texts = [
        " + ".join([f"{rest[k]}", *(f"{stiffness[k, j]}*{name}" for j, name in enumerate(names))]) for k in range(6)
    ]
    for found, expected in zip(
        wrenches_as_written(bodies, texts, damping), wrenches(bodies, rest, stiffness, damping), strict=True
    ):
        np.testing.assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())
