"""Every kind of observation against float64, of free, planar and fixed roots, and what random states begin with."""

import inspect
import re
from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import filled, matrix, turn_about

from warpmuscle.kernels.learning import senses
from warpmuscle.kernels.learning.episodes import Episodes
from warpmuscle.kernels.learning.senses import Feature, Surroundings
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    HINGE,
    ROOT_FIXED,
    ROOT_FREE,
    ROOT_PLANAR,
    UNIVERSAL,
    MuscleState,
    SimbiconState,
    Skeleton,
    State,
)

N, WEIGHT = 12, 640.0
LEAST, GREATEST = -0.5, 1.0  # of an action, beyond which it does no more
TYPES = (ROOT_FREE, BALL, FIXED, UNIVERSAL, HINGE)  # a chain whose last body is the head
COORDINATES, SPEEDS = (7, 4, 0, 2, 1), (6, 3, 0, 2, 1)
OF_ROOT = {ROOT_FREE: (7, 6), ROOT_PLANAR: (3, 3), ROOT_FIXED: (0, 0)}
NORMAL, GROUND = (0.48, 0.8, 0.36), 0.15
UP = np.array([0.0, 1.0, 0.0])


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@pytest.fixture(scope="module", params=OF_ROOT, ids=["free", "planar", "fixed"])
def drawn(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Numbers of all instances, and where the coordinates and speeds of bodies start."""
    random, root = np.random.default_rng(5), request.param
    counts = [np.cumsum([0, of, *table[1:]]) for of, table in zip(OF_ROOT[root], (COORDINATES, SPEEDS), strict=True)]
    first, speed = counts
    q, v = random.normal(0.0, 0.7, (N, first[-1])), random.normal(0.0, 0.7, (N, speed[-1]))
    q[:, first[1] : first[1] + 4] = unit(q[:, first[1] : first[1] + 4])
    if root == ROOT_FREE:
        q[:, 3:7] = unit(q[:, 3:7])
    return {
        "root": root, "q": q, "v": v, "first": first, "speed": speed, "axis_a": unit(random.normal(size=(5, 3))),
        "axis_b": unit(random.normal(size=(5, 3))), "activation": random.random((N, 3)),
        "sensed": random.normal(size=(N, 3, 3)), "action": random.normal(size=(N, 4)),
        "command": random.normal(size=(N, 4)), "phase": random.random(N), "stance": np.arange(N) % 2,
        "push": random.normal(size=(N, 3)) * WEIGHT, "push_steps": np.stack([np.full(N, 4), np.full(N, 8)], axis=1),
        "step": 2 + np.arange(N) % 8, "varied": random.normal(size=(3, 4)), "variant": np.arange(N) % 3,
        "clock": random.random(N), "foot_force": random.normal(size=(N, 2, 3)) * WEIGHT,
        "heading": random.normal(size=N), "side": random.normal(0.0, 1.2, N), "custom": random.normal(size=(N, 2)),
        "goal": random.normal(size=(N, 6)),
    }  # fmt: skip


def state_of(d: dict[str, Any]) -> list[Any]:
    """State, episodes and surroundings of the instances."""
    plan = {
        "joint_type": TYPES, "parent": (-1, 0, 1, 2, 3), "coordinate_start": d["first"][:-1],
        "speed_start": d["speed"][:-1],
    }  # fmt: skip
    row = {name: d[name][None] for name in ("axis_a", "axis_b")}
    state = filled(
        State, coordinates=d["q"], speeds=d["v"],
        simbicon=filled(SimbiconState, phase=d["phase"], stance=d["stance"]), push=d["push"],
        push_steps=d["push_steps"], step=d["step"], foot_force=d["foot_force"],
        muscles=filled(MuscleState, activation=d["activation"], sensed=d["sensed"]),
    )  # fmt: skip
    names = ("command", "heading", "side", "variant")
    episodes = filled(Episodes, **{name: d[name] for name in names}, phase=d["clock"])
    around = filled(
        Surroundings, root=d["root"], head=len(TYPES) - 1, skeleton=filled(Skeleton, plan=plan, row=row),
        normal=[[NORMAL]], ground=[[GROUND]], body_weight=WEIGHT, action=d["action"], varied=d["varied"],
        custom=d["custom"], goal=d["goal"],
        least_action=LEAST, greatest_action=GREATEST,
    )  # fmt: skip
    return [state, episodes, around]


def observed(d: dict[str, Any], features: list[tuple[int, int]], scale: float = 1.0) -> np.ndarray:
    """What the kernel says (instances, features)."""
    kind, index = np.transpose(features)
    given = filled(Features, feature={"kind": kind, "index": index, "scale": np.full(len(kind), scale)})
    result = wp.zeros((N, len(features)), device="cpu")
    wp.launch(senses.observe_now, result.shape, [given.feature, *state_of(d), result], device="cpu")
    return result.numpy().astype(float)


@wp.struct
class Features:
    """What is observed."""

    feature: wp.array[Feature]


def root_motion(d: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Place, rotation, velocity and angular velocity of the root in the world."""
    q, v, x = d["q"], d["v"], np.eye(3)[0]
    if d["root"] == ROOT_FREE:
        return q[:, :3], matrix(q[:, 3:7]), v[:, :3], v[:, 3:6]
    if d["root"] == ROOT_PLANAR:
        zero = np.zeros((N, 1))
        place, velocity = (np.concatenate([zero, of[:, :2]], axis=1) for of in (q, v))
        return place, matrix(turn_about(x, q[:, 2])), velocity, x * v[:, 2:3]
    return np.zeros((N, 3)), np.broadcast_to(np.eye(3), (N, 3, 3)), np.zeros((N, 3)), np.zeros((N, 3))


def head_motion(d: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and angular velocity of the head in the world, from the root outwards."""
    _, rotation, _, spin = root_motion(d)
    q, v = d["q"], d["v"]
    for body in range(1, len(TYPES)):
        c, s, a, b = d["first"][body], d["speed"][body], d["axis_a"][body], d["axis_b"][body]
        parent = rotation
        if TYPES[body] == BALL:
            rotation = parent @ matrix(q[:, c : c + 4])
            spin = spin + np.einsum("nij,nj->ni", rotation, v[:, s : s + 3])
        elif TYPES[body] == HINGE:
            rotation = parent @ matrix(turn_about(a, q[:, c]))
            spin = spin + (rotation @ a) * v[:, s : s + 1]
        elif TYPES[body] == UNIVERSAL:
            rotation = parent @ matrix(turn_about(b, q[:, c + 1])) @ matrix(turn_about(a, q[:, c]))
            spin = spin + (rotation @ a) * v[:, s : s + 1] + (parent @ b) * v[:, s + 1 : s + 2]
    return rotation, spin


def into(rotation: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors of the world in axes of a body."""
    return np.einsum("nij,ni->nj", rotation, v)


def yaw_of(rotation: np.ndarray) -> np.ndarray:
    """Angle of the turn about the vertical that is left without the turn about a horizontal axis."""
    return np.arctan2(rotation[:, 0, 2] - rotation[:, 2, 0], rotation[:, 0, 0] + rotation[:, 2, 2])


def rise(facing: np.ndarray, across: np.ndarray, along: np.ndarray) -> np.ndarray:
    """How much higher (N, k), m, the sloping ground is so far to the left and ahead of who faces there."""
    way = np.einsum("nij,kj->nki", facing, np.stack([across, np.zeros(len(across)), along], axis=1))
    return -(way @ np.array([NORMAL[0], 0.0, NORMAL[2]])) / NORMAL[1]


def test_every_kind_of_feature_is_what_it_is_called(drawn: dict[str, Any]):
    d = drawn
    place, rotation, velocity, spin = root_motion(d)
    yaw = yaw_of(rotation)
    facing = matrix(turn_about(UP, yaw))
    head, head_spin = head_motion(d)
    up = np.broadcast_to(UP, (N, 3))
    pushed = ((d["step"] >= 4) & (d["step"] < 8))[:, None]
    clock, turn = 2.0 * np.pi * d["clock"], d["heading"] - yaw
    forces = [into(facing, d["foot_force"][:, foot]) / WEIGHT for foot in (0, 1)]
    expected = {
        senses.HEIGHT: (place @ NORMAL - GROUND)[:, None], senses.UP: into(rotation, up),
        senses.VELOCITY: into(facing, velocity), senses.ANGULAR_VELOCITY: into(rotation, spin),
        senses.COORDINATE: d["q"], senses.JOINT_SPEED: d["v"], senses.FOOT_FORCE: np.concatenate(forces, axis=1),
        senses.ACTIVATION: d["activation"], senses.FIBRE_LENGTH: d["sensed"][:, :, 0] - 1.0,
        senses.FIBRE_VELOCITY: d["sensed"][:, :, 1], senses.FIBRE_FORCE: d["sensed"][:, :, 2],
        senses.COMMAND: d["command"],
        senses.COURSE: np.stack([np.sin(turn), np.cos(turn), np.clip(d["side"], -1.0, 1.0)], axis=1),
        senses.ACTION: np.clip(d["action"], LEAST, GREATEST), senses.PHASE: d["phase"][:, None],
        senses.STANCE: d["stance"][:, None],
        senses.PUSH_FORCE: np.where(pushed, d["push"] / WEIGHT, 0.0), senses.VARIED: d["varied"][d["variant"]],
        senses.HEAD_UP: into(head, up), senses.HEAD_ANGULAR_VELOCITY: into(head, head_spin),
        senses.CLOCK: np.stack([np.sin(clock), np.cos(clock)], axis=1), senses.CUSTOM: d["custom"],
        senses.GOAL: d["goal"],
        senses.GOAL_POINT: np.hstack([into(facing, d["goal"][:, k : k + 3] - place) for k in range(4)]),
        # three columns, 20 cm apart, from 40 cm behind on; strips to the right and left from 30 cm behind on
        senses.GROUND: rise(facing, np.tile([-0.2, 0.0, 0.2], 9), np.repeat(0.2 * np.arange(-2, 7), 3)),
        senses.FOOTING: rise(facing, np.tile([-0.1, 0.1], 12), np.repeat(0.1 * np.arange(-3, 9), 2)),
    }  # fmt: skip
    assert sorted(expected) == list(range(senses.LATER))
    features = [(kind, k) for kind, values in expected.items() for k in range(values.shape[1])]
    got = observed(d, features)
    for column, (kind, k) in enumerate(features):
        np.testing.assert_allclose(got[:, column], expected[kind][:, k], atol=3e-6, err_msg=f"{kind}, {k}")
    np.testing.assert_allclose(observed(d, features, 0.3), 0.3 * got, atol=1e-6)


def test_what_is_no_number_is_nothing_and_what_is_great_is_bounded(drawn: dict[str, Any]):
    phase = drawn["phase"].copy()
    phase[:5] = np.nan, np.inf, 1e4, -1e4, 99.0
    got = observed(drawn | {"phase": phase}, [(senses.PHASE, 0)])
    np.testing.assert_array_equal(got[:5, 0], [0.0, 0.0, 100.0, -100.0, 99.0])


SLOTS = 4


def test_what_is_told_is_as_old_as_the_delay_and_noise_has_its_deviation():
    delay, noise = np.array([0, 1, 3, 2]), np.array([0.0, 0.0, 0.0, 0.25])
    features = filled(Features, feature={"kind": np.full(4, senses.PHASE), "delay": delay, "noise": noise}).feature
    ring = np.random.default_rng(1).normal(size=(2000, SLOTS, 4)).astype(np.float32)
    result = wp.zeros((len(ring), 4), device="cpu")
    for decision in (5, 6, 7):
        episodes = filled(Episodes, decision=np.full(len(ring), decision), seed=[3])
        inputs = [features, wp.array(ring, dtype=float, device="cpu"), episodes, result]
        wp.launch(senses.observe, result.shape, inputs, device="cpu")
        for k in range(3):
            np.testing.assert_array_equal(result.numpy()[:, k], ring[:, (decision - delay[k]) % SLOTS, k])
        heard = result.numpy()[:, 3] - ring[:, (decision - 2) % SLOTS, 3]
        assert heard.std() == pytest.approx(0.25, rel=0.06)
        assert abs(heard.mean()) < 0.02


@pytest.mark.parametrize("grows", [0, 1])
def test_noise_and_delay_of_an_episode_reach_what_its_hardness_allows(grows: int):
    count, noisier, late = 4000, 0.4, 3
    hardness = np.where(np.arange(count) % 2, 1.0, 0.3)
    features = filled(
        Features,
        feature={
            "kind": [senses.NOISIER, senses.NOISIER, senses.LATER, senses.LATER], "scale": np.ones(4),
            "noisier": [0.0, noisier, 0.0, 0.0], "late": [0, 0, 0, late], "noisier_grows": np.full(4, grows),
            "late_grows": np.full(4, grows),
        },
    )  # fmt: skip
    episodes = filled(Episodes, seed=[3], number=np.arange(count), hardness=hardness)
    result = wp.zeros((count, 4), device="cpu")
    inputs = [features.feature, filled(State), episodes, filled(Surroundings), result]
    wp.launch(senses.observe_now, result.shape, inputs, device="cpu")
    noise, delay = result.numpy()[:, :2], result.numpy()[:, 2:]
    assert (noise[:, 0] == 0.0).all()
    assert (delay[:, 0] == 0.0).all()
    for of in np.unique(hardness):
        most = of if grows else 1.0
        drawn = noise[hardness == of, 1]
        assert 0.0 <= drawn.min() < 0.01 < 0.99 * most * noisier < drawn.max() <= most * noisier + 1e-6
        counted = np.bincount(delay[hardness == of, 1].astype(int), minlength=late + 1) / (count / 2)
        wanted = np.diff(np.minimum(np.arange(late + 2) / (most * late + 1.0), 1.0))
        np.testing.assert_allclose(counted, wanted, atol=0.04)


def test_an_episode_that_begins_was_ever_so_and_others_keep_what_they_sensed(drawn: dict[str, Any]):
    given = filled(Features, feature={"kind": [senses.PHASE, senses.CLOCK], "index": [0, 1], "scale": np.ones(2)})
    state, episodes, around = state_of(drawn)
    begins = np.arange(N) % 3 == 0
    episodes.mask = wp.array(begins, dtype=bool, device="cpu")
    ring = wp.full((N, SLOTS, 2), 7.0, device="cpu")
    wp.launch(senses.sample_first, (N, 2), [given.feature, state, episodes, around, ring], device="cpu")
    now = np.stack([drawn["phase"], np.cos(2.0 * np.pi * drawn["clock"])], axis=1)
    expected = np.where(begins[:, None, None], now[:, None, :], 7.0)
    np.testing.assert_allclose(ring.numpy(), np.broadcast_to(expected, ring.shape), atol=1e-6)


def test_every_kind_of_feature_has_a_value():
    """One that no function asks for would be observed as 0, or as another one."""
    text = inspect.getsource(senses)
    kinds = re.search(r"^\((.*?)\) = range\(", text, re.DOTALL | re.MULTILINE)[1].replace(",", " ").split()
    assert len(kinds) == senses.NOISIER + 1
    asked = set(re.findall(r"kind [=>]= ([A-Z_]+)", text))
    assert set(kinds) == asked


def test_a_kind_of_feature_without_a_value_is_named():
    source = inspect.getsource(senses)
    assert source.count("LATER, NOISIER,\n") == 1
    with pytest.raises(TypeError, match=r"the feature BREATH of .* has no value in feature_value"):
        senses.check_kinds(source.replace("LATER, NOISIER,", "LATER, NOISIER, BREATH,"))
