"""Models without joints, or with none that moves or leads from the ground: they stay, or move freely."""

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


PIN = small.joint("PinJoint", "pin", "rod", "tip", small.coordinate("q"), place="0 0.4 0")
SIDE = small.joint("PinJoint", "side", "rod", "end", small.coordinate("s"), place="0 0.1 0")
BACK = small.joint("PinJoint", "back", "tip", "rod", small.coordinate("q"), place="0 0.4 0")


@pytest.mark.parametrize(
    ("joints", "base"),
    [  # as OpenSim 4.6 chooses, which calls the joint free_rod or so
        (PIN + SIDE, "rod"),
        (PIN + small.joint("PinJoint", "p", "end", "tip", small.coordinate("s"), place="0 0.1 0"), "end"),
        (BACK + SIDE, "tip"),
        (SIDE, "tip"),
    ],
)
def test_bodies_that_hang_on_no_ground_get_one_free_joint(tmp_path: Path, joints: str, base: str):
    bodies = "".join(small.body(name, center="0 0.1 0") for name in ("end", "rod", "tip"))
    if joints == SIDE:
        joints += small.joint("PinJoint", "held", "ground", "rod", small.coordinate("h"))
    ignored: list[Ignored] = []
    found = load(small.written(tmp_path, small.model(bodies, joints)), ignored=ignored)
    own = tuple(f"free_{base}_coord_{k}" for k in range(6))
    free = f'<FreeJoint name="free_{base}"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>'
    free += f"/bodyset/{base}</socket_child_frame><coordinates>{''.join(map(small.coordinate, own))}</coordinates>"
    said = load(small.written(tmp_path, small.model(bodies, joints + free + "</FreeJoint>")))
    assert [note.text for note in ignored if "no joint leads to it" in note.reason] == [f"Body {base}"]
    assert set(own) <= {*found.opensim.root_coordinates, *found.character.joints}
    assert found.character.bodies == said.character.bodies
    assert {name: joint.child for name, joint in found.character.joints.items()} == {
        name: joint.child for name, joint in said.character.joints.items()
    }
