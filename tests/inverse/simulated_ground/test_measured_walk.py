"""A measured walk that runs forward on the ground from excitations, beside its recording and its plates."""

import numpy as np

from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.tracking.track import track
from warpmuscle.inverse.tracking.tracked import Tracked


def test_a_measured_walk_runs_on_the_ground(reference_data):
    folder = reference_data / "opensim_walk"
    body = BodyModel(folder / "cmc" / "subject01_metabolics.osim", "cpu")
    recorded = read_coordinates(folder / "cmc" / "walk_subject_Kinematics_q.sto", body.scene)
    plates = read_loads(folder / "subject01_walk_grf.xml")
    found = track(body, recorded, plates, filter=6.0, begin=0.6, end=1.85, ground=True)
    assert isinstance(found, Tracked)
    turns = [k for k, unit in enumerate(found.units) if unit == "rad"]
    assert found.lost is None
    assert np.degrees(found.rms[turns]).max() < 1.5
    pushed = {name for name, most in zip(found.names, found.greatest_effort, strict=True) if most > 0.1}
    assert pushed == {"lumbar_extension"}  # which no muscle crosses
    assert -1.2 < found.ground.belt[2] < -1.0
    for side in (0, 1):
        up, measured = found.ground.force[:, side, 1], found.ground.plates[:, side, 1]
        assert np.corrcoef(up, measured)[0, 1] > 0.9
