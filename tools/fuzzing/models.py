"""A small OpenSim model that has something of all that is read, in the layouts of two versions; and its mutations."""

from __future__ import annotations

import re
from random import Random

from fuzzing.held import HELD
from fuzzing.texts import encoded, mutated

LEG = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40000">
<Model name="leg">
<defaults><CoordinateActuator name="default"><optimal_force>30</optimal_force></CoordinateActuator></defaults>
<credits>nobody</credits>
<gravity>0 -9.80665 0</gravity>
<length_units>meters</length_units>
<Ground name="ground"><WrapObjectSet><objects /></WrapObjectSet></Ground>
<BodySet name="bodyset"><objects>
<Body name="pelvis"><mass>10</mass><mass_center>0 0.1 0</mass_center><inertia>0.1 0.1 0.1 0 0 0</inertia>
<attached_geometry><Mesh name="bone"><mesh_file>bone.vtp</mesh_file></Mesh></attached_geometry></Body>
<Body name="thigh"><mass>5</mass><mass_center>0 -0.2 0</mass_center><inertia>0.1 0.02 0.1 0.01 0 0</inertia>
<components><PhysicalOffsetFrame name="knee"><socket_parent>/bodyset/thigh</socket_parent>
<translation>0 -0.4 0</translation><orientation>0 0 0.1</orientation></PhysicalOffsetFrame></components>
<WrapObjectSet><objects>
<WrapCylinder name="roll"><xyz_body_rotation>0.1 0 0</xyz_body_rotation><translation>0 -0.4 0</translation>
<quadrant>+x</quadrant><radius>0.02</radius><length>0.1</length></WrapCylinder>
<WrapEllipsoid name="egg"><translation>0.05 -0.1 0</translation><dimensions>0.02 0.03 0.02</dimensions></WrapEllipsoid>
<WrapTorus name="ring"><xyz_body_rotation>1.5 0 0</xyz_body_rotation><translation>0.08 -0.2 0.05</translation>
<inner_radius>0.01</inner_radius><outer_radius>0.05</outer_radius></WrapTorus>
<WrapSphere name="ball"><translation>0 -0.35 0</translation><radius>0.03</radius></WrapSphere>
</objects></WrapObjectSet></Body>
<Body name="shank"><mass>3</mass><mass_center>0 -0.2 0</mass_center><inertia>0.05 0.01 0.05 0 0 0</inertia></Body>
<Body name="patella"><mass>0.1</mass><mass_center>0 0 0</mass_center><inertia>1e-4 1e-4 1e-4 0 0 0</inertia></Body>
<Body name="foot"><mass>1</mass><mass_center>0.05 0 0</mass_center><inertia>0.01 0.01 0.01 0 0 0</inertia></Body>
</objects></BodySet>
<JointSet name="jointset"><objects>
<PlanarJoint name="root"><socket_parent_frame>/ground</socket_parent_frame>
<socket_child_frame>/bodyset/pelvis</socket_child_frame><coordinates><Coordinate name="tilt" />
<Coordinate name="tx" /><Coordinate name="ty"><default_value>1</default_value></Coordinate></coordinates></PlanarJoint>
<CustomJoint name="hip"><socket_parent_frame>socket</socket_parent_frame>
<socket_child_frame>/bodyset/thigh</socket_child_frame><coordinates>
<Coordinate name="flexion"><range>-1 2</range><default_value>0.1</default_value></Coordinate>
<Coordinate name="adduction"><range>-1 1</range></Coordinate></coordinates>
<frames><PhysicalOffsetFrame name="socket"><socket_parent>/bodyset/pelvis</socket_parent>
<translation>0 -0.05 0.1</translation></PhysicalOffsetFrame></frames><SpatialTransform>
<TransformAxis name="rotation1"><coordinates>flexion</coordinates><axis>0 0 1</axis>
<LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
<TransformAxis name="rotation2"><coordinates>adduction</coordinates><axis>1 0 0</axis>
<LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
</SpatialTransform></CustomJoint>
<CustomJoint name="knee"><socket_parent_frame>/bodyset/thigh/knee</socket_parent_frame>
<socket_child_frame>/bodyset/shank</socket_child_frame><coordinates>
<Coordinate name="bend"><range>-2 0.1</range></Coordinate></coordinates><SpatialTransform>
<TransformAxis name="rotation1"><coordinates>bend</coordinates><axis>0 0 1</axis>
<LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
<TransformAxis name="translation1"><coordinates>bend</coordinates><axis>1 0 0</axis>
<SimmSpline name="function"><x>-2 -1 0 0.2</x><y>-0.003 0.004 -0.002 -0.005</y></SimmSpline></TransformAxis>
<TransformAxis name="translation2"><coordinates>bend</coordinates><axis>0 1 0</axis><MultiplierFunction>
<function><PolynomialFunction><coefficients>0.01 0 0</coefficients></PolynomialFunction></function><scale>0.9</scale>
</MultiplierFunction></TransformAxis></SpatialTransform></CustomJoint>
<CustomJoint name="cap"><socket_parent_frame>/bodyset/thigh/knee</socket_parent_frame>
<socket_child_frame>/bodyset/patella</socket_child_frame><coordinates><Coordinate name="glide" /></coordinates>
<SpatialTransform><TransformAxis name="rotation1"><coordinates>glide</coordinates><axis>0 0 1</axis>
<PiecewiseLinearFunction name="function"><x>-2 -1 0</x><y>-1 -0.6 0</y></PiecewiseLinearFunction></TransformAxis>
<TransformAxis name="translation1"><coordinates></coordinates><axis>1 0 0</axis>
<Constant name="function"><value>0.04</value></Constant></TransformAxis></SpatialTransform></CustomJoint>
<PinJoint name="ankle"><socket_parent_frame>hinge</socket_parent_frame>
<socket_child_frame>/bodyset/foot</socket_child_frame><coordinates><Coordinate name="ankle_angle">
<locked>false</locked><prescribed>false</prescribed></Coordinate></coordinates><frames>
<PhysicalOffsetFrame name="hinge"><socket_parent>/bodyset/shank</socket_parent><translation>0 -0.4 0</translation>
</PhysicalOffsetFrame></frames></PinJoint>
</objects></JointSet>
<ConstraintSet name="constraintset"><objects><CoordinateCouplerConstraint name="gliding">
<coupled_coordinates_function><LinearFunction><coefficients>1 0</coefficients></LinearFunction>
</coupled_coordinates_function><independent_coordinate_names>bend</independent_coordinate_names>
<dependent_coordinate_name>glide</dependent_coordinate_name></CoordinateCouplerConstraint></objects></ConstraintSet>
<ForceSet name="forceset"><objects>
<Millard2012EquilibriumMuscle name="quad"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/pelvis</socket_parent_frame>
<location>0.05 0 0.1</location></PathPoint>
<ConditionalPathPoint name="2"><socket_parent_frame>/bodyset/thigh</socket_parent_frame>
<location>0.05 -0.3 0</location><socket_coordinate>/jointset/knee/bend</socket_coordinate><range>-3 -1</range>
</ConditionalPathPoint>
<PathPoint name="3"><socket_parent_frame>/bodyset/patella</socket_parent_frame><location>0.01 0 0</location></PathPoint>
<MovingPathPoint name="4"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
<socket_x_coordinate>/jointset/knee/bend</socket_x_coordinate>
<x_location><SimmSpline><x>-2 -1 0</x><y>0.02 0.03 0.05</y></SimmSpline></x_location>
<y_location><Constant><value>-0.05</value></Constant></y_location>
<z_location><Constant><value>0</value></Constant></z_location></MovingPathPoint>
</objects></PathPointSet><PathWrapSet><objects><PathWrap name="w"><wrap_object>roll</wrap_object>
<method>hybrid</method><range>1 -1</range></PathWrap></objects></PathWrapSet></GeometryPath>
<max_isometric_force>2000</max_isometric_force><optimal_fiber_length>0.1</optimal_fiber_length>
<tendon_slack_length>0.3</tendon_slack_length><pennation_angle_at_optimal>0.1</pennation_angle_at_optimal>
<ActiveForceLengthCurve name="a"><minimum_value>0</minimum_value></ActiveForceLengthCurve>
</Millard2012EquilibriumMuscle>
<Thelen2003Muscle name="calf"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/thigh</socket_parent_frame>
<location>-0.02 -0.3 0</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/foot</socket_parent_frame><location>-0.05 0 0</location></PathPoint>
</objects></PathPointSet><PathWrapSet><objects><PathWrap><wrap_object>egg</wrap_object></PathWrap></objects>
</PathWrapSet></GeometryPath><tendon_slack_length>0.35</tendon_slack_length></Thelen2003Muscle>
<Ligament name="cruciate"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/thigh</socket_parent_frame><location>0 -0.38 0</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
<location>0.01 -0.02 0</location></PathPoint></objects></PathPointSet></GeometryPath>
<resting_length>0.03</resting_length><pcsa_force>200</pcsa_force>
<SimmSpline name="force_length_curve"><x>0.9 1 1.2 2</x>
<y>0 0 0.3 3</y></SimmSpline></Ligament>
<PathActuator name="rope"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/pelvis</socket_parent_frame><location>0.1 0 0.1</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
<location>0.08 -0.1 0</location></PathPoint>
</objects></PathPointSet><PathWrapSet><objects><PathWrap name="w"><wrap_object>ring</wrap_object></PathWrap></objects>
</PathWrapSet></GeometryPath><optimal_force>150</optimal_force><min_control>0</min_control><max_control>1</max_control></PathActuator>
<PathSpring name="strap"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/pelvis</socket_parent_frame><location>0 0 -0.1</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/shank</socket_parent_frame><location>-0.05 -0.1 0</location>
</PathPoint></objects></PathPointSet><PathWrapSet><objects><PathWrap><wrap_object>ball</wrap_object></PathWrap></objects>
</PathWrapSet></GeometryPath><resting_length>0.5</resting_length><stiffness>1000</stiffness>
<dissipation>0.01</dissipation></PathSpring>
<CoordinateActuator name="motor"><coordinate>adduction</coordinate></CoordinateActuator>
<CoordinateLimitForce name="stop"><coordinate>bend</coordinate><upper_limit>0</upper_limit>
<lower_limit>-120</lower_limit><transition>5</transition></CoordinateLimitForce>
<SpringGeneralizedForce name="spring"><coordinate>ankle_angle</coordinate><stiffness>10</stiffness>
<viscosity>0.5</viscosity></SpringGeneralizedForce>
<HuntCrossleyForce name="sole"><HuntCrossleyForce::ContactParametersSet name="contact_parameters"><objects>
<HuntCrossleyForce::ContactParameters><geometry>floor heel</geometry><stiffness>1e6</stiffness>
<dissipation>1</dissipation><dynamic_friction>0.8</dynamic_friction></HuntCrossleyForce::ContactParameters></objects>
</HuntCrossleyForce::ContactParametersSet></HuntCrossleyForce>
</objects></ForceSet>
<ContactGeometrySet name="contactgeometryset"><objects>
<ContactHalfSpace name="floor"><socket_frame>/ground</socket_frame><orientation>0 0 -1.5707963</orientation>
</ContactHalfSpace>
<ContactSphere name="heel"><socket_frame>/bodyset/foot</socket_frame><location>-0.05 0 0</location>
<radius>0.03</radius></ContactSphere></objects></ContactGeometrySet>
<MarkerSet name="markerset"><objects><Marker name="toe"><socket_parent_frame>/bodyset/foot</socket_parent_frame>
<location>0.15 0 0</location></Marker></objects></MarkerSet>
</Model>
</OpenSimDocument>
"""
OLD_ARM = """<OpenSimDocument Version="20301"><Model name="arm"><ForceSet><objects>
<Thelen2003Muscle name="biceps"><isDisabled>false</isDisabled><GeometryPath><PathPointSet><objects>
<PathPoint name="a"><body>base</body><location>0.1 0 0</location></PathPoint>
<ConditionalPathPoint name="c"><body>rod</body><location>0.1 -0.1 0</location><range>-1 0.5</range>
<coordinate>q</coordinate></ConditionalPathPoint>
<PathPoint name="b"><body>rod</body><location>0.01 -0.4 0</location></PathPoint>
</objects></PathPointSet></GeometryPath><max_isometric_force>700</max_isometric_force>
<pennation_angle>0.1</pennation_angle></Thelen2003Muscle>
</objects></ForceSet><BodySet><objects>
<Body name="ground"><mass>0</mass><Joint/></Body>
<Body name="base"><mass>1</mass><inertia_xx>1</inertia_xx><inertia_yy>1</inertia_yy><inertia_zz>1</inertia_zz><Joint>
<WeldJoint name="fixed"><parent_body>ground</parent_body></WeldJoint></Joint></Body>
<Body name="rod"><mass>2</mass><mass_center>0 -0.5 0</mass_center><inertia_xx>1</inertia_xx><inertia_yy>1.5</inertia_yy>
<inertia_zz>2</inertia_zz><inertia_xy>0.1</inertia_xy><Joint><PinJoint name="pin"><parent_body> base </parent_body>
<location_in_parent>0 1 0</location_in_parent><orientation_in_parent>0 0 0.5</orientation_in_parent>
<location>0 0.2 0</location><orientation>0 0 0</orientation><CoordinateSet><objects>
<Coordinate name="q"><default_value>0.3</default_value><range>-1 1</range></Coordinate></objects></CoordinateSet>
<reverse>false</reverse></PinJoint></Joint></Body></objects></BodySet></Model></OpenSimDocument>
"""
LOOP = """<?xml version="1.0"?>
<OpenSimDocument Version="40000"><Model name="loop"><BodySet><objects>
<Body name="left"><mass>1</mass><mass_center>0 -0.2 0</mass_center><inertia>0.02 0.01 0.02 0 0 0</inertia></Body>
<Body name="right"><mass>1.5</mass><mass_center>0 -0.2 0</mass_center><inertia>0.02 0.01 0.03 0 0 0</inertia></Body>
<Body name="bar"><mass>0.5</mass><mass_center>0.15 0 0</mass_center><inertia>0.001 0.01 0.01 0 0 0</inertia></Body>
</objects></BodySet><JointSet><objects>
<PinJoint name="first"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/left
</socket_child_frame><coordinates><Coordinate name="a"><default_value>0.3</default_value><range>-2 2</range>
</Coordinate></coordinates></PinJoint>
<PinJoint name="second"><socket_parent_frame>near</socket_parent_frame><socket_child_frame>/bodyset/right
</socket_child_frame><coordinates><Coordinate name="b"><default_value>0.3</default_value><range>-2 2</range>
</Coordinate></coordinates><frames><PhysicalOffsetFrame name="near"><socket_parent>/ground</socket_parent>
<translation>0.3 0 0</translation></PhysicalOffsetFrame></frames></PinJoint>
<PinJoint name="third"><socket_parent_frame>low</socket_parent_frame><socket_child_frame>/bodyset/bar
</socket_child_frame><coordinates><Coordinate name="c"><default_value>-0.3</default_value></Coordinate></coordinates>
<frames><PhysicalOffsetFrame name="low"><socket_parent>/bodyset/left</socket_parent><translation>0 -0.4 0</translation>
</PhysicalOffsetFrame></frames></PinJoint>
</objects></JointSet><ConstraintSet><objects>
<PointConstraint name="closed"><socket_body_1>/bodyset/bar</socket_body_1><socket_body_2>/bodyset/right</socket_body_2>
<location_body_1>0.3 0 0</location_body_1><location_body_2>0 -0.4 0</location_body_2></PointConstraint>
</objects></ConstraintSet><ForceSet><objects>
<Millard2012EquilibriumMuscle name="pull"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="p"><socket_parent_frame>/ground</socket_parent_frame><location>0.1 0.1 0</location></PathPoint>
<PathPoint name="q"><socket_parent_frame>/bodyset/right</socket_parent_frame><location>0 -0.3 0.02</location>
</PathPoint>
</objects></PathPointSet></GeometryPath><max_isometric_force>300</max_isometric_force>
<optimal_fiber_length>0.2</optimal_fiber_length><tendon_slack_length>0.2</tendon_slack_length>
</Millard2012EquilibriumMuscle>
<CoordinateLimitForce name="stop"><coordinate>a</coordinate><upper_limit>60</upper_limit>
<upper_stiffness>10</upper_stiffness><lower_limit>-60</lower_limit><lower_stiffness>10</lower_stiffness>
<damping>0.1</damping><transition>5</transition></CoordinateLimitForce>
<ExpressionBasedCoordinateForce name="spring"><coordinate>b</coordinate><expression>-3*q-0.1*qdot</expression>
</ExpressionBasedCoordinateForce>
</objects></ForceSet></Model></OpenSimDocument>
"""
MODELS = {"leg.osim": LEG, "arm.osim": OLD_ARM, "held.osim": HELD}
MOVING = {**MODELS, "loop.osim": LOOP}  # those that are simulated
ELEMENT = re.compile(r"<([A-Za-z_:0-9]+)(?: [^<>]*)?>[^<>]*</\1>")
ATTRIBUTE = re.compile(r'(\w+)="([^"<>]*)"')
NUMBER = re.compile(r"(?<=[>\s])-?\d+(?:\.\d+)?(?=[<\s])")
OPENING = re.compile(r"<([A-Za-z_:0-9]+)([^<>]*)>")


def mutated_model(text: str, rng: Random) -> bytes:
    """A model with elements left out, twice, elsewhere, with other tags or texts; or mutated as any text."""
    if rng.random() < 0.3:
        return mutated(text, rng)
    for _ in range(rng.choice([1, 1, 2, 3])):
        text = rng.choice([_dropped, _doubled, _swapped, _retagged, _moved, _emptied])(text, rng)
    return encoded(text, rng) if rng.random() < 0.1 else text.encode()


def mutated_numbers(text: str, rng: Random) -> bytes:
    """A model in which some numbers are larger, smaller, none or of the other sign, as a typing mistake leaves them."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        one = rng.choice(list(NUMBER.finditer(text)))
        factor = rng.choice([-1.0, 0.0, 0.1, 0.5, 2.0, 10.0, 1e3, 1e-3, 1e6])
        text = f"{text[: one.start()]}{float(one[0]) * factor:.9g}{text[one.end() :]}"
    return text.encode()


