"""Motion of coupled joints: derivatives are those of the place, and lanes that share the work find the same."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import filled, units

from warpmuscle.core.pose import about, conjugate, multiply
from warpmuscle.kernels.body.joint_motion import (
    JointMotion,
    coupled_motion,
    displaced_motion_of,
    displacements_stage_of,
)
from warpmuscle.kernels.structs import Couplings, Model, Scratch, Skeleton, State

BODIES, KIND = 3, 11  # the first function belongs to no body; a coupled joint on bodies 1 and 2 each
AXES = units(13, 1)
PIECES = np.random.default_rng(2).normal(size=(13, 2, 4)) * [0.4, 0.5, 0.3, 0.2]
PIECES[[8, 9, 11]] = 0.0  # functions of the second joint that are 0 everywhere
CORNER = 0.2  # rad, where a function's second piece begins


@cache
def move_of(sparse: bool) -> Any:
    """The kernel that finds motions by both ways. sparse: whether the second one leaves out what is 0 everywhere."""
    displacements_stage, displaced_motion = displacements_stage_of(sparse), displaced_motion_of(sparse)

    @wp.kernel(enable_backward=False, module="unique")
    def move(
        lanes: int, model: Model, state: State, work: Scratch, alone: wp.array[JointMotion],
        shared: wp.array[JointMotion],
    ):  # fmt: skip
        its = work
        for lane in range(lanes):
            displacements_stage(0, lane, lanes, model, state, its)
        for body in range(1, model.body_count):
            q = state.coordinates[0, model.skeleton.plan[body].coordinate_start]
            alone[body] = coupled_motion(0, body, q, model)
            shared[body] = displaced_motion(0, body, model, its)

    return move


def moved(q: np.ndarray, lanes: int = 1, sparse: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Motions of both joints at their coordinates (2,), each of one lane and of several."""
    pieces = {"start": np.tile([-9.0, CORNER], 13)[None], "c": PIECES.reshape(1, 26, 4)}
    function = {
        "axis": AXES[None], "first_piece": 2 * np.arange(13)[None], "end_piece": 2 * np.arange(1, 14)[None],
        "body": np.array([[0, *[1] * 6, *[2] * 6]]), "counts": PIECES.any(axis=(1, 2))[None].astype(int),
    }  # fmt: skip
    couplings = filled(Couplings, piece=pieces, function=function, joint={"first": [0, 1, 7]})
    plan = {"joint_type": [0, KIND, KIND], "coordinate_start": [0, 7, 8]}
    model = filled(Model, body_count=BODIES, couplings=couplings, skeleton=filled(Skeleton, plan=plan))
    state = filled(State, coordinates=np.float32([[*np.zeros(7), *q]]))
    rates = np.full((BODIES, 3, 3), np.nan, np.float32)
    work = filled(Scratch, turn_rates=rates, move_rates=rates.copy())
    result = [wp.zeros(BODIES, dtype=JointMotion, device="cpu") for _ in range(2)]
    wp.launch(move_of(sparse), 1, [lanes, model, state, work, *result], device="cpu")
    return result[0].numpy()[1:], result[1].numpy()[1:]


@pytest.mark.parametrize(("lanes", "sparse"), [(1, False), (4, True), (32, False)])
def test_lanes_that_share_the_functions_find_the_same_motion(lanes: int, sparse: bool):
    for q in ([0.1, 0.3], [-0.7, 0.9]):
        alone, shared = moved(np.array(q), lanes, sparse)
        for name in alone.dtype.names:
            np.testing.assert_allclose(shared[name], alone[name], rtol=1e-6, atol=1e-7)
            assert np.abs(alone[name]).max() > 0.01


def at(q: float, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Orientation and place in float64: turns about three axes, each riding on those before, and three shifts."""
    piece = int(q >= CORNER)
    f = np.array([np.polynomial.Polynomial(c)(q - (-9.0, CORNER)[piece]) for c in PIECES[first : first + 6, piece]])
    turned = np.array([0.0, 0.0, 0.0, 1.0])
    for k in range(3):
        turned = multiply(turned, about(AXES[first + k], f[k]))
    return turned, f[3:] @ AXES[first + 3 : first + 6]


def test_place_and_motion_subspace_are_those_of_the_functions():
    for q in (0.25, 0.9):
        found, step = moved(np.array([q, q]))[1], 1e-5
        for joint, first in enumerate((1, 7)):
            (low, here, high), one = ([at(q + k * step, first) for k in (-1, 0, 1)]), found[joint]
            assert abs(np.dot(here[0], one["orientation"])) == pytest.approx(1.0, abs=1e-6)
            np.testing.assert_allclose(one["place"], here[1], atol=1e-6)
            turning = [
                2.0 * multiply((b[0] - a[0]) / step, conjugate(0.5 * (a[0] + b[0])))[:3]
                for a, b in ((low, here), (here, high))
            ]
            np.testing.assert_allclose(one["turning"], np.mean(turning, axis=0), atol=1e-4)
            np.testing.assert_allclose(one["turning_slope"], np.diff(turning, axis=0)[0] / step, atol=2e-3)
            np.testing.assert_allclose(one["moving"], (high[1] - low[1]) / (2.0 * step), atol=1e-5)
            bend = (high[1] - 2.0 * here[1] + low[1]) / step**2
            np.testing.assert_allclose(one["moving_slope"], bend, atol=1e-4)
