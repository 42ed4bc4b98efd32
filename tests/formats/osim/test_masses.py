"""Masses as files have them: none, negative moments, and coordinates that move nothing heavy."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.inverse_dynamics import joint_space

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


def mass_matrix(path: Path, angle: float) -> float:
    """Moment of inertia about the first pin that OpenSim computes, kg m^2."""
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(path))
    state = model.initSystem()
    model.getCoordinateSet().get(0).setValue(state, angle)
    model.realizePosition(state)
    matrix = opensim.Matrix()
    model.getMatterSubsystem().calcM(state, matrix)
    return float(matrix.get(0, 0))


@pytest.mark.parametrize(
    ("mass", "inertia", "reason"),
    [
        (0.0, "1 1 1 0 0 0", "an inertia and no mass"),
        (0.5, "-0.2 0.1 0.1 0 0 0", "no body has moments"),
        (0.5, "0.1 0.1 0.1 0.3 0 0", "no body has moments"),
    ],
)
def test_odd_inertia_is_what_opensim_computes_with(tmp_path: Path, mass: float, inertia: str, reason: str):
    bodies = small.body("rod", 2.0, center="0 -0.5 0", inertia="0.5 0.1 0.5 0 0 0") + small.body(
        "odd", mass, center="0.1 -0.1 0", inertia=inertia
    )
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"), turn="0.4 0.3 0") + small.joint(
        "WeldJoint", "weld", "rod", "odd", place="0 -1 0", turn="0.3 0 0.2"
    )
    path, ignored = small.written(tmp_path, small.model(bodies, joints)), list[Ignored]()
    scene = load(path, ignored=ignored)
    assert [note.line for note in ignored if reason in note.reason] == [6]
    found = joint_space(scene, np.array([[*(0.0,) * 6, 1.0, 0.3]])).mass_matrix[0, 0, 0]
    assert found == pytest.approx(mass_matrix(path, 0.3), rel=1e-6)


def test_a_negative_mass_is_refused(tmp_path: Path):
    with pytest.raises(SceneError, match="a mass of -1 is none"):
        load(small.written(tmp_path, small.pendulum().replace("<mass>1.0<", "<mass>-1<")), ignored=[])


def test_a_coordinate_that_moves_nothing_heavy_is_held(tmp_path: Path):
    bodies = small.body("rod", center="0 -0.5 0") + small.body("hand", 0.0, inertia="0 0 0 0 0 0")
    start = "<default_value>0.4</default_value>"
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q")) + small.joint(
        "PinJoint", "wrist", "rod", "hand", small.coordinate("w", start), place="0 -1 0"
    )
    muscle = small.muscle("m", small.point("a", "rod", "0.1 -0.9 0") + small.point("b", "hand", "0.1 -0.1 0"))
    ignored: list[Ignored] = []
    scene = load(small.written(tmp_path, small.model(bodies, joints, muscle)), ignored=ignored)
    assert any("held where the model starts" in note.reason for note in ignored)
    scene.duration = 0.05
    rollout = Rollout(scene, 1, device="cpu")
    rollout.run()
    q = rollout.state.coordinates.numpy()[0]
    assert q[list(rollout.coordinate_names).index("w")] == pytest.approx(0.4, abs=1e-6)
    assert np.isfinite(q).all()


def test_a_model_without_any_mass_can_be_posed(tmp_path: Path):
    text = small.pendulum(
        forces=small.muscle("m", small.point("a", "ground", "0.1 0 0") + small.point("b", "rod", "0 -1 0"))
    )
    text = text.replace("<mass>1.0<", "<mass>0<")
    scene = load(small.written(tmp_path, text), ignored=[])
    scene.duration = 0.02
    rollout = Rollout(scene, 1, device="cpu")
    rollout.run()
    assert np.isfinite(rollout.state.coordinates.numpy()).all()


def test_locked_coordinates_of_a_planar_root_stay_out(tmp_path: Path):
    transform = small.axes(
        rotation1=("tilt", "0 0 1", small.LINE), rotation2=("list", "1 0 0", small.LINE),
        rotation3=("turn", "0 1 0", small.LINE), translation1=("tx", "1 0 0", small.LINE),
        translation2=("ty", "0 1 0", small.LINE), translation3=("tz", "0 0 1", small.LINE),
    )  # fmt: skip
    locked = "<locked>true</locked>"
    coordinates = "".join(small.coordinate(n, locked if n in ("list", "turn", "tz") else "") for n in
        ("tilt", "list", "turn", "tx", "ty", "tz"))  # fmt: skip
    joint = small.joint("CustomJoint", "root", "ground", "pelvis", coordinates, transform)
    scene = load(small.written(tmp_path, small.model(small.body("pelvis"), joint)), ignored=[])
    assert scene.character.root_joint == "planar"
    assert scene.opensim is not None
    assert scene.opensim.root_coordinates == ["tilt", "tx", "ty"]
    assert set(scene.opensim.locked) == {"list", "turn", "tz"}


def test_moments_one_by_one_count_in_old_layouts_alone(tmp_path: Path):
    moments = "<inertia_xx>0.1</inertia_xx><inertia_yy>0.2</inertia_yy><inertia_zz>0.3</inertia_zz>"
    bodies = small.body("rod", 2.0, center="0 -0.5 0").replace("<inertia>1 2 2 0 0 0</inertia>", moments)
    joints = small.joint("PinJoint", "hip", "ground", "rod", small.coordinate("q"))
    ignored: list[Ignored] = []
    path = small.written(tmp_path, small.model(bodies, joints))
    scene = load(path, ignored=ignored)
    assert any(note.text == "inertia_xx" for note in ignored)
    found = joint_space(scene, np.array([[*(0.0,) * 6, 1.0, 0.0]])).mass_matrix[0, 0, 0]
    np.testing.assert_allclose(found, 0.5, rtol=1e-4)
    np.testing.assert_allclose(mass_matrix(path, 0.0), 0.5, rtol=1e-12)
