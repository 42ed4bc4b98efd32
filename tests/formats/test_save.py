"""What the original program's files cannot hold is said before any of them is written."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save


def test_nothing_is_written_where_the_files_could_not_be_read_again(tmp_path: Path):
    bodies = small.body("base", 1.0) + small.body("rod", 0.0, inertia="0 0 0 0 0 0")
    joints = small.joint("WeldJoint", "fixed", "ground", "base")
    joints += small.joint("PinJoint", "pin", "base", "rod", small.coordinate("q"))
    scene = load(small.written(tmp_path, small.model(bodies, joints)), ignored=[])  # holds the rod where it starts
    before = set(tmp_path.iterdir())
    with pytest.raises(SceneError, match=r"\.rbs, \.rs cannot hold it: joint 'q' moves nothing that has mass"):
        save(scene, tmp_path / "out.rbs", [])
    assert set(tmp_path.iterdir()) == before
