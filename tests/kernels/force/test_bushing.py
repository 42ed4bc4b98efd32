"""Bushings by virtual power: what they do to both bodies has the power of their generalised force."""

import numpy as np
import pytest
import warp as wp
from probes import filled
from scipy.spatial.transform import Rotation

from warpmuscle.kernels.force.bushing import Bushing, bushing
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.structs import Model, Scratch, Skeleton, State

AXES = ("x", "y", "z")
COM = np.array([[0.02, -0.1, 0.03], [-0.04, 0.08, 0.01]])  # m, from the joint points
PLACES = np.array([[0.1, 0.02, 0.03], [-0.05, 0.04, 0.01]])  # m, of the frames from the centres of mass
TURNS = np.array([[0.2, -0.1, 0.3], [0.1, 0.2, -0.2]])  # rad, of the frames in the bodies


@wp.kernel(enable_backward=False)
def push(given: Bushing, model: Model, state: State, work: Scratch, result: wp.array[Wrench]):
    second = wp.tid()
    its = work
    result[second] = bushing(0, second, 1 - second, second, model, state, its, given)


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
    given, rows = {}, [f"m{a}" for a in AXES] + [f"f{a}" for a in AXES]
    columns = [f"t{a}" for a in AXES] + list(AXES)
    for k, row in enumerate(rows):
        given[row] = rest[k]
        given |= {f"{row}_{column}": stiffness[k, j] for j, column in enumerate(columns)}
    given |= {f"damping_{column}": damping[k] for k, column in enumerate(columns)}
    for k, which in enumerate(("first", "second")):
        given |= {f"{which}_{a}": PLACES[k, i] for i, a in enumerate(AXES)}
        given |= {f"{which}_turn_{a}": TURNS[k, i] for i, a in enumerate(AXES)}
    from_joint = np.array([r.apply(c) for r, c in zip(bodies.rotations, COM, strict=True)])
    model = filled(Model, body_count=2, skeleton=filled(Skeleton, row={"com": COM[None]}))
    work = filled(
        Scratch, rotation=np.float32([r.as_matrix() for r in bodies.rotations]),
        position=np.float32(bodies.places - from_joint), angular_velocity=np.float32(bodies.spins),
        velocity=np.float32(bodies.velocities - np.cross(bodies.spins, from_joint)),
    )  # fmt: skip
    result = wp.zeros(2, dtype=Wrench, device="cpu")
    one = filled(Bushing, **{name: float(value) for name, value in given.items()})
    wp.launch(push, 2, [one, model, State(), work, result], device="cpu")
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
