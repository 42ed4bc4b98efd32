"""Muscles under EMG: activations in float64, and forces of a model that has a candidate's numbers as its own."""

import msgspec
import numpy as np
import pytest
import warp as wp

from small_leg import motion, small_leg
from warpmuscle.core.arrays import to_device
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.emg_driven.moments import EmgMoments
from warpmuscle.kernels.inverse import emg_driven as kernels

STEP, CANDIDATES, MUSCLES = 0.01, 2, 3
RISE, FALL = np.array([0.012, 0.015, 0.02]), np.array([0.05, 0.06, 0.04])
BEGIN = (0, 7, 12)  # frames of two trials
TIMES = np.r_[0.043 + 0.004 * np.arange(7), 0.1 + 0.013 * np.arange(5)]
SCALES = {"f_max": 1.3, "l_opt": 1.15, "l_slack": 0.93}


def candidates() -> dict[str, np.ndarray]:
    random = np.random.default_rng(3)
    values = {name: random.uniform(0.7, 1.6, (CANDIDATES, MUSCLES)) for name in ("gain", *SCALES)}
    return {"delay": np.array([0.013, 0.041]), "shape": random.uniform(-2.5, -0.2, (CANDIDATES, MUSCLES)), **values}


def envelopes() -> np.ndarray:
    return np.random.default_rng(4).uniform(0.0, 0.8, (2, 22, MUSCLES))


def activations_in_float64(emg: np.ndarray, told: np.ndarray) -> np.ndarray:
    """a' = (u - a)/tau with the delayed envelope of each sample's middle, its tau that of the sample's begin."""
    values, found = candidates(), np.zeros((CANDIDATES, len(TIMES), MUSCLES))
    middles = STEP * (np.arange(emg.shape[1]) + 0.5)
    for c, trial in np.ndindex(CANDIDATES, 2):
        frames = slice(BEGIN[trial], BEGIN[trial + 1])
        for m in range(2):
            samples = STEP * np.arange(emg.shape[1])
            heard = np.interp(middles - values["delay"][c], samples, emg[trial, :, m])
            u = np.clip(values["gain"][c, m] * heard, 0.0, 1.0)
            a = u[0]
            for begin, wanted in zip(samples, u, strict=True):
                slow = 0.5 + 1.5 * a
                tau = RISE[m] * slow if wanted > a else FALL[m] / slow

                def later(after, a=a, wanted=wanted, tau=tau):
                    return wanted + (a - wanted) * np.exp(-after / tau)

                now = (begin <= TIMES) & (begin + STEP > TIMES)
                now[: frames.start] = now[frames.stop :] = False
                shape = values["shape"][c, m]
                found[c, now, m] = np.expm1(shape * later(TIMES[now] - begin)) / np.expm1(shape)
                a = later(STEP)
        found[c, frames, 2] = told[frames, 2]
    return found


def test_activations_are_those_of_delayed_signals_in_float64():
    emg, told = envelopes(), np.random.default_rng(5).uniform(0.1, 0.9, (len(TIMES), MUSCLES))
    known = kernels.Recordings()
    known.begin, known.time = to_device(BEGIN, int, "cpu"), to_device(TIMES, float, "cpu")
    known.emg, known.estimated, known.step = to_device(emg, float, "cpu"), to_device(told, float, "cpu"), STEP
    known.measured = to_device([1, 1, 0], int, "cpu")
    known.rise_time, known.fall_time = to_device(RISE, float, "cpu"), to_device(FALL, float, "cpu")
    given = kernels.Candidates()
    for name, values in candidates().items():
        setattr(given, name, to_device(values, float, "cpu"))
    found = wp.zeros((CANDIDATES, len(TIMES), MUSCLES), dtype=float, device="cpu")
    wp.launch(kernels.emg_activations, (CANDIDATES, 2, MUSCLES), [known, given], [found], device="cpu")
    wanted = activations_in_float64(emg, told)
    assert np.ptp(wanted[:, :, :2], axis=1).min() > 0.05
    np.testing.assert_allclose(found.numpy(), wanted, atol=2e-5)


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def scaled(body: BodyModel, scales: dict[str, float]) -> BodyModel:
    """The model whose muscles have these factors in their own numbers."""
    character = body.scene.character
    muscles = {
        name: msgspec.structs.replace(one, **{field: scale * getattr(one, field) for field, scale in scales.items()})
        for name, one in character.muscles.items()
    }
    return BodyModel(
        msgspec.structs.replace(body.scene, character=msgspec.structs.replace(character, muscles=muscles)), "cpu"
    )


def test_moments_of_a_candidate_are_those_of_a_model_with_its_numbers(body):
    recorded = motion(12)
    trials, speeds = prepare(body, recorded, None, None, None), np.array([6, 9])
    told = np.random.default_rng(6).uniform(0.1, 0.9, (12, len(body.muscles)))
    silent = Emg(("rectus",), np.linspace(-0.5, 0.8, 200), np.zeros((200, 1)))
    of = EmgMoments(body, trials, [silent], told, speeds, np.zeros((12, 2)))
    every = np.ones((2, len(body.muscles)))
    parameters = {name: np.stack([every[0], scale * every[1]]) for name, scale in SCALES.items()}
    parameters |= {"delay": np.full(2, 0.02), "gain": every, "shape": -0.5 * every}
    activation, moment = (array.numpy().astype(float) for array in of.moments(parameters))
    rectus = body.muscles.index("rectus")
    assert activation[:, :, rectus] == pytest.approx(0.0, abs=1e-6)
    for c, model in enumerate((body, scaled(body, SCALES))):
        frames = model.muscle_frames(trials.states, slice(0, 12))
        arm, active, passive = (getattr(frames, name).numpy() for name in ("moment_arm", "active", "passive"))
        force = activation[c] * active + passive
        for k, speed in enumerate(speeds):
            levers = np.flatnonzero(body.lever_speed == speed)
            wanted = np.sum(arm[:, levers] * force[:, body.lever_muscle[levers]], axis=1)
            np.testing.assert_allclose(moment[c, :, k], wanted, rtol=2e-4, atol=0.02)
    assert np.abs(moment[1] - moment[0]).max() > 5.0