def mutated_attributes(text: str, rng: Random) -> bytes:
    """A model whose numbers and names stand in attributes, with others in them; or mutated as any text."""
    for _ in range(rng.randint(1, 4)):
        found = list(ATTRIBUTE.finditer(text))
        if not found or rng.random() < 0.3:
            return mutated(text, rng)
        one, other = rng.choice(found), rng.choice(found)
        value = rng.choice((other[2], "", "0", "-1", "1e300", "nan", "inf", "a b", one[2] + " 1", one[2][:-1]))
        text = text[: one.start(2)] + value + text[one.end(2) :]
    return encoded(text, rng)


def _leaf(text: str, rng: Random) -> re.Match[str]:
    return rng.choice(list(ELEMENT.finditer(text)))


def _dropped(text: str, rng: Random) -> str:
    leaf = _leaf(text, rng)
    return text[: leaf.start()] + text[leaf.end() :]


def _doubled(text: str, rng: Random) -> str:
    leaf = _leaf(text, rng)
    return text[: leaf.end()] + leaf[0] * rng.choice([1, 1, 50]) + text[leaf.end() :]


def _swapped(text: str, rng: Random) -> str:
    """The text of one element in another one."""
    first, second = _leaf(text, rng), _leaf(text, rng)
    inner = second[0].partition(">")[2].rpartition("<")[0]
    start = first.start() + first[0].index(">") + 1
    return text[:start] + inner + text[first.start() + first[0].rindex("<") :]


def _retagged(text: str, rng: Random) -> str:
    """All elements of one tag get that of others."""
    tags = sorted({opening[1] for opening in OPENING.finditer(text)})
    old, new = rng.choice(tags), rng.choice([*tags, "Unknown"])
    return re.sub(rf"(</?){re.escape(old)}(?=[\s>/])", rf"\g<1>{new}", text)


def _moved(text: str, rng: Random) -> str:
    leaf, other = _leaf(text, rng), _leaf(text, rng)
    without = text[: leaf.start()] + text[leaf.end() :]
    at = min(other.start(), len(without))
    at = without.find("<", at)
    return without[:at] + leaf[0] + without[at:] if at >= 0 else without


def _emptied(text: str, rng: Random) -> str:
    leaf = _leaf(text, rng)
    other = rng.choice(["", "-1", "nan", "1e9", "x", "/ground", "bend"])
    return f"{text[: leaf.start()]}<{leaf[1]}>{other}</{leaf[1]}>{text[leaf.end() :]}"
