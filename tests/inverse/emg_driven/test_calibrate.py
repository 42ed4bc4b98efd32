"""EMG-driven muscles: parameters of a synthetic subject come back, held-out moments are foretold, bad input is told."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from small_leg import loads, motion, small_leg
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics, prepare
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.emg_driven.calibrate import calibrate
from warpmuscle.inverse.emg_driven.parameters import Bounds, ParameterCube
from warpmuscle.inverse.trial import Coordinates, Loads, Plate
from warpmuscle.scene.muscles import given

KNEE = ("rectus", "hamstrings", "gastrocnemius")
TRUTH = {"rectus": 0.8, "hamstrings": 1.3, "gastrocnemius": 1.0}  # factors of f_max
DELAY = 0.05  # s
RISE, FALL = 0.01, 0.04  # s
BOUNDS = Bounds(gain=(1.0, 1.0), shape=(-0.1, -0.1), l_opt=(1.0, 1.0), l_slack=(1.0, 1.0))


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def bursts(times: np.ndarray, phase: float) -> np.ndarray:
    return 0.25 + 0.2 * np.sin(7.0 * times + phase)


def activation(times: np.ndarray, phase: float) -> np.ndarray:
    """Activation under delayed bursts in small steps, Thelen 2003, and shaped with A = -0.1."""
    at, fine, found = times[0] - 0.3, 0.0002, []
    a = float(bursts(np.array([at - DELAY]), phase)[0])
    for time in times:
        while at < time - 1e-9:
            u = float(bursts(np.array([at - DELAY]), phase)[0])
            tau = RISE * (0.5 + 1.5 * a) if u > a else FALL / (0.5 + 1.5 * a)
            a += fine * (u - a) / tau
            at += fine
        found.append(a)
    return (np.exp(-0.1 * np.array(found)) - 1.0) / (np.exp(-0.1) - 1.0)


def subject(body: BodyModel, seed: int) -> tuple[Coordinates, Loads, Emg]:
    """A motion, EMG, and a plate whose moment about the knee leaves just what the true muscles make of it."""
    recorded = motion(60, seed=seed)
    times = recorded.times
    trials = prepare(body, recorded, None, None, None)
    frames = body.muscle_frames(trials.states, slice(0, len(times)))
    arm, speed = frames.moment_arm.numpy(), int(body.map.speed[body.map.names.index("knee_angle")])
    active, passive = frames.active.numpy(), frames.passive.numpy()
    made = np.zeros(len(times))
    for lever in np.flatnonzero(body.lever_speed == speed):
        m = int(body.lever_muscle[lever])
        name = body.muscles[m]
        force = TRUTH[name] * (activation(times, 2.0 * KNEE.index(name)) * active[:, m] + passive[:, m])
        made += arm[:, lever] * force
    moments = inverse_dynamics(body, recorded)
    assert isinstance(moments.values, np.ndarray)
    more = made - moments.of("knee_angle")  # by a pure moment on the shank, about the knee's axis
    return recorded, _moment_on_shank(body, recorded, more), Emg(
        KNEE, np.linspace(-0.5, 0.8, 1301),
        np.stack([bursts(np.linspace(-0.5, 0.8, 1301), 2.0 * k) for k in range(3)], axis=1),
    )  # fmt: skip


def _moment_on_shank(body: BodyModel, recorded: Coordinates, more: np.ndarray) -> Loads:
    """Loads, ground axes, with which the knee needs so much more, found from what a moment along each axis does."""
    count = len(recorded.times)
    nothing = np.zeros((count, 3))
    without = inverse_dynamics(body, recorded).of("knee_angle")
    does = np.zeros((count, 3))
    for axis in range(3):
        unit = nothing + np.eye(3)[axis]
        plate = Loads(recorded.times, (Plate("plate", "tibia_r", nothing, nothing, unit),))
        does[:, axis] = inverse_dynamics(body, recorded, plate).of("knee_angle") - without
    moment = does * (more / np.sum(does**2, axis=1))[:, None]
    return Loads(recorded.times, (Plate("plate", "tibia_r", nothing, nothing, moment),))


@pytest.fixture(scope="module")
def found(body):
    trials = [subject(body, seed) for seed in (0, 1)]
    motions, plates, signals = (list(part) for part in zip(*trials, strict=True))
    return calibrate(body, motions, signals, plates, of=["knee_angle"], bounds=BOUNDS, members=4, generations=60)


def test_the_synthetic_subject_has_the_models_time_constants(body):
    muscle = body.muscle("rectus")
    times = (given(muscle, body.scene.muscle_model, name) for name in ("rise_time", "fall_time"))
    assert tuple(times) == (RISE, FALL)


def test_strengths_and_delay_of_a_synthetic_subject_come_back(found):
    assert found.measured == KNEE or set(found.measured) == set(KNEE)
    for name, truth in TRUTH.items():
        low, middle, high = (one[found.body.muscles.index(name)] for one in found.band("f_max"))
        assert middle == pytest.approx(truth, abs=0.03), name
        assert low <= middle <= high
    assert found.band("delay")[1] == pytest.approx(DELAY, abs=0.003)
    assert "delay" not in found.at_bounds
    ended = replace(found, parameters=found.parameters | {"delay": np.full(4, found.bounds.delay[0])})
    assert ended.at_bounds == ["delay", *found.at_bounds]
    assert found.rms[0] < 0.01 * np.abs(np.concatenate(found.wanted)).max()


def test_another_trial_is_foretold(found, body):
    recorded, plate, signal = subject(body, 2)
    ((moments, wanted),) = found.predict(recorded, signal, plate)
    assert moments.shape == (4, 60, 1)
    late = slice(10, None)
    away = np.sqrt(np.mean((moments[0] - wanted)[late] ** 2))
    assert away < 0.03 * np.abs(wanted).max()


def test_the_scene_has_the_medians(found):
    scene = found.scene()
    before = found.body.scene.character.muscles["rectus"].f_max
    middle = float(found.band("f_max")[1][found.body.muscles.index("rectus")])
    assert scene.character.muscles["rectus"].f_max == pytest.approx(before * middle)
    assert scene.character.muscles["iliacus"].f_max == found.body.scene.character.muscles["iliacus"].f_max
    assert msgspec.structs.asdict(scene)["name"] == found.body.scene.name


def test_points_of_the_cube_are_parameters():
    cube = ParameterCube(Bounds(shape=(-0.1, -0.1)), np.array([1, 0, 1]))
    assert cube.size == 1 + 4 * 2
    low, high = cube.values(np.zeros((1, 9))), cube.values(np.ones((1, 9)))
    assert low["delay"] == pytest.approx([0.01])
    assert low["gain"][0] == pytest.approx([0.5, 1.0, 0.5])
    assert high["l_slack"][0] == pytest.approx([1.1, 1.0, 1.1])
    middle = cube.values(cube.start[None])
    assert middle["f_max"][0] == pytest.approx([1.0, 1.0, 1.0])
    assert middle["shape"][0, [0, 2]] == pytest.approx([-0.1, -0.1])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"of": ["elbow"]}, "no coordinate 'elbow'"),
        ({"of": "knee_angle"}, "name the coordinates"),
        ({"of": ["ankle_angle"], "muscles": ("rectus",)}, "no muscle with EMG acts on 'ankle_angle'"),
        ({"muscles": ("biceps",)}, "no muscle"),
        ({"bounds": Bounds(delay=(0.2, 0.1))}, "bounds of delay"),
        ({"members": 0}, "members are 1 to"),
        ({"end": 0.1}, "the EMG reaches from"),
        ({"twice": True}, "EMG of 2 trials, and coordinates of 1"),
    ],
)
def test_what_cannot_be_done_is_one_line(body, changes, said):
    recorded = motion(20)
    names, end = changes.pop("muscles", ("rectus",)), changes.pop("end", 1.0)
    signal = Emg(names, np.linspace(0.0, end, 50), np.full((50, len(names)), 0.3))
    signals = [signal] * 2 if changes.pop("twice", False) else signal
    with pytest.raises(ArgumentError, match=said):
        calibrate(body, recorded, signals, loads(recorded.times), **({"of": ["knee_angle"]} | changes))
