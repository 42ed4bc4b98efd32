"""Muscles, paths, surfaces and forces of OpenSim models as those of scenes."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from fuzzing.models import LEG

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.osim.build_muscles import powers
from warpmuscle.formats.osim.frames import turned
from warpmuscle.formats.osim.functions import ENDLESS, Function, span_within
from warpmuscle.formats.osim.placement import WORLD
from warpmuscle.scene import (
    ContactMaterial,
    CylinderSurface,
    EllipsoidSurface,
    MillardCurves,
    Scene,
    Sphere,
    ThelenCurves,
)
from warpmuscle.scene.topology import topology
from warpmuscle.studies.moment_arms import muscle_geometry

WELD = small.joint("WeldJoint", "weld", "ground", "base", own="0.1 0.2 0.3", own_turn="0.3 0.4 0.5")
PIN = small.joint("PinJoint", "pin", "base", "rod", small.coordinate("q"))
BODIES = small.body("base", center="0.01 0.02 0.03") + small.body("rod", center="0 -0.5 0")
POINTS = small.point("a", "base", "0.1 0 0") + small.point("b", "rod", "0 -0.3 0.02")


def scene_of(folder: Path, forces: str, more: str = "", bodies: str = BODIES, joints: str = WELD + PIN) -> Scene:
    return load(small.written(folder, small.model(bodies, joints, forces, more)), ignored=[])


@pytest.fixture
def leg(tmp_path: Path) -> Scene:
    """A model that has something of everything."""
    path = tmp_path / "leg.osim"
    path.write_text(LEG)
    return load(path, ignored=[])


def test_points_are_from_the_centre_of_mass_in_our_axes(tmp_path: Path):
    (muscle,) = scene_of(tmp_path, small.muscle("m", POINTS)).character.muscles.values()
    axes = WORLD @ turned([0.3, 0.4, 0.5]).T
    np.testing.assert_allclose(muscle.path[0].position, axes @ [0.09, -0.02, -0.03], atol=1e-15)
    np.testing.assert_allclose(muscle.path[1].position, axes @ [0.0, 0.2, 0.02], atol=1e-15)


def test_conditional_points_count_as_far_as_in_opensim_and_moving_ones_move(leg: Scene):
    _, conditional, _, moving = leg.character.muscles["quad"].path
    assert conditional.condition is not None
    assert (conditional.condition.joint, conditional.condition.blend) == ("bend", 0.0)
    np.testing.assert_allclose((conditional.condition.low, conditional.condition.high), (-3.0 - 1e-5, -1.0 + 1e-5))
    (motion,) = moving.motion
    assert (motion.joint, motion.x, motion.y) == ("bend", [-2.0, -1.0, 0.0], [0.02, 0.03, 0.05])
    np.testing.assert_allclose(motion.axis, WORLD @ turned([0.0, 0.0, 0.1]) @ [1.0, 0.0, 0.0], atol=1e-15)


def test_a_point_whose_coordinate_is_locked_counts_or_not(tmp_path: Path):
    def points(low: float) -> str:
        inner = small.point("c", "rod", "0 0 0.1").replace("PathPoint", "ConditionalPathPoint")
        inner = inner.replace("</Cond", f"<socket_coordinate>q</socket_coordinate><range>{low} 1</range></Cond")
        return POINTS.replace('<PathPoint name="b"', inner + '<PathPoint name="b"')

    joints = WELD + PIN.replace("<range>", "<locked>true</locked><default_value>0.2</default_value><range>")
    for low, count in ((0.1, 3), (0.3, 2)):
        (muscle,) = scene_of(tmp_path, small.muscle("m", points(low)), joints=joints).character.muscles.values()
        assert len(muscle.path) == count
        assert all(point.condition is None for point in muscle.path)


def conditional(name: str, low: float, high: float) -> str:
    """A conditional point on the rod."""
    point = small.point(name, "rod", "0 0 0.1").replace("PathPoint", "ConditionalPathPoint")
    return point.replace("</Cond", f"<socket_coordinate>q</socket_coordinate><range>{low} {high}</range></Cond")


def test_a_point_whose_range_is_the_wrong_way_round_never_counts_as_in_opensim(tmp_path: Path):
    """And a wrap's range is of the points that are left."""
    surfaces = '<WrapObjectSet><objects><WrapSphere name="s"/></objects></WrapObjectSet>'
    wrap = "<PathWrap><wrap_object>s</wrap_object><range>{}</range></PathWrap>"
    notes: list[Ignored] = []
    points = conditional("never", 0.5, -0.5) + POINTS + conditional("last", -0.5, 0.5)
    bodies = small.body("base", more=surfaces) + small.body("rod", center="0 -0.5 0")
    forces = small.muscle("m", points, wrap.format("1 3") + wrap.format("2 4"))
    forces += small.muscle("none", POINTS[: POINTS.index("\n")] + conditional("never", 0.5, -0.5))
    scene = load(small.written(tmp_path, small.model(bodies, WELD + PIN, forces)), ignored=notes)
    (muscle,) = scene.character.muscles.values()
    assert [point.condition is not None for point in muscle.path] == [False, False, True]
    assert [(one.first, one.last) for one in muscle.wraps] == [(1, 2), (1, 3)]
    said = " ".join(f"{note.text}: {note.reason}." for note in notes)
    assert "its range runs from 0.5 to -0.5; it never comes in, as in OpenSim" in said
    assert "left out: of its path 1 point can count, where it takes two" in said


