"""Batches of copies of a recorded motion, each with its own excitations and parameters."""

import numpy as np
import pytest

from warpmuscle.scene.parameters import start_values
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.motion import ArmMotion, resample
from warpmuscle.throw.simulator import Simulator


def test_muscles_are_built_anew_only_where_their_parameters_change(
    arm_and_motion: tuple[Arm, ArmMotion], monkeypatch: pytest.MonkeyPatch
):
    """And copies move as those of a simulator that has had nothing before."""
    arm, motion = arm_and_motion
    built: list[np.ndarray] = []
    set_parameters = Rollout.set_parameters

    def counted(rollout: Rollout, values: np.ndarray) -> None:
        built.append(values)
        set_parameters(rollout, values)

    monkeypatch.setattr(Rollout, "set_parameters", counted)
    usual = start_values(arm.scene)
    stronger = np.where([p.name.endswith("f_max") for p in arm.parameters], 2.0 * usual, usual)
    simulator, motions = Simulator(arm, resample([motion])), resample([motion])
    excitation = np.linspace(0.05, 0.3, 2 * len(arm.muscles)).reshape(2, -1, 1)

    def run(one: Simulator, values: np.ndarray, factor: float) -> np.ndarray:
        return one.run(np.zeros(2, dtype=np.intp), np.zeros(1), factor * excitation, values, until=0.1)[0]

    found = [run(simulator, *given) for given in ((usual, 1.0), (usual, 0.5), (stronger, 1.0), (usual, 1.0))]
    assert len(built) == 3
    np.testing.assert_array_equal(found[0], found[3])
    for one, given in zip(found, ((usual, 1.0), (usual, 0.5), (stronger, 1.0)), strict=False):
        np.testing.assert_array_equal(one, run(Simulator(arm, motions), *given))
    assert np.abs(found[0] - found[1]).max() > 1e-3 < np.abs(found[0] - found[2]).max()


def test_parameters_that_are_changed_in_place_are_noticed(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    values = np.array(start_values(arm.scene))
    simulator, excitation = Simulator(arm, resample([motion])), np.full((1, len(arm.muscles), 1), 0.2)
    first = simulator.run(np.zeros(1, dtype=np.intp), np.zeros(1), excitation, values, until=0.1)[0]
    values[[p.name.endswith("f_max") for p in arm.parameters]] *= 2.0
    second = simulator.run(np.zeros(1, dtype=np.intp), np.zeros(1), excitation, values, until=0.1)[0]
    assert np.abs(second - first).max() > 1e-3
