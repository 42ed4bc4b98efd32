"""A motion and its character, both written for OpenSim: OpenSim poses the model where the recording has it."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from opensim_table import table
from warpmuscle.formats import load, save, sto
from warpmuscle.simulation.rollout import Rollout

opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
CLOSE = 1e-5  # m


@pytest.mark.parametrize("name", ["fwalk", "walk56_person", "reflex_planar", "bigbird_walk"])
def test_bodies_are_where_the_recording_has_them(name: str, tmp_path: Path):
    opensim.Logger.setLevelString("error")
    scene = msgspec.structs.replace(load(name), duration=0.6)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    motion = rollout.recording()
    save(scene, tmp_path / "model.osim", [])
    sto.write(motion, scene, tmp_path / "motion.mot")
    model = opensim.Model(str(tmp_path / "model.osim"))
    state = model.initSystem()
    _, names, rows = table(tmp_path / "motion.mot")
    coordinates = model.getCoordinateSet()
    theirs = {coordinates.get(k).getName() for k in range(coordinates.getSize())}
    assert set(names) - {"time"} == theirs
    bodies = model.getBodySet()
    for frame in (0, len(rows) // 2, len(rows) - 1):
        for column, value in zip(names[1:], rows[frame, 1:], strict=True):
            coordinate = coordinates.get(column)
            turns = coordinate.getMotionType() == opensim.Coordinate.Rotational
            coordinate.setValue(state, np.radians(value) if turns else value, False)
        model.realizePosition(state)
        for number, body in enumerate(motion.body_names):
            found = bodies.get(body).findStationLocationInGround(state, bodies.get(body).getMassCenter())
            place = np.array([-found.get(2), found.get(1), found.get(0)])
            np.testing.assert_allclose(place, motion.body_position[frame, number], atol=CLOSE, err_msg=body)