def test_surfaces_keep_size_side_and_axes(leg: Scene):
    roll, egg = leg.character.surfaces["roll"], leg.character.surfaces["egg"]
    assert isinstance(roll, CylinderSurface)
    assert isinstance(egg, EllipsoidSurface)
    assert (roll.radius, roll.length, roll.side, roll.body) == (0.02, 0.1, "+x", "thigh")
    assert (egg.radii, egg.side) == ((0.02, 0.03, 0.02), "")
    axes = rotate(from_rotation_vector(roll.orientation), np.eye(3)).T
    np.testing.assert_allclose(axes, WORLD @ turned([0.1, 0.0, 0.0]), atol=1e-15)
    np.testing.assert_allclose(roll.position, WORLD @ [0.0, -0.2, 0.0], atol=1e-15)
    (wrap,) = leg.character.muscles["quad"].wraps
    assert (wrap.surface, wrap.first, wrap.last, wrap.method) == ("roll", 1, None, "hybrid")


def test_a_surface_that_is_switched_off_is_left_out_with_a_note(tmp_path: Path):
    path, notes = tmp_path / "leg.osim", list[Ignored]()
    path.write_text(LEG.replace("<quadrant>", "<active>false</active><quadrant>"))
    assert load(path, ignored=notes).character.muscles["quad"].wraps == []
    line = LEG[: LEG.index("<PathWrap ")].count("\n") + 1
    assert any("switched off" in note.reason and note.line == line for note in notes)


def test_muscles_have_what_most_have_in_common_and_the_rest_as_their_own(leg: Scene):
    common, quad, calf = leg.muscle_model, leg.character.muscles["quad"], leg.character.muscles["calf"]
    assert (common.curves, common.activation, common.tendon) == ("millard", "scaled", "compliant")
    assert isinstance(common.curve_shape, MillardCurves)
    assert (quad.f_max, quad.l_opt, quad.l_slack, quad.pennation) == (2000.0, 0.1, 0.3, 0.1)
    assert quad.curve_shape is None
    assert isinstance(calf.curve_shape, ThelenCurves)
    assert (calf.tendon_strain, calf.passive_strain, calf.rise_time, calf.fall_time) == (0.04, 0.6, 0.015, 0.05)
    assert (common.rise_time, common.fall_time, common.minimum_activation) == (0.01, 0.04, 0.01)


