"""A model whose joints shift freely, and whose ligaments and contacts are left out, is said to fall apart, first."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.formats import Ignored, load

LIGAMENTS = "".join(
    f'<ClutchedPathSpring name="l{k}"><GeometryPath><PathPointSet><objects>{small.point("a", "femur", "0 0 0")}'
    f"{small.point('b', 'tibia', '0 0.1 0')}</objects></PathPointSet></GeometryPath></ClutchedPathSpring>\n"
    for k in range(3)
)
CONTACT = (
    '<Smith2018ArticularContactForce name="c"><socket_target_mesh>/contactgeometryset/bone</socket_target_mesh>'
    "<socket_casting_mesh>/contactgeometryset/other</socket_casting_mesh></Smith2018ArticularContactForce>"
)
SHAPES = (
    '<ContactGeometrySet><objects><Smith2018ContactMesh name="bone"><socket_frame>/bodyset/tibia</socket_frame>'
    '</Smith2018ContactMesh><Smith2018ContactMesh name="other"><socket_frame>/bodyset/femur</socket_frame>'
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
    assert "knee (6 free coordinates) lost 3 ClutchedPathSpring, 1 Smith2018ArticularContactForce" in first
    assert sum("cannot stand" in other for other in others) == 0


def test_joints_that_do_not_shift_and_those_that_lost_nothing_are_not_loose(tmp_path: Path):
    for kind, forces in (("PinJoint", LIGAMENTS + CONTACT), ("FreeJoint", "")):
        assert not any("cannot stand" in reason for reason in notes_on(tmp_path, kind, forces))


SIX = ("rx", "ry", "rz", "tx", "ty", "tz")
BONES = "".join(small.body(name, center="0 -0.2 0") for name in ("femur", "tibia", "patella"))
HIP = small.joint("PinJoint", "hip", "ground", "femur", small.coordinate("q"))
LINE = '<LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction>'
SPLINE = small.spline("SimmSpline", "-1 0 1", "0 0.01 0.03")


def six(name: str, parent: str, child: str, more: str = "", locked: tuple[str, ...] = ()) -> str:
    """A custom joint of six coordinates, some of them locked."""
    own = {axis: f"{name}_{axis}" for axis in SIX}
    coordinates = "".join(
        small.coordinate(own[axis], "<locked>true</locked>" if axis in locked else more) for axis in SIX
    )
    ways = ("1 0 0", "0 1 0", "0 0 1")
    axes = {f"rotation{k + 1}": (own[SIX[k]], ways[k], LINE) for k in range(3)}
    axes |= {f"translation{k + 1}": (own[SIX[3 + k]], ways[k], LINE) for k in range(3)}
    return small.joint("CustomJoint", name, parent, child, coordinates, small.axes(**axes))


def rolling(more: str = "") -> str:
    """A knee as gait2392 has it, which shifts as it turns."""
    axes = small.axes(rotation1=("knee", "0 0 1", LINE), translation1=("knee", "1 0 0", SPLINE))
    return small.joint("CustomJoint", "knee", "femur", "tibia", small.coordinate("knee", more), axes)


def patella(joint: str = "WeldJoint") -> str:
    """What carries the patella."""
    count = {"WeldJoint": 0, "PlanarJoint": 3, "SliderJoint": 1}[joint]
    coordinates = "".join(small.coordinate(f"p{k}") for k in range(count))
    return small.joint(joint, "pf", "femur", "patella", coordinates)


def band(kind: str, first: str = "femur", second: str = "tibia", more: str = "") -> str:
    """A ligament between two bones."""
    points = small.point("a", first, "0 0 0") + small.point("b", second, "0 0.1 0")
    path = f"<GeometryPath><PathPointSet><objects>{points}</objects></PathPointSet></GeometryPath>"
    return f'<{kind} name="{first}_{second}">{path}{more}</{kind}>'


def hunt_crossley(first: str, second: str) -> str:
    """Contact of two shapes."""
    return (
        '<HuntCrossleyForce name="touch"><HuntCrossleyForce::ContactParametersSet name="contact_parameters">'
        f"<objects><HuntCrossleyForce::ContactParameters><geometry>{first} {second}</geometry>"
        "</HuntCrossleyForce::ContactParameters></objects></HuntCrossleyForce::ContactParametersSet>"
        "</HuntCrossleyForce>"
    )


def shape(kind: str, name: str, bone: str) -> str:
    """A shape on a bone."""
    more = "<radius>0.02</radius>" if kind == "ContactSphere" else ""
    return f'<{kind} name="{name}"><socket_frame>/bodyset/{bone}</socket_frame>{more}</{kind}>'


def bushing(expression: str) -> str:
    """A bushing between two bones."""
    frames = "".join(f"<socket_frame{k}>/bodyset/{b}</socket_frame{k}>" for k, b in ((1, "femur"), (2, "tibia")))
    return (
        f'<ExpressionBasedBushingForce name="disc">{frames}<Fx_expression>{expression}</Fx_expression>'
        "</ExpressionBasedBushingForce>"
    )


def shapes(*members: str) -> str:
    return f"<ContactGeometrySet><objects>{''.join(members)}</objects></ContactGeometrySet>"


SPHERES = shapes(shape("ContactSphere", "s1", "femur"), shape("ContactSphere", "s2", "tibia"))
MESHES = shapes(shape("ContactMesh", "s1", "femur"), shape("ContactSphere", "s2", "tibia"))
TWO_MESHES = shapes(shape("ContactMesh", "s1", "femur"), shape("ContactMesh", "s2", "tibia"))
KNEE = six("knee", "femur", "tibia")
STRANGE = "ClutchedPathSpring"
ELASTIC = (
    '<ElasticFoundationForce name="e"><ElasticFoundationForce::ContactParametersSet name="contact_parameters"><objects>'
    "<ElasticFoundationForce::ContactParameters><geometry>s1 s2</geometry></ElasticFoundationForce::ContactParameters>"
    "</objects></ElasticFoundationForce::ContactParametersSet></ElasticFoundationForce>"
)
OFF = "<appliesForce>false</appliesForce>"
MODELS: dict[str, tuple[str, str, str, str]] = {  # joints, forces, shapes, and what the first note says of the knee
    "ligament": (KNEE + patella(), band(STRANGE), "", "knee (6 free coordinates) lost 1 ClutchedPathSpring"),
    "meshes": (KNEE + patella(), ELASTIC, TWO_MESHES, "knee (6 free coordinates) lost 1 ElasticFoundationForce"),
    "spheres": (KNEE + patella(), hunt_crossley("s1", "s2"), SPHERES, "knee (6 free coordinates) lost 1 HuntCrossley"),
    "mesh": (KNEE + patella(), hunt_crossley("s1", "s2"), MESHES, "knee (6 free coordinates) lost 1 HuntCrossley"),
    "stiffening bushing": (KNEE + patella(), bushing("1e4*delta_x^3"), "", ""),
    "planar patella": (
        rolling() + patella("PlanarJoint"), band(STRANGE, "patella"), "", "pf (3 free coordinates) lost 1",
    ),
    "sliding patella": (
        rolling() + patella("SliderJoint"), band(STRANGE, "patella"), "", "pf (1 free coordinate) lost 1",
    ),
    "both": (
        KNEE + patella("PlanarJoint"), band(STRANGE) + band(STRANGE, "patella"), "",
        "knee (6 free coordinates) lost 2 ClutchedPathSpring; pf (3 free coordinates) lost 1 ClutchedPathSpring",
    ),
    "partly locked": (
        six("knee", "femur", "tibia", locked=("ty", "tz", "rx")) + patella(), band(STRANGE), "",
        "knee (3 free coordinates) lost 1",
    ),
    "locked": (six("knee", "femur", "tibia", locked=("tx", "ty", "tz")) + patella(), band(STRANGE), "", ""),
    "prescribed": (
        six("knee", "femur", "tibia", "<prescribed>true</prescribed><prescribed_function><Constant><value>0</value>"
            "</Constant></prescribed_function>") + patella(), band(STRANGE), "", "",
    ),
    "rolling": (rolling() + patella(), band(STRANGE), "", ""),
    "known ligament": (KNEE + patella(), band("Ligament"), "", ""),
    "straight bushing": (KNEE + patella(), bushing("1e4*delta_x"), "", ""),
    "switched off": (KNEE + patella(), band(STRANGE, more=OFF), "", ""),
    "elsewhere": (KNEE + patella(), band(STRANGE, "ground", "patella"), "", ""),
}  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
def test_knees_of_many_kinds(tmp_path: Path, name: str):
    joints, forces, geometry, expected = MODELS[name]
    ignored: list[Ignored] = []
    load(small.written(tmp_path, small.model(BONES, HIP + joints, forces, geometry)), ignored=ignored)
    told = [one.reason for one in ignored if "cannot stand" in one.reason]
    if not expected:
        assert not told
        return
    assert expected in ignored[0].reason
    assert told == [ignored[0].reason]
