"""Bodies, joints, forces and constraints among loose components are those of the same model in its sets."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.formats import Ignored, load, save

BODIES = small.body("upper", center="0 -0.1 0")
JOINTS = small.joint("PinJoint", "hip", "ground", "upper", small.coordinate("a"))
LOWER = small.body("lower", center="0 -0.1 0")
KNEE = small.joint("PinJoint", "knee", "upper", "lower", small.coordinate("b"), place="0 -0.3 0")
POINTS = small.point("p", "upper", "0.02 -0.1 0") + small.point("q", "lower", "0.02 -0.1 0")
MUSCLE = small.muscle("m", POINTS)
SPRING = (
    '<SpringGeneralizedForce name="s"><coordinate>a</coordinate><stiffness>3</stiffness><rest_length>0.1</rest_length>'
    "<viscosity>0.2</viscosity></SpringGeneralizedForce>"
)
FORCES = MUSCLE + SPRING
COUPLER = (
    '<CoordinateCouplerConstraint name="c"><coupled_coordinates_function>'
    "<LinearFunction><coefficients>0.5 0.1</coefficients></LinearFunction></coupled_coordinates_function>"
    "<independent_coordinate_names>a</independent_coordinate_names>"
    "<dependent_coordinate_name>b</dependent_coordinate_name></CoordinateCouplerConstraint>"
)
COUPLERS = f"<ConstraintSet><objects>{COUPLER}</objects></ConstraintSet>"
SETS = small.model(BODIES + LOWER, JOINTS + KNEE, FORCES, COUPLERS)


def moved(text: str) -> str:
    """What hangs on the lower body, with the addresses that it has where OpenSim's sets do not hold it."""
    return text.replace("/bodyset/lower", "/lower")


def within(holder: str) -> str:
    """The model of `SETS` with a part of it in another place."""
    parts = LOWER + KNEE + FORCES + COUPLER
    if holder == "components":
        return small.model(BODIES, JOINTS, more=f"<components>{moved(parts)}</components>")
    if holder == "ComponentSet":
        loose = parts.replace("/bodyset/lower", "/componentset/lower")
        return small.model(BODIES, JOINTS, more=f"<ComponentSet><objects>{loose}</objects></ComponentSet>")
    owned = parts.replace("/bodyset/lower", "/bodyset/upper/lower")
    owned = owned.replace("<socket_parent>/bodyset/upper</socket_parent>", "<socket_parent>../..</socket_parent>")
    return small.model(small.body("upper", center="0 -0.1 0", more=f"<components>{owned}</components>"), JOINTS)


def read(folder: Path, text: str) -> tuple[str, list[Ignored]]:
    ignored: list[Ignored] = []
    scene = load(small.written(folder, text), ignored=ignored)
    save(scene, folder / "scene.toml")
    return (folder / "scene.toml").read_text(), ignored


@pytest.mark.parametrize("holder", ["components", "ComponentSet", "body"])
def test_loose_components_are_those_of_their_sets(tmp_path: Path, holder: str):
    text, ignored = read(tmp_path, within(holder))
    assert text == read(tmp_path, SETS)[0]
    assert not [note for note in ignored if "not used" in note.reason or "not known" in note.reason]


def test_a_loose_force_that_is_not_known_is_told_as_one_that_pulls_on_nothing(tmp_path: Path):
    unknown = '<components><ClutchedPathSpring name="w"></ClutchedPathSpring></components>'
    _, ignored = read(tmp_path, small.model(BODIES, JOINTS, more=unknown))
    (note,) = [note for note in ignored if note.text == "ClutchedPathSpring w"]
    assert "pulls on nothing" in note.reason