def test_activations_of_each_class_follow_its_own_law(tmp_path: Path):
    kinds = {
        "a": "Millard2012EquilibriumMuscle", "b": "DeGrooteFregly2016Muscle", "c": "Thelen2003Muscle",
        "d": "Schutte1993Muscle",
    }  # fmt: skip
    found = scene_of(tmp_path, "".join(small.muscle(name, POINTS, kind=kind) for name, kind in kinds.items()))
    assert found.muscle_model.activation == "scaled"
    laws = [found.character.muscles[name].activation for name in kinds]
    assert laws == [None, "blended", None, "excited_rise"]
    alone = scene_of(tmp_path, small.muscle("b", POINTS, kind=kinds["b"]))
    assert (alone.muscle_model.activation, alone.character.muscles["b"].activation) == ("blended", None)


def test_a_path_may_be_a_polynomial(tmp_path: Path):
    path = (
        '<FunctionBasedPath name="path"><coordinate_paths>/jointset/pin/q /jointset/second/r</coordinate_paths>'
        "<length_function><MultivariatePolynomialFunction><coefficients>1 2 3 4 5 6</coefficients><dimension>2"
        "</dimension><order>2</order></MultivariatePolynomialFunction></length_function></FunctionBasedPath>"
    )
    text = small.muscle("m", "")
    text = text[: text.index("<GeometryPath")] + path + text[text.index("</GeometryPath>") + len("</GeometryPath>") :]
    bodies = BODIES + small.body("tip")
    joints = WELD + PIN + small.joint("PinJoint", "second", "rod", "tip", small.coordinate("r"))
    polynomial = scene_of(tmp_path, text, "", bodies, joints).character.muscles["m"].polynomial
    assert polynomial is not None
    assert polynomial.joints == ["q", "r"]
    # OpenSim 4.6: with coefficients 1 to 6 it is 646.23 at (10, 0.1).
    terms = [10.0**a * 0.1**b for a, b in polynomial.exponents]
    np.testing.assert_allclose(np.dot(polynomial.coefficients, terms), 646.23)
    assert len(list(powers(3, 4))) == 35


def test_actuators_limits_springs_and_contact_go_where_they_belong(leg: Scene):
    assert leg.actuation["adduction"].drive == "assisted"
    stop, spring = leg.forces["stop"], leg.forces["spring"]
    assert (stop.type, stop.joint) == ("coordinate_limit", "bend")
    degree = np.pi / 180.0
    expected = {"low": -120 * degree, "high": 0.0, "stiffness_below": 1 / degree, "stiffness_above": 1 / degree,
        "damping": 0.001 / degree, "transition": 5 * degree}  # fmt: skip
    assert stop.parameters == pytest.approx(expected)
    assert spring.parameters == {"rest": 0.0, "stiffness": 10.0, "damping": 0.5}
    (sphere,) = leg.character.bodies["foot"].shapes
    assert isinstance(sphere, Sphere)
    assert sphere.radius == 0.03
    assert leg.ground.law == "hunt_crossley"
    assert sphere.material == ContactMaterial(1e6, 1.0, 0.0, 0.8, 0.0, 0.01)
    np.testing.assert_allclose(leg.ground.normal, (0.0, 1.0, 0.0), atol=1e-7)
    assert leg.opensim is not None
    assert leg.opensim.markers["toe"].body == "foot"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<coordinate>bend", "<coordinate>bent", "CoordinateLimitForce 'stop': there is no coordinate 'bent'"),
        ("knee/bend</socket_x", "knee/bent</socket_x", "muscle 'quad': there is no coordinate 'bent'"),
        ("<quadrant>+x", "<quadrant>+w", "surface 'roll': there is no quadrant '+w'"),
        ("floor heel", "floor toe", "HuntCrossleyForce 'sole': there is no shape 'toe'"),
        ("<transition>5", "<transition>0", "CoordinateLimitForce 'stop': <transition> must be greater than 0"),
    ],
)  # fmt: skip
def test_names_that_lead_nowhere_are_refused_with_their_line(tmp_path: Path, old: str, new: str, message: str):
    path = tmp_path / "leg.osim"
    path.write_text(LEG.replace(old, new))
    with pytest.raises(SceneError) as caught:
        load(path)
    assert message in caught.value.message
    assert caught.value.line > 0


