"""Excitations of a motion by points, turns, the centre of mass, patterns, and legs of their own, against NumPy."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from gait_state_rules import LIMITS, expected_state
from probes import evaluate, matrix, units

import small_scone
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.formats.scone.parameters import Parameter, read_parameters, write_parameters
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.kernels.algebra.random_numbers import EXCITATION, random_of
from warpmuscle.kernels.control import gait_sensors
from warpmuscle.kernels.gait_state_structs import BALANCE, FIBRE_FORCE, FIBRE_LENGTH, FIBRE_VELOCITY, LEAN, TURN
from warpmuscle.model.controllers.gait_states import Terms
from warpmuscle.results.recording import Recording
from warpmuscle.scene import GaitReflex, Scene
from warpmuscle.scene.gait_states.part import SensedBalance, SensedTurn
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.scene.treadmill.part import Treadmill
from warpmuscle.simulation.rollout import Rollout

VALUES = {
    "leg0_l.stance_load_threshold": 0.05, "leg1_r.stance_load_threshold": 0.2,
    "S11111.calf_l-trunk_l.KP": 1.2, "S11111.calf_r-trunk_r.KP": 0.9,
    "S11111.calf_l-trunk_l.KA": 0.005, "S11111.calf_r-trunk_r.KA": -0.006,
    "S11111.seat_l-leg_o_l.KP": 0.4, "S11111.seat_r-leg_o_r.KP": -0.6,
    "S00111.seat_r-foot_r.KP": -0.9,
    "S11000.calf_l.Y0": 0.3, "S11000.calf_l.Y1": 0.1, "S11000.calf_l.Y2": 0.2,
    "S11000.calf_r.Y0": 0.05, "S11000.calf_r.Y1": 0.25, "S11000.calf_r.Y2": 0.0,
    "S11000.calf_l.DT0": 0.04, "S11000.calf_l.DT1": 0.06, "S11000.calf_r.DT0": 0.03, "S11000.calf_r.DT1": 0.05,
}  # fmt: skip


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    folder = tmp_path_factory.mktemp("senses")
    path = small_scone.write(folder, controller=small_scone.SENSES)
    write_parameters(folder / "best.par", [Parameter(name, value, value, 0.1) for name, value in VALUES.items()])
    notes: list = []
    scene = load(path, folder / "best.par", ignored=notes)
    assert not [note for note in notes if note.file.suffix == ".par"]  # all of them have their number
    return scene


@pytest.fixture(scope="module")
def motion(scene: Scene) -> Recording:
    rollout = Rollout(scene, record=[0], record_rate=1.0 / scene.time_step, device="cpu")
    rollout.run()
    return rollout.recording(0)


def test_legs_of_their_own_have_numbers_of_their_own_and_give_them_back(scene: Scene, tmp_path: Path):
    assert {one.name for one in free_parameters(scene)} >= {
        "gait_states.stance_load", "gait_states.right.stance_load", "gait_states.patterns.S11000_calf_r.values.1",
    }  # fmt: skip
    assert scene.gait_states is not None
    assert scene.gait_states.right is not None
    assert scene.gait_states.right.stance_load == Free(0.2, min=0.001, max=1.0)
    lost: list = []
    save(scene, tmp_path / "out.par", lost)
    assert lost == []
    found = {name: one.best for name, one in read_parameters(tmp_path / "out.par").items()}
    assert {name: value for name, value in found.items() if not name.endswith(".offset")} == VALUES
    assert loads(dumps(scene)) == scene


def along(motion: Recording, body: str, axis: int = 2) -> np.ndarray:
    return motion.body_position[:, motion.body_names.index(body), axis]


def speed(motion: Recording, name: str) -> np.ndarray:
    return motion.speed[:, motion.speed_names.index(name)]


def turning(motion: Recording, body: str) -> np.ndarray:
    """Angular velocity about x, to the left; joints turn about SCONE's z, to the right."""
    kind, _, side = body.partition("_")
    joints = {"trunk": [], "leg": ["thigh"], "foot": ["thigh", "foot"]}[kind]
    return speed(motion, "root.turn") - sum((speed(motion, f"{joint}_{side}") for joint in joints), np.zeros(()))


def velocity(motion: Recording, body: str) -> np.ndarray:
    """Velocity (F, 2) of a body's centre of mass, up and forwards, from joint to joint."""

    def carried(of: str, offset: tuple[float, float]) -> np.ndarray:
        turned = matrix(motion.body_orientation[:, motion.body_names.index(of)]) @ np.array([0.0, *offset])
        spin = turning(motion, of)
        return np.stack([-spin * turned[:, 2], spin * turned[:, 1]], axis=1)

    kind, _, side = body.partition("_")
    found = np.stack([speed(motion, "root.y"), speed(motion, "root.z")], axis=1)
    if kind in ("leg", "foot"):
        found = found + carried("trunk", (-0.3, 0.0)) - carried(f"leg_{side}", (0.4, 0.0))
    if kind == "foot":
        found = found + carried(f"leg_{side}", (-0.45, 0.0)) - carried(body, (0.04, -0.05))
    return found


