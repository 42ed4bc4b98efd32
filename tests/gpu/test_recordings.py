"""Steps from recordings to muscles: on a GPU as on a CPU, and the same bits alone and in a batch."""

import warnings

import numpy as np
import pytest
import warp as wp

import warpmuscle as wm
from leg_model import chain_of, leg, markers_of, walk
from small_leg import loads, motion, small_leg
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.reactions.joint_reactions import joint_reactions
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.inverse.trial import Coordinates, TrialWarning

BATCH = 40  # recordings of which one is also taken alone

on_each = pytest.mark.parametrize(
    "device", [pytest.param("cuda:0", marks=pytest.mark.gpu), pytest.param("cpu", marks=pytest.mark.long)]
)


@on_each
def test_inverse_kinematics_is_that_of_the_cpu_and_the_same_alone_and_in_a_batch(tmp_path, device: str):
    _there(device)
    scene = leg(tmp_path)
    chain = chain_of(scene)
    trials = [markers_of(chain, walk(chain, 20 + k % 23, seed=k), noise=0.005) for k in range(BATCH)]
    trials[7].positions[4:9, 2] = np.nan
    with warnings.catch_warnings(action="ignore", category=TrialWarning):
        found = wm.inverse_kinematics(scene, trials, device=device)
        alone = [wm.inverse_kinematics(scene, trials[k], device=device) for k in (7, 30)]
        cpu = wm.inverse_kinematics(scene, trials, device="cpu")
    for k, one in zip((7, 30), alone, strict=True):
        assert one.coordinates.values.tobytes() == found[k].coordinates.values.tobytes()
        assert one.missed.tobytes() == found[k].missed.tobytes()
    for one, other in zip(found, cpu, strict=True):
        assert np.abs(one.coordinates.values - other.coordinates.values).max() < 2e-4
        assert np.nanmax(one.rms) < 0.01
        assert one.notes == other.notes


@on_each
def test_muscles_and_reactions_are_those_of_the_cpu_and_the_same_alone_and_in_a_batch(tmp_path, device: str):
    _there(device)
    file, at = small_leg(tmp_path), motion()
    random, force = np.random.default_rng(3), loads(at.times)
    shifts = 0.01 * random.normal(size=(BATCH, at.values.shape[1]))
    motions = [Coordinates(at.names, at.times, at.values + shift) for shift in shifts]
    results = {}
    for place in dict.fromkeys((device, "cpu")):
        body = BodyModel(file, place)
        with warnings.catch_warnings(action="ignore", category=TrialWarning):
            many = static_optimization(body, motions, [force] * BATCH, reserve=10.0)
            one = static_optimization(body, motions[17], force, reserve=10.0)
            reactions = joint_reactions(body, motions, [force] * BATCH, many)
            reaction = joint_reactions(body, motions[17], force, one)
        assert one.activation.tobytes() == many[17].activation.tobytes()
        assert reaction.force.tobytes() == reactions[17].force.tobytes()
        assert not any(each.unconverged for each in many)
        results[place] = many, reactions
    own, cpu = results[device], results["cpu"]
    most = max(np.abs(each.force).max() for each in cpu[1])
    for a, b, c, d in zip(own[0], cpu[0], own[1], cpu[1], strict=True):
        assert np.abs(a.activation - b.activation).max() < 1e-4
        assert np.abs(c.force - d.force).max() < 1e-4 * most


def _there(device: str) -> None:
    if device != "cpu" and not wp.get_cuda_devices():
        pytest.skip("there is no GPU here")
