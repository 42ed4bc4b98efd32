"""Constraints of OpenSim that close loops: read in all layouts, met at the start as OpenSim meets them, and written."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load, save
from warpmuscle.scene import Scene
from warpmuscle.scene.constraints.pose import constraint_errors, start_coordinates
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

X = "<socket_body_1>/bodyset/rod_b</socket_body_1><socket_body_2>/bodyset/rod_c</socket_body_2>"
POINT = f"""<PointConstraint name="pin">{X}<location_body_1>0 -0.4 0.02</location_body_1>
<location_body_2>0 -0.4 -0.02</location_body_2></PointConstraint>"""
LINE = """<PointOnLineConstraint name="pin"><socket_line_body>/bodyset/rod_c</socket_line_body>
<socket_follower_body>/bodyset/rod_b</socket_follower_body><line_direction_vec>0.1 0.9 0.2</line_direction_vec>
<point_on_line>0.05 -0.1 0</point_on_line><point_on_follower>0 -0.35 0</point_on_follower></PointOnLineConstraint>"""
DISTANCE = f"""<ConstantDistanceConstraint name="pin">{X}<location_body_1>0 -0.4 0</location_body_1>
<location_body_2>0.02 -0.3 0</location_body_2><constant_distance>0.25</constant_distance>
</ConstantDistanceConstraint>"""
WELD = """<WeldConstraint name="pin"><socket_frame1>end</socket_frame1><socket_frame2>/bodyset/rod_c</socket_frame2>
<frames><PhysicalOffsetFrame name="end"><socket_parent>/bodyset/rod_b</socket_parent>
<translation>0 -0.4 0.1</translation>
<orientation>0.1 0.2 0.3</orientation></PhysicalOffsetFrame></frames></WeldConstraint>"""
OLD_WELD = """<WeldConstraint name="pin"><body_1>rod_b</body_1><body_2>rod_c</body_2><location_body_1>0 -0.4 0.1
</location_body_1><orientation_body_1>0.1 0.2 0.3</orientation_body_1><location_body_2>0 0 0</location_body_2>
<orientation_body_2>0 0 0</orientation_body_2></WeldConstraint>"""
OLD_POINT = """<PointConstraint name="pin"><isDisabled> false </isDisabled><body_1> rod_b </body_1>
<body_2> rod_c </body_2><location_body_1>0 -0.4 0.02</location_body_1>
<location_body_2>0 -0.4 -0.02</location_body_2></PointConstraint>"""
KINDS = {"point": POINT, "point_on_line": LINE, "distance": DISTANCE, "weld": WELD}


def four_bar_text(constraint: str, free: bool = True, more: str = "") -> str:
    """Two rods on the ground and one on the first; the last one hangs on six coordinates if it is free."""
    bodies = "".join(
        small.body(name, mass, "0.01 -0.2 0.02", "0.02 0.01 0.02 0.001 0 0.002")
        for name, mass in (("rod_a", 2.0), ("rod_b", 1.0), ("rod_c", 1.5))
    )
    names = ["c_z"] if not free else ["c_rx", "c_ry", "c_rz", "c_tx", "c_ty", "c_tz"]
    last = "FreeJoint" if free else "PinJoint"
    joints = (
        small.joint("PinJoint", "ja", "ground", "rod_a", small.coordinate("a", "<default_value>0.3</default_value>"))
        + small.joint("UniversalJoint", "jb", "rod_a", "rod_b", small.coordinate("b_x")
            + small.coordinate("b_y", "<default_value>-0.2</default_value>"), "", "0 -0.4 0")
        + small.joint(last, "jc", "ground", "rod_c", "".join(map(small.coordinate, names)), "", "0.4 -0.1 0.05")
    )  # fmt: skip
    return small.model(bodies, joints, "", f"<ConstraintSet><objects>{constraint}</objects></ConstraintSet>{more}")


def four_bar(folder: Path, constraint: str, free: bool = True) -> tuple[Path, Scene]:
    file = small.written(folder, four_bar_text(constraint, free))
    return file, load(file, ignored=[])


def starts(scene: Scene) -> dict[str, float]:
    names = topology(scene.character)
    q = start_coordinates(scene, names)[0]
    return {
        name: q[names.coordinates_of(names.body_of_joint(name)).start]
        for name in names.joints
        if scene.character.joints[name].type != "fixed"
    }


@pytest.mark.parametrize("kind", KINDS)
def test_a_model_starts_where_its_constraint_is_met(tmp_path: Path, kind: str):
    _, scene = four_bar(tmp_path, KINDS[kind])
    (made,) = scene.character.constraints.values()
    assert made.type == kind
    errors = constraint_errors(
        scene.character, topology(scene.character), start_coordinates(scene, topology(scene.character))
    )
    assert np.abs(errors).max() < 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_the_start_is_that_of_opensim(tmp_path: Path, kind: str):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    opensim.Logger.setLevelString("off")
    file, scene = four_bar(tmp_path, KINDS[kind])
    model = opensim.Model(str(file))
    state = model.initSystem()
    theirs = {one.getName(): one.getValue(state) for one in model.getCoordinateSet()}
    found = starts(scene)
    assert set(found) == set(theirs)
    for name, value in theirs.items():
        assert found[name] == pytest.approx(value, abs=2e-4), name  # OpenSim stops looking for the nearest pose early
    moved = sum(
        (found[name] - one.getDefaultValue()) ** 2 for name in found for one in [model.getCoordinateSet().get(name)]
    )
    others = sum(
        (theirs[name] - one.getDefaultValue()) ** 2 for name in found for one in [model.getCoordinateSet().get(name)]
    )
    assert moved < others + 1e-7


def test_a_rod_shorter_than_the_way_to_it_starts_as_in_opensim(tmp_path: Path):
    """The pose of OpenSim 4.6 (initSystem), to the digits that it agrees with a sum of squares that is least."""
    text = four_bar_text(DISTANCE.replace("0.25", "0.02"))
    theirs = {
        "a": 0.449097, "b_x": -0.016728, "b_y": -0.2, "c_rx": 0.010395, "c_ry": 0.000458, "c_rz": -0.022578,
        "c_tx": -0.061923, "c_ty": -0.300820, "c_tz": -0.037741,
    }  # fmt: skip
    assert starts(load(small.written(tmp_path, text), ignored=[])) == pytest.approx(theirs, abs=2e-6)


@pytest.mark.parametrize(("old", "new"), [(OLD_WELD, WELD), (OLD_POINT, POINT)])
def test_an_old_layout_says_the_same(tmp_path: Path, old: str, new: str):
    text = four_bar_text(old).replace('Version="40000"', 'Version="30000"')
    first, second = load(small.written(tmp_path, text), ignored=[]), four_bar(tmp_path, new)[1]
    assert first.character.constraints == second.character.constraints
    assert starts(first) == pytest.approx(starts(second))


@pytest.mark.parametrize("kind", KINDS)
def test_a_written_model_has_the_same_constraint(tmp_path: Path, kind: str):
    _, scene = four_bar(tmp_path, KINDS[kind])
    save(scene, tmp_path / "again.osim", [])
    again = load(tmp_path / "again.osim", ignored=[])
    (one,), (other,) = scene.character.constraints.values(), again.character.constraints.values()
    assert (other.type, other.body, other.other_body) == (one.type, one.body, one.other_body)
    for field in ("position", "other_position", "axis") if kind != "weld" else ("position", "other_position"):
        np.testing.assert_allclose(getattr(other, field), getattr(one, field), atol=1e-12)
    names = topology(again.character)
    assert np.abs(constraint_errors(again.character, names, start_coordinates(again, names))).max() < 1e-9
    assert starts(again) == pytest.approx(starts(scene), abs=1e-12)


def test_a_start_is_outside_of_ranges_within_which_a_constraint_cannot_be_met(tmp_path: Path):
    ignored: list[Ignored] = []
    text = four_bar_text(POINT).replace("-2 2", "-0.05 0.05")
    scene = load(small.written(tmp_path, text), ignored=ignored)
    names = topology(scene.character)
    assert np.abs(constraint_errors(scene.character, names, start_coordinates(scene, names))).max() < 1e-9
    assert max(map(abs, starts(scene).values())) > 0.05
    assert any("within the ranges they cannot be met" in note.reason for note in ignored)


def test_a_locked_coordinate_that_keeps_a_constraint_from_being_met_is_named(tmp_path: Path):
    text = four_bar_text(POINT, free=False).replace("0.3</default_value>", "0.3</default_value><locked>true</locked>")
    text = text.replace('"c_z">', '"c_z"><locked>true</locked>')
    with pytest.raises(SceneError, match=r"are missing, with a, c_z locked$"):
        load(small.written(tmp_path, text), ignored=[])


def test_a_constraint_that_is_missed_where_no_coordinate_is_free_is_told(tmp_path: Path):
    text = four_bar_text(POINT, free=False).replace("</Coordinate>", "<locked>true</locked></Coordinate>")
    with pytest.raises(SceneError, match=r"cannot be met .* are missing, with a, b_x, b_y, c_z locked$"):
        load(small.written(tmp_path, text), ignored=[])


def test_a_constraint_that_cannot_be_met_is_told_with_its_line(tmp_path: Path):
    text = four_bar_text(POINT.replace("0 -0.4 0.02", "0 -0.4 3"), free=False)
    with pytest.raises(SceneError, match=r"'pin': the constraints cannot be met near .* are missing") as caught:
        load(small.written(tmp_path, text), ignored=[])
    assert caught.value.line


@pytest.mark.parametrize(
    ("constraint", "said"),
    [
        (DISTANCE.replace("0.25", "0"), "greater than 0"), (LINE.replace("0.1 0.9 0.2", "0 0 0"), "no direction"),
        (POINT.replace("rod_c", "rod_b"), "two different bodies"), (POINT.replace("rod_c", "nobody"), "no frame"),
        (POINT.replace("PointConstraint", "GearConstraint"), "cannot be represented"),
    ],
)  # fmt: skip
def test_what_holds_nothing_is_refused(tmp_path: Path, constraint: str, said: str):
    with pytest.raises(SceneError, match=said):
        four_bar(tmp_path, constraint)


def test_a_rolling_constraint_holds_nothing_as_in_opensim_and_is_told(tmp_path: Path):
    rolling = (
        '<RollingOnSurfaceConstraint name="foot"><isEnforced>true</isEnforced>'
        "<socket_rolling_body>/bodyset/rod_c</socket_rolling_body><socket_surface_body>/ground</socket_surface_body>"
        "<surface_normal>0 1 0</surface_normal></RollingOnSurfaceConstraint>"
    )
    notes: list[Ignored] = []
    scene = load(small.written(tmp_path, four_bar_text(rolling)), ignored=notes)
    assert scene.character.constraints == {}
    assert ["switched off" in one.reason for one in notes if "RollingOnSurface" in one.text] == [True]


def test_places_too_far_to_compute_with_are_refused_in_one_line(tmp_path: Path):
    with pytest.raises(SceneError):
        four_bar(tmp_path, POINT.replace("0 -0.4 0.02", "1e12 1e12 -1e12"))


def test_a_constraint_that_is_not_enforced_holds_nothing(tmp_path: Path):
    off = POINT.replace('name="pin">', 'name="pin"><isEnforced>false</isEnforced>')
    assert four_bar(tmp_path, off)[1].character.constraints == {}


def closed_by_joints(more: str = "") -> str:
    """A four-bar linkage in a plane, the last of whose four pins closes it."""
    bodies = "".join(small.body(name, 1.5, "0.01 -0.2 0.02", "0.02 0.01 0.02 0 0 0") for name in ("ra", "rb", "rc"))

    def pin(name: str, parent: str, child: str, start: float, place: str, own: str = "0 0 0") -> str:
        own_start = small.coordinate(f"q_{name}", f"<default_value>{start}</default_value>")
        return small.joint("PinJoint", name, parent, child, own_start, "", place, "0 0 0", own)

    joints = pin("ja", "ground", "ra", 0.3, "0 0 0") + pin("jb", "ra", "rb", 1.2, "0 -0.4 0")
    joints += pin("jc", "ground", "rc", 0.0, "0.4 -0.1 0") + pin("jd", "rc", "rb", 1.0, "0 -0.4 0", "0 -0.4 0")
    return small.model(bodies, joints, "", more)


def test_a_joint_that_closes_a_loop_carries_half_of_its_body(tmp_path: Path):
    lost: list = []
    scene = load(small.written(tmp_path, closed_by_joints()), ignored=lost)
    (held,) = scene.character.constraints.values()
    assert (held.type, {held.body, held.other_body}) == ("weld", {"rb", "rb_half"})
    assert [scene.character.bodies[name].mass for name in ("ra", "rb", "rb_half", "rc")] == [1.5, 0.75, 0.75, 1.5]
    assert any("closes a loop of bodies" in one.reason for one in lost)
    names = topology(scene.character)
    assert np.abs(constraint_errors(scene.character, names, start_coordinates(scene, names))).max() < 1e-9


def check_free_run(file: Path, scene: Scene, least: float) -> None:
    """Hold a free run of 0.3 s to that of OpenSim's Manager, and its loops closed."""
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    opensim.Logger.setLevelString("off")
    scene.duration, scene.time_step = 0.3, 1.0 / 4000.0
    for joint in scene.character.joints.values():
        joint.limits = []
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    found, names = rollout.recorded("coordinates")[0].astype(float), topology(scene.character)
    model = opensim.Model(str(file))
    state = model.initSystem()
    manager = opensim.Manager(model)
    manager.setIntegratorAccuracy(1e-8)
    manager.initialize(state)
    for row in (15, 29):
        state = manager.integrate(0.01 * row)
        for one in model.getCoordinateSet():
            place = names.coordinates_of(names.body_of_joint(one.getName())).start
            assert found[row, place] == pytest.approx(one.getValue(state), abs=2e-4)
    assert np.ptp(found, axis=0).max() > least
    assert np.abs(constraint_errors(scene.character, names, found)).max() < 1e-6


@pytest.mark.usefixtures("unoptimized_kernels")
def test_a_free_run_is_that_of_opensims_manager(tmp_path: Path):
    check_free_run(*four_bar(tmp_path, DISTANCE, free=False), 0.2)


@pytest.mark.usefixtures("unoptimized_kernels")
def test_a_free_run_of_a_loop_of_joints_is_that_of_opensims_manager(tmp_path: Path):
    scene = load(small.written(tmp_path, closed_by_joints()), ignored=[])
    text = closed_by_joints()  # OpenSim does not bring the bodies together where joints close a loop
    for name, before in (("ja", "0.3"), ("jb", "1.2"), ("jc", "0.0"), ("jd", "1.0")):
        old = f'"q_{name}"><range>-2 2</range><default_value>{before}<'
        assert old in text
        text = text.replace(old, old.replace(f"{before}<", f"{starts(scene)[f'q_{name}']:.17g}<"))
    file = small.written(tmp_path, text)
    check_free_run(file, load(file, ignored=[]), 0.2)