def test_surfaces_of_offset_frames_lie_where_the_frame_does(tmp_path: Path):
    def surface(turn: str, place: str) -> str:
        return (
            f'<WrapObjectSet><objects><WrapCylinder name="drum"><xyz_body_rotation>{turn}</xyz_body_rotation>'
            f"<translation>{place}</translation><radius>0.02</radius><length>0.1</length></WrapCylinder></objects>"
            "</WrapObjectSet>"
        )

    inner = (
        '<components><PhysicalOffsetFrame name="bracket"><socket_parent>..</socket_parent>'
        "<translation>0.1 0 0</translation><orientation>0 0 1.5707963267948966</orientation>"
        f"{surface('0 0 0', '0.02 0 0')}</PhysicalOffsetFrame></components>"
    )
    wrap = '<PathWrap name="wrap"><wrap_object>drum</wrap_object></PathWrap>'
    base = small.body("base", center="0.01 0.02 0.03")
    found = [
        scene_of(
            tmp_path, small.muscle("m", POINTS, wrap), bodies=base + small.body("rod", center="0 -0.5 0", more=one)
        )
        for one in (inner, surface("0 0 1.5707963267948966", "0.1 0.02 0"))
    ]
    framed, direct = (scene.character.surfaces["drum"] for scene in found)
    assert (framed.body, found[0].character.muscles["m"].wraps[0].surface) == ("rod", "drum")
    np.testing.assert_allclose(framed.position, direct.position, atol=1e-12)
    np.testing.assert_allclose(framed.orientation, direct.orientation, atol=1e-12)


# Of OpenSim 4.6: length, m, of rect_fem_r in gait2392 by knee angle, rad, whose range is -2.094 to 0.175. Beyond it its
# moving point stays where it is at the end.
RECTUS_FEMORIS = {
    -2.4: 0.50264119, -2.2: 0.49384646, -1.0: 0.45796173, 0.0: 0.41032375, 0.17: 0.40278639, 0.3: 0.39361320,
    0.5: 0.38071484,
}  # fmt: skip


def test_moving_points_stay_beyond_the_range_of_their_coordinate_as_in_opensim(reference_data):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = load(str(reference_data / "opensim_models" / "gait2392_thelen2003muscle.osim"))
    names = topology(scene.character)
    moving = next(point for point in scene.character.muscles["rect_fem_r"].path if point.motion)
    assert [motion.within for motion in moving.motion] == [[-2.0943951, 0.17453293]] * len(moving.motion)
    coordinates = np.zeros((len(RECTUS_FEMORIS), names.coordinates))
    coordinates[:, 6] = 1.0  # the root's quaternion
    coordinates[:, names.coordinates_of(names.body_of_joint("knee_angle_r"))] = np.array([list(RECTUS_FEMORIS)]).T
    lengths, _ = muscle_geometry(scene, coordinates)
    found = lengths[:, list(scene.character.muscles).index("rect_fem_r")]
    np.testing.assert_allclose(found, list(RECTUS_FEMORIS.values()), atol=2e-5)


@pytest.mark.parametrize(
    ("coefficients", "span", "expected"),
    [
        ((0.0, 1.0), (-2.0, 0.2), [-2.0, 0.2]),
        ((0.1, -2.0), (-2.0, 0.2), [-0.05, 1.05]),
        ((0.0, 1.0), (-math.inf, 0.2), [-ENDLESS, 0.2]),
        ((0.0, 1.0), (-math.inf, math.inf), []),
        ((0.3, 0.0), (-2.0, 0.2), []),
    ],
)
def test_a_range_of_a_coordinate_is_one_of_what_it_depends_on(coefficients, span, expected):
    assert span_within(Function(coefficients), span) == pytest.approx(expected)


def test_points_stay_beyond_a_range_that_a_curved_coupling_reaches():
    """OpenSim clamps the coordinate that moves a point: of q^2 + q within -0.2 .. 0.75 from q = -0.2764 to 0.5."""
    parabola = Function((0.0, 1.0, 1.0))
    low, high = span_within(parabola, (-0.2, 0.75), (-0.25, 1.0))
    assert high == pytest.approx(0.5, abs=1e-8)
    assert low == pytest.approx((-1.0 + math.sqrt(1.0 - 0.8)) / 2.0, abs=1e-8)
    bent = Function(x=(-1.0, 0.0, 1.0), y=(-1.0, 0.0, 3.0), ends="linear")
    np.testing.assert_allclose(span_within(bent, (-0.5, 1.5), (-1.0, 1.0)), [-0.5, 0.5], atol=1e-8)
    assert span_within(bent, (-9.0, 9.0), (-1.0, 1.0)) == []
    assert span_within(parabola, (-math.inf, math.inf), (-1.0, 1.0)) == []


