"""A model of OpenSim simulated here moves as OpenSim moves it."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.scene import Failure
from warpmuscle.scene.topology import coordinate_names, topology
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
# rad, after 0.1 s without control, from the default pose with muscles at equilibrium: OpenSim 4.6 with an accuracy of
# 1e-7. Steps of 1e-4 s come within 1e-4 rad.
AFTER = {"hip_flexion_r": -0.02866, "knee_angle_r": 0.005721, "ankle_angle_r": -0.093322, "hip_flexion_l": -0.02866,
    "knee_angle_l": 0.005721, "ankle_angle_l": -0.093322, "lumbar_extension": -0.027807}  # fmt: skip


@pytest.mark.filterwarnings("ignore")
def test_gait10dof18musc_falls_as_in_opensim(reference_data: Path):
    path = reference_data / "opensim_models" / "gait10dof18musc.osim"
    if not path.is_file():
        pytest.skip(f"no model {path}")
    scene = msgspec.structs.replace(load(path), duration=0.1, failure=Failure(com_height=0.0, heading=0.0))
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    names, _ = coordinate_names(topology(scene.character), scene.character)
    found = dict(zip(names, rollout.state.coordinates.numpy()[0], strict=True))
    np.testing.assert_allclose([found[name] for name in AFTER], list(AFTER.values()), atol=6e-4)
