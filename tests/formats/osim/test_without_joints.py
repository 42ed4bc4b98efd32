"""Models in which nothing moves: those without bodies, as some files of surfaces are, and those that are all welded."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
import warpmuscle as wm
from warpmuscle.core.errors import Error
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.sto import write

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

WELDED = small.model(small.body("rod", center="0 0.2 0"), small.joint("WeldJoint", "held", "ground", "rod"))


@pytest.mark.parametrize(("text", "bodies"), [(small.model("", ""), 1), (WELDED, 2)])
def test_they_load_and_stay_and_have_no_coordinates_to_write(tmp_path: Path, text: str, bodies: int):
    ignored: list[Ignored] = []
    scene = load(small.written(tmp_path, text), ignored=ignored)
    assert len(scene.character.bodies) == bodies
    assert any("has no bodies" in note.reason for note in ignored) == (bodies == 1)
    scene.duration = 0.05
    rollout = wm.Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    motion = rollout.recording()
    assert motion.frames > 2
    assert np.isfinite(motion.com).all()
    with pytest.raises(Error, match="nothing of small moves, so that there are no coordinates to write"):
        write(motion, scene, tmp_path / "small.mot")