def test_a_path_may_stand_within_its_property(tmp_path: Path):
    plain = small.muscle("m", POINTS)
    within = plain.replace("<GeometryPath", "<path><GeometryPath").replace("</GeometryPath>", "</GeometryPath></path>")
    assert scene_of(tmp_path, within).character == scene_of(tmp_path, plain).character


def test_what_is_empty_or_not_said_is_what_opensim_takes_for_it(tmp_path: Path):
    """Defaults of OpenSim 4.6's WrapCylinder, WrapSphere, WrapEllipsoid, WrapTorus and ConditionalPathPoint."""
    kinds = ("WrapCylinder", "WrapSphere", "WrapEllipsoid", "WrapTorus")
    surfaces = "".join(f'<{kind} name="{kind}"><radius></radius></{kind}>' for kind in kinds)
    bodies = BODIES.replace("</Body>", f"<WrapObjectSet><objects>{surfaces}</objects></WrapObjectSet></Body>", 1)
    wraps = "".join(f"<PathWrap><wrap_object>{kind}</wrap_object></PathWrap>" for kind in kinds)
    point = (
        '<ConditionalPathPoint name="c"><socket_parent_frame>/bodyset/rod</socket_parent_frame><location>0 0 0.1'
        "</location><socket_coordinate>/jointset/pin/q</socket_coordinate><range/></ConditionalPathPoint>"
    )
    first, last = POINTS.splitlines()
    muscle = small.muscle("m", first + point + last, wraps, more="<isDisabled></isDisabled>")
    character = scene_of(tmp_path, muscle, bodies=bodies).character
    cylinder, ball, ellipsoid, torus = (character.surfaces[kind] for kind in kinds)
    assert (cylinder.radius, cylinder.length, ball.radius) == (1.0, 1.0, 0.05)
    assert list(ellipsoid.radii) == pytest.approx([0.05] * 3)
    assert (torus.inner_radius, torus.outer_radius) == (0.01, 0.05)
    condition = character.muscles["m"].path[1].condition
    assert (condition.low, condition.high) == pytest.approx((0.0, 0.0), abs=1e-4)


@pytest.mark.parametrize("span", ["2 1", "2 2"])
def test_a_wrap_whose_range_has_no_way_in_it_is_left_out(tmp_path: Path, span: str):
    surface = '<WrapObjectSet><objects><WrapSphere name="s"/></objects></WrapObjectSet></Body>'
    wrap = f"<PathWrap><wrap_object>s</wrap_object><range>{span}</range></PathWrap>"
    text = small.model(BODIES.replace("</Body>", surface, 1), WELD + PIN, small.muscle("m", POINTS, wrap))
    ignored: list[Ignored] = []
    scene = load(small.written(tmp_path, text), ignored=ignored)
    assert not scene.character.muscles["m"].wraps
    assert any(note.text == "PathWrap of m" and "the path runs without it" in note.reason for note in ignored)


def test_a_muscle_without_force_or_tendon_has_nearly_none_and_is_told(tmp_path: Path):
    muscle = small.muscle("m", POINTS).replace(">500<", ">0<").replace(">0.2<", ">0<")
    ignored: list[Ignored] = []
    scene = load(small.written(tmp_path, small.model(BODIES, WELD + PIN, muscle)), ignored=ignored)
    assert (scene.character.muscles["m"].f_max, scene.character.muscles["m"].l_slack) == (1e-6, 1e-6)
    assert scene.muscle_model.tendon == "rigid"
    told = [note.reason for note in ignored if note.text == "Millard2012EquilibriumMuscle m"]
    assert any("has no force" in reason for reason in told)
    assert any("has no tendon" in reason for reason in told)
