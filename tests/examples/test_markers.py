"""Markers of the example stand where its angles say."""

import numpy as np
import pytest

from warpmuscle.examples import write
from warpmuscle.examples.motions import COLUMNS, THROWS
from warpmuscle.markers.arm import Choices, arm_angles
from warpmuscle.markers.files import read_markers

BESIDE = {
    "elbow": "RELB+RELBM", "wrist": "RWRA+RWRB", "hand_thumb": "RFIN1", "hand_little": "RFIN5", "shoulder": "RSHO",
    "other_shoulder": "LSHO", "hip": "RASI", "other_hip": "LASI",
}  # fmt: skip


@pytest.mark.parametrize(
    ("file", "throw", "choices"),
    [
        ("markers/throw1.csv", 0, Choices(low_pass=0.0, before=None)),
        ("trial.trc", 2, Choices(markers=BESIDE, up="y", forward="x", low_pass=0.0, before=None)),
    ],
)
def test_angles_of_the_example_come_back(file, throw, choices, tmp_path):
    write("markers", tmp_path)
    found = arm_angles(read_markers(tmp_path / file), choices).columns()
    for name in ("shoulder_deg", "elbow_deg", "wrist_deg"):
        meant = THROWS[throw][:, COLUMNS.index(name)]
        np.testing.assert_allclose(found[name][-len(meant) :], meant, atol=0.1)