def test_excitations_are_those_of_what_is_sensed_a_delay_ago(scene: Scene, motion: Recording):
    """The formulas are those of SCONE's reflexes: gain (target - value), of what was a delay ago."""
    frames = np.arange(1, len(motion.time) - 1, 5)
    trunk = motion.body_names.index("trunk")
    turned = matrix(motion.body_orientation[:, trunk]) @ np.array([0.0, 0.2, 0.1])  # x left, y up, z forwards
    height = motion.body_position[:, trunk, 1] + turned[:, 1]
    rise = velocity(motion, "trunk")[:, 0] - turning(motion, "trunk") * turned[:, 2]
    feet = 0.5 * (along(motion, "foot_l") + along(motion, "foot_r"))
    forwards = {s: velocity(motion, f"foot_{s}")[:, 1] for s in "lr"}
    ahead = motion.com[:, 2] - feet
    passing = motion.com_velocity[:, 2] - 0.5 * (forwards["l"] + forwards["r"])
    balance = np.maximum(-0.8 * (0.05 - ahead), 0.0) - 0.05 * (0.0 - passing)
    stood = states_of(motion, frames)
    for side, (s, other, gain, lean) in enumerate((("l", "r", 1.2, 0.4), ("r", "l", 0.9, -0.6))):
        leg = motion.body_orientation[:, motion.body_names.index(f"leg_{other}")]
        angle = -2.0 * np.arctan2(leg[:, 0], leg[:, 3])  # about SCONE's z, to the right
        rate = -turning(motion, f"leg_{other}")
        pivot = along(motion, f"foot_{s}")
        over, fast = motion.com[:, 2] - pivot, motion.com_velocity[:, 2] - forwards[s]
        calf, seat, began = [], [], -1
        for k, frame in enumerate(frames):
            late, later, last = (frames[max(k - n, 0)] for n in (3, 2, 1))  # 15, 10 and 5 ms
            gained = 0.5 * (rise[later] - rise[late]) / 0.005  # over the control step that ended 10 ms ago
            total = 0.3 + gain * (0.65 - 0.5 * height[later]) - 0.3 * (0.2 - 0.5 * rise[later])
            total += VALUES[f"S11111.calf_{s}-trunk_{s}.KA"] * (1.5 - gained)
            total += balance[frame]
            swings = stood[k][side] in (4, 5)
            began = (k if began < 0 else began) if swings else -1
            if swings:
                x = np.cumsum([0.0, *(VALUES[f"S11000.calf_{s}.DT{n}"] for n in range(2))])
                y = [VALUES[f"S11000.calf_{s}.Y{n}"] for n in range(3)]
                time = 0.005 * (k - began)
                slope = (y[2] - y[1]) / (x[2] - x[1])
                total += np.interp(time, x, y) + slope * max(time - x[2], 0.0)
            calf.append(total)
            total = 0.25 + lean * (0.4 - angle[last]) + max(0.02 * (0.0 - rate[last]), 0.0)
            if s == "r" and not swings:
                total += -0.9 * (0.0 - over[late]) - 0.1 * (0.5 - fast[late])
            seat.append(total)
        assert {stood[k][side] for k in range(len(frames))} >= {4}
        names = list(motion.muscle_names)
        for name, told in ((f"calf_{s}", calf), (f"seat_{s}", seat)):
            got = motion.muscle_excitation[frames, names.index(name)]
            np.testing.assert_allclose(got, np.clip(told, 0.01, 1.0), atol=1e-3)
            assert np.ptp(got) > 0.05


def states_of(motion: Recording, frames: np.ndarray) -> list[list[int]]:
    """States of both legs, by the rules of `test_gait_states`, each at its own threshold."""
    now, found, weight = [0, 0], [], 9.81 * (40.0 + 2.0 * 9.5)
    force = np.stack([motion.foot_force_left, motion.foot_force_right], axis=1)
    thresholds = (0.05, 0.2)
    for frame in frames:
        ahead = [along(motion, f"foot_{s}")[frame] - along(motion, "trunk")[frame] for s in "lr"]
        load = np.linalg.norm(force[frame], axis=1) / weight
        before, now = now, [0, 0]
        for s in range(2):
            own = LIMITS | {"stance_load": thresholds[s], "swing_load": thresholds[s], "landing": 0.0}
            own |= {"liftoff": -math.hypot(0.05, 0.49)}  # of the leg's length
            other = 1.0 if load[1 - s] > thresholds[1 - s] else 0.0
            now[s] = expected_state(before[s], ahead[s], ahead[1 - s], load[s], other, own)
        found.append(now)
    return found


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("turn", None, "angle_gain: needs a `joint` or a `turn` to sense"),
        ("side", "right", ""),
        ("joint", "root", "turn: an angle is sensed of a joint or of a body's turn, not of both"),
    ],
)
def test_what_senses_nothing_or_two_things_is_named(scene: Scene, key: str, value: object, said: str):
    changed = loads(dumps(scene))
    assert changed.gait_states is not None
    setattr(changed.gait_states.reflexes["S11111_seat_l-leg_o_l"], key, value)
    if not said:
        assert loads(dumps(changed)) == changed
        return
    with pytest.raises(SceneError, match=re.escape(said)):
        loads(dumps(changed))


