"""Muscles of old and simple classes: along their own paths, with their numbers, and Thelen's curves; it is told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load, save
from warpmuscle.formats.osim.build_muscles import AT_ONCE
from warpmuscle.scene import SplineCurves

PATH = small.point("a", "ground", "0.1 0 0") + small.point("b", "rod", "0 -0.5 0")
TENDON = small.spline("SimmSpline", "-10 0 0.02 0.06 20", "0 0 0.5 1.5 400")
FIBRE = small.spline("NaturalCubicSpline", "-5 1 1.15 1.15 1.5 5", "0 0 0 0 2 2")  # with a knot twice, as files have it
OLD = (
    "<time_scale>0.2</time_scale><activation1>7</activation1><activation2>1</activation2><damping>0.05</damping>"
    "<max_contraction_velocity>0</max_contraction_velocity>"
    + TENDON.replace('"function"', '"tendon_force_length_curve"')
    + f"<passive_force_length_curve>{FIBRE}</passive_force_length_curve>"
)


def made(folder: Path, kind: str, more: str) -> tuple[dict[str, Any], list[Ignored]]:
    """The values of a muscle, those that it shares with all others among them, and the notes."""
    ignored: list[Ignored] = []
    path = small.written(folder, small.pendulum(forces=small.muscle("m", PATH, kind=kind, more=more)))
    scene = load(path, ignored=ignored)
    muscle = scene.character.muscles["m"]
    assert len(muscle.path) == 2
    names = (
        "f_max",
        "l_opt",
        "l_slack",
        "v_max",
        "rise_time",
        "fall_time",
        "tendon_strain",
        "passive_strain",
        "tendon",
    )
    own = {name: getattr(muscle, name) for name in names}
    return {name: getattr(scene.muscle_model, name) if one is None else one for name, one in own.items()}, ignored


@pytest.mark.parametrize("kind", ["Schutte1993Muscle_Deprecated", "Schutte1993Muscle", "Delp1990Muscle_Deprecated"])
def test_old_muscles_keep_their_numbers_and_strains(tmp_path: Path, kind: str):
    found, ignored = made(tmp_path, kind, OLD)
    assert (found["f_max"], found["l_opt"], found["l_slack"]) == (500.0, 0.1, 0.2)
    assert found["v_max"] == pytest.approx(5.0)  # a fibre length in a fifth of a second
    assert found["rise_time"] == pytest.approx(0.2 / 8.0)
    assert found["fall_time"] == pytest.approx(0.2)
    assert [note.text for note in ignored if "has its own curves" in note.reason] == [f"{kind} m"]


def test_old_muscles_have_the_curves_of_their_file_and_their_damping(tmp_path: Path):
    path = small.written(tmp_path, small.pendulum(forces=small.muscle("m", PATH, kind="Schutte1993Muscle", more=OLD)))
    model = load(path, ignored=[]).muscle_model
    assert (model.activation, model.damping) == ("excited_rise", 0.05)
    shape = model.curve_shape
    assert isinstance(shape, SplineCurves)
    assert shape.tendon.x == [-10.0, 0.0, 0.02, 0.06, 20.0]
    assert shape.passive.x == [-5.0, 1.0, 1.15, 1.5, 5.0]  # without the knot that comes twice
    assert shape.active.y[11] == 0.993333  # OpenSim's default
    assert shape.velocity is None


def test_a_passive_curve_that_is_not_given_is_schuttes_exponential(tmp_path: Path):
    path = small.written(tmp_path, small.pendulum(forces=small.muscle("m", PATH, kind="Schutte1993Muscle")))
    shape = load(path, ignored=[]).muscle_model.curve_shape
    assert isinstance(shape, SplineCurves)
    at = dict(zip(shape.passive.x, shape.passive.y, strict=True))
    assert at[1.5] == pytest.approx(1.0)
    assert at[1.0] == pytest.approx(np.exp(-4.0))


def test_a_muscle_with_a_curve_that_is_not_known_is_taken_as_one_of_thelens(tmp_path: Path):
    inner = "<ExpressionBasedFunction><expression>x</expression></ExpressionBasedFunction>"
    curve = f"<active_force_length_curve>{inner}</active_force_length_curve>"
    found, ignored = made(tmp_path, "Schutte1993Muscle", OLD + curve)
    assert found["tendon_strain"] == pytest.approx(0.04, abs=1e-4)
    assert found["passive_strain"] == pytest.approx(0.325, abs=5e-4)
    assert [note.text for note in ignored if "taken as a Thelen2003Muscle" in note.reason] == ["Schutte1993Muscle m"]


def test_a_muscle_with_a_rigid_tendon_has_one(tmp_path: Path):
    found, ignored = made(tmp_path, "RigidTendonMuscle", "")
    assert (found["f_max"], found["l_opt"], found["l_slack"]) == (500.0, 0.1, 0.2)
    assert found["tendon"] == "rigid"
    assert found["rise_time"] == found["fall_time"] == AT_ONCE
    assert any("its activation is its excitation at once" in note.reason for note in ignored)


def test_times_that_are_none_are_refused_with_their_line(tmp_path: Path):
    with pytest.raises(SceneError, match="must be greater than 0") as caught:
        made(tmp_path, "Schutte1993Muscle", OLD.replace("<time_scale>0.2<", "<time_scale>0<"))
    assert caught.value.line > 0


def test_a_point_counts_where_a_curve_of_another_coordinate_is_in_its_range(tmp_path: Path):
    curve = small.spline("SimmSpline", "-2 -1 0 1 2", "-0.8 -0.1 0 0.1 0.8").replace(' name="function"', "")
    coupler = (
        "<ConstraintSet><objects><CoordinateCouplerConstraint name='c'><coupled_coordinates_function>" + curve
        + "</coupled_coordinates_function><independent_coordinate_names>q</independent_coordinate_names>"
        "<dependent_coordinate_name>w</dependent_coordinate_name></CoordinateCouplerConstraint></objects></ConstraintSet>"
    )  # fmt: skip
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q")) + small.joint(
        "PinJoint", "wrist", "rod", "hand", small.coordinate("w"), place="0 -1 0"
    )
    point = (
        '<ConditionalPathPoint name="p"><socket_parent_frame>/bodyset/rod</socket_parent_frame><location>0.05 -0.3 0'
        "</location><socket_coordinate>/jointset/wrist/w</socket_coordinate><range>0.1 9</range></ConditionalPathPoint>"
    )
    force = small.muscle("m", small.point("a", "ground", "0.1 0 0") + point + small.point("b", "rod", "0 -0.5 0"))
    text = small.model(small.body("rod", center="0 -0.5 0") + small.body("hand"), joints, force, coupler)
    condition = (
        load(small.written(tmp_path, text), ignored=[], hard_points=True).character.muscles["m"].path[1].condition
    )
    assert condition is not None
    assert condition.joint == "q"
    assert condition.low == pytest.approx(1.0, abs=2e-4)  # where the spline's knot has 0.1, less OpenSim's margin
    assert float(condition.high) > 100.0  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["Schutte1993Muscle_Deprecated", "RigidTendonMuscle"])
def test_muscles_with_curves_through_knots_come_back_from_opensims_file(tmp_path: Path, kind: str):
    more = OLD.replace("<max_contraction_velocity>0<", "<max_contraction_velocity>8<")
    path = small.written(tmp_path, small.pendulum(forces=small.muscle("m", PATH, kind=kind, more=more)))
    scene = load(path, ignored=[])
    lost: list[Ignored] = []
    save(scene, tmp_path / "again.osim", ignored=lost)
    again = load(tmp_path / "again.osim", ignored=[])
    assert again.muscle_model == scene.muscle_model
    assert again.character.muscles == scene.character.muscles
    assert not [note for note in lost if "muscles" in note.text]


def test_an_older_thelen_muscle_is_one_with_its_own_defaults(tmp_path: Path):
    own = "<Vmax>8</Vmax><Vmax0>4</Vmax0><damping>0.05</damping>"
    found, ignored = made(tmp_path, "Thelen2003Muscle_Deprecated", own)
    values = [found[name] for name in ("v_max", "tendon_strain", "passive_strain", "rise_time", "fall_time")]
    assert values == pytest.approx([8.0, 0.033, 0.6, 0.01, 0.04])
    assert [note.text for note in ignored if "is taken as a Thelen2003Muscle" in note.reason] == [
        "Thelen2003Muscle_Deprecated m"
    ]


def test_a_muscle_whose_fibre_has_mass_is_one_without(tmp_path: Path):
    own = "<mass>0.1</mass><fiber_damping>0.02</fiber_damping>"
    own += "<fiber_force_length_damping>0.01</fiber_force_length_damping>"
    found, ignored = made(tmp_path, "Millard2012AccelerationMuscle", own)
    assert (found["f_max"], found["l_opt"], found["l_slack"]) == (500.0, 0.1, 0.2)
    assert not [note for note in ignored if "damping" in note.text]
    assert any("its fibre has no mass" in note.reason for note in ignored)
