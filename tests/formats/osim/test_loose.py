"""A model whose joints shift freely, and whose ligaments and contacts are left out, is said to fall apart, first."""

from pathlib import Path

import osim_models as small
from warpmuscle.formats import Ignored, load

LIGAMENTS = "".join(
    f'<Blankevoort1991Ligament name="l{k}"><GeometryPath><PathPointSet><objects>{small.point("a", "femur", "0 0 0")}'
    f"{small.point('b', 'tibia', '0 0.1 0')}</objects></PathPointSet></GeometryPath></Blankevoort1991Ligament>\n"
    for k in range(3)
)
CONTACT = (
    '<Smith2018ArticularContactForce name="c"><socket_target_mesh>/contactgeometryset/bone</socket_target_mesh>'
    "</Smith2018ArticularContactForce>"
)
SHAPES = (
    '<ContactGeometrySet><objects><Smith2018ContactMesh name="bone"><socket_frame>/bodyset/tibia</socket_frame>'
    "</Smith2018ContactMesh></objects></ContactGeometrySet>"
)


def notes_on(folder: Path, kind: str, forces: str) -> list[str]:
    coordinates = "".join(
        map(small.coordinate, ("kx", "ky", "kz", "rx", "ry", "rz")[: 6 if kind == "FreeJoint" else 1])
    )
    joints = small.joint("PinJoint", "hip", "ground", "femur", small.coordinate("q"))
    joints += small.joint(kind, "knee", "femur", "tibia", coordinates)
    bodies = small.body("femur", center="0 -0.2 0") + small.body("tibia", center="0 -0.2 0")
    ignored: list[Ignored] = []
    load(small.written(folder, small.model(bodies, joints, forces, SHAPES)), ignored=ignored)
    return [one.reason for one in ignored]


def test_first_note_says_which_joints_lost_what(tmp_path: Path):
    first, *others = notes_on(tmp_path, "FreeJoint", LIGAMENTS + CONTACT)
    assert "this model cannot stand" in first
    assert "knee (6 free coordinates) lost 3 Blankevoort1991Ligament, 1 Smith2018ArticularContactForce" in first
    assert sum("cannot stand" in other for other in others) == 0


def test_joints_that_do_not_shift_and_those_that_lost_nothing_are_not_loose(tmp_path: Path):
    for kind, forces in (("PinJoint", LIGAMENTS + CONTACT), ("FreeJoint", "")):
        assert not any("cannot stand" in reason for reason in notes_on(tmp_path, kind, forces))