def test_what_is_sensed_of_a_mirrored_motion_is_the_same_on_the_other_side(scene: Scene):
    """Mirrored in the sagittal plane, x to the left, a rotation (x, y, z, w) becomes (x, -y, -z, w)."""
    changed = loads(dumps(scene))
    assert changed.gait_states is not None
    reflexes = changed.gait_states.reflexes
    reflexes.clear()
    reflexes["turn"] = GaitReflex("seat", during=["swing"], angle_gain=1.0, turn=SensedTurn("leg", (0.3, -0.5, 0.8)))
    reflexes["over"] = GaitReflex("calf", during=["swing"], position_gain=1.0, balance=SensedBalance((0.6, 0.0, 0.8)))
    plain = substitute(changed, start_values(changed))
    terms = Terms(plain.gait_states, plain, topology(plain.character), list(plain.character.muscles))
    axes = {kind: [one.along for one in terms.sensors if one.kind == kind] for kind in (TURN, BALANCE)}
    q = units(50, 6, 4)
    mirrored = q * (1.0, -1.0, -1.0, 1.0)
    left, right = (evaluate(gait_sensors.turned_about, *pair) for pair in zip((mirrored, q), axes[TURN], strict=True))
    np.testing.assert_allclose(left, right, atol=1e-5)
    assert np.ptp(right) > 1.0
    left, right = (
        evaluate(gait_sensors.level_direction, *pair) for pair in zip((mirrored, q), axes[BALANCE], strict=True)
    )
    np.testing.assert_allclose(left * (-1.0, 1.0, 1.0), right, atol=1e-4)


def test_of_a_fibre_only_what_is_beyond_its_offset_counts_and_of_an_angle_what_the_term_adds(scene: Scene):
    changed = loads(dumps(scene))
    assert changed.gait_states is not None
    reflexes = changed.gait_states.reflexes
    reflexes.clear()
    reflexes["brake"] = GaitReflex(
        "calf", during=["swing"], length_gain=-0.6, force_gain=0.4, velocity_gain=-0.1, positive=["length", "velocity"]
    )
    reflexes["lean"] = GaitReflex("seat", during=["swing"], joint="root", angle_gain=1.0, positive=["angle"])
    plain = substitute(changed, start_values(changed))
    found = Terms(plain.gait_states, plain, topology(plain.character), list(plain.character.muscles))
    terms = {(found.sensors[one.sensor].kind, one.positive) for own in found.terms for one in own if one.sensor >= 0}
    assert terms == {(FIBRE_LENGTH, 2), (FIBRE_FORCE, 0), (FIBRE_VELOCITY, 2), (LEAN, 1)}


def test_noise_adds_to_excitations_and_is_the_same_for_all_candidates(tmp_path: Path):
    found = []
    for name, text in (("plain", small_scone.SENSES), ("noisy", small_scone.with_noise())):
        (tmp_path / name).mkdir()
        scene = load(small_scone.write(tmp_path / name, controller=text), ignored=[])
        scene.duration = 0.003
        rollout = Rollout(scene, 2, record=[0, 1], record_rate=1.0 / scene.time_step, device="cpu")
        rollout.run()
        found.append([rollout.recording(k).muscle_excitation[1] for k in range(2)])
    (plain, _), (noisy, other) = found
    np.testing.assert_array_equal(noisy, other)
    expected = [evaluate(drawn, muscle, 7)[0] for muscle in range(4)]
    np.testing.assert_allclose(noisy - plain, expected, atol=1e-6)
    assert np.abs(expected).max() > 0.02


@wp.func
def drawn(muscle: int, seed: int) -> float:
    return wp.float32(0.05) * wp.randn(random_of(seed, muscle, 0, EXCITATION))


def test_how_fast_the_centre_of_mass_goes_is_not_known_on_a_treadmill(scene: Scene):
    changed = loads(dumps(scene))
    changed.ground.treadmill = Treadmill()
    with pytest.raises(SceneError, match="on a treadmill"):
        loads(dumps(changed))
