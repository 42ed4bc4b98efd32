"""Paths that are the shortest ones over obstacles: what is read of them, and lengths beside OpenSim's."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.lines import Ignored
from warpmuscle.scene import CylinderSurface, Scene, SphereSurface, Wrap
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.scene.wrapping.path import path_length
from warpmuscle.scene.wrapping.route import route_stops
from warpmuscle.simulation.stages import Stages

TAG = "Scholz2015GeometryPath"
MOVED = ("turn", "f3", "f4", "f5")
COORDINATES = tuple(f"f{k}" for k in range(6))
SHAPES = {
    "low": "<ContactCylinder name='low'>{}<radius>0.06</radius></ContactCylinder>",
    "ball": "<ContactSphere name='ball'>{}<radius>0.1</radius></ContactSphere>",
    "far": "<ContactCylinder name='far'>{}<radius>0.05</radius></ContactCylinder>",
    "ring": "<ContactTorus name='ring'>{}<torus_radius>0.1</torus_radius></ContactTorus>",
}
PLACES = {
    "low": ("-0.25 -0.05 0", "0.1 0.2 0.3"),
    "ball": ("0 0.12 0.01", "0 0 0"),
    "far": ("0.2 -0.05 0", "0.2 0.1 0"),
}
HINTS = {"low": "0 0.06 0.01", "ball": "0 -0.1 0", "far": "0.01 0.05 0"}


def point(name: str, frame: str, place: str) -> str:
    inner = f"<socket_parent_frame>{frame}</socket_parent_frame><location>{place}</location>"
    return f"<{TAG}Point name='{name}'><PathPoint name='p'>{inner}</PathPoint></{TAG}Point>"


def obstacle(name: str, hint: str | None = None) -> str:
    hint = HINTS.get(name, "0 0.02 0") if hint is None else hint
    inner = f"<socket_contact_geometry>/contactgeometryset/{name}</socket_contact_geometry>"
    inner += f"<contact_hint>{hint}</contact_hint>" if hint else ""
    return f"<{TAG}Obstacle name='over'>{inner}</{TAG}Obstacle>"


START, END = point("first", "/ground", "-0.5 0.02 0.01"), point("last", "/bodyset/end", "0 0 0")


def text(paths: dict[str, tuple[str, ...]], more: str = "", ends: tuple[str, str] = (START, END)) -> str:
    """A model in which paths lead over obstacles of a body that turns to one that is shifted."""
    bodies = small.body("arm") + small.body("end")
    joints = small.joint("PinJoint", "pin", "ground", "arm", small.coordinate("turn"))
    joints += small.joint_of_six("six", "ground", "end", COORDINATES)
    forces = more
    for name, elements in paths.items():
        path = f"<path_elements>{ends[0]}{''.join(elements)}{ends[1]}</path_elements>"
        force = small.muscle(name, "").replace("<PathPointSet><objects></objects></PathPointSet>", path)
        force = force.replace("<PathWrapSet><objects></objects></PathWrapSet>", "")
        forces += force.replace("<GeometryPath", f"<{TAG}").replace("</GeometryPath", f"</{TAG}")
    shapes = ""
    for name, shape in SHAPES.items():
        place, turn = PLACES.get(name, ("0 0 0", "0 0 0"))
        where = f"<location>{place}</location><orientation>{turn}</orientation>"
        shapes += shape.format(f"<socket_frame>/bodyset/arm</socket_frame>{where}")
    shapes = f"<ContactGeometrySet><objects>{shapes}</objects></ContactGeometrySet>"
    return small.model(bodies, joints, forces, shapes, version=40600)


def loaded(folder: Path, *elements: str, **others: object) -> tuple[Scene, list[Ignored]]:
    notes: list[Ignored] = []
    return load(small.written(folder, text({"pull": elements}, **others)), ignored=notes), notes  # type: ignore[arg-type]


ROW = (obstacle("low"), obstacle("ball"), obstacle("far"))
VIA = (obstacle("low"), point("middle", "/bodyset/arm", "-0.12 0.01 0"), obstacle("ball"), obstacle("far"))


def test_obstacles_become_surfaces_in_a_row(tmp_path: Path):
    scene, notes = loaded(tmp_path, *VIA)
    character = scene.character
    assert character.wrapping == "mujoco"
    assert [(wrap.first, wrap.last) for wrap in character.muscles["pull"].wraps] == [(1, 2), (2, 3), (2, 3)]
    low, ball = character.surfaces["pull_1"], character.surfaces["pull_2"]
    assert isinstance(low, CylinderSurface)
    assert low.side_point == pytest.approx((0.0, 0.12, 0.01))
    assert isinstance(ball, SphereSurface)
    assert ball.side_point is None
    assert [note.text for note in notes if "Contact" in note.text] == ["ContactTorus ring"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (obstacle("ring"), "the shortest path over a ContactTorus (ring) is not known"),
        (obstacle("low", ""), "no <contact_hint>"),
        (obstacle("low", "0 0 0.3"), "no <contact_hint> off the axis"),
        (obstacle("low", "nan nan nan"), "no <contact_hint>"),
    ],
)
def test_a_path_that_cannot_be_had_is_left_out_with_a_note(tmp_path: Path, given: str, said: str):
    scene, notes = loaded(tmp_path, given)
    assert not scene.character.muscles
    (note,) = [note for note in notes if note.text == "Millard2012EquilibriumMuscle pull"]
    assert said in note.reason
    assert note.line > 0


def test_it_is_left_out_beside_muscles_that_wrap_by_the_other_rules(tmp_path: Path):
    ball = '<WrapObjectSet><objects><WrapSphere name="w"><radius>0.03</radius></WrapSphere></objects></WrapObjectSet>'
    wrap = '<PathWrap name="one"><wrap_object>w</wrap_object></PathWrap>'
    other = small.muscle("other", small.point("a", "ground", "0 1 0") + small.point("b", "end", "0 0 0.1"), wrap)
    given = text({"pull": ROW}, more=other).replace('<Body name="arm">', f'<Body name="arm">{ball}')
    notes: list[Ignored] = []
    scene = load(small.written(tmp_path, given), ignored=notes)
    assert list(scene.character.muscles) == ["other"]
    assert any(note.text.endswith("pull") and "go by one rule" in note.reason for note in notes)


@pytest.mark.parametrize(
    ("elements", "ends", "said"),
    [
        ((), (START, ""), "begins and ends with a point"),
        ((), ("", ""), "begins and ends with a point"),
        ((), (obstacle("low"), END), "begins and ends with a point"),
        (("<Nonsense/>",), (START, END), "elements of this class are not known in a path"),
        ((obstacle("absent"),), (START, END), "names no shape of the ContactGeometrySet"),
    ],
)
def test_a_path_that_makes_no_sense_is_refused_by_its_line(tmp_path: Path, elements: tuple[str, ...], ends, said: str):
    with pytest.raises(SceneError, match=said) as caught:
        loaded(tmp_path, *elements, ends=ends)
    assert caught.value.line is not None


@pytest.fixture(scope="module")
def four(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Stages, np.ndarray]:
    """A model of four paths, posed in 40 ways, and its coordinates (40, 4)."""
    paths = {"low": ROW[:1], "ball": ROW[1:2], "row": ROW, "via": VIA}
    file = small.written(tmp_path_factory.mktemp("four"), text(paths))
    scene = load(file, ignored=[])
    names, stages, rng = topology(scene.character), Stages(scene, 40, "cpu"), np.random.default_rng(0)
    q = np.column_stack([0.1 * rng.normal(size=40), [[0.5, 0.0, 0.0]] + 0.05 * rng.normal(size=(40, 3))])
    places = stages.state.coordinates.numpy().copy()
    places[:, [names.coordinate_start[1 + names.joints.index(name)] for name in MOVED]] = q
    stages.state.coordinates.assign(places)
    return file, stages, q


def test_single_precision_gives_the_lengths_of_double(four: tuple[Path, Stages, np.ndarray]):
    _, stages, _ = four
    paths, bodies = stages.muscle_paths(), stages.forward_kinematics()
    character, expected = stages.scene.character, []
    names = topology(character)
    for position, turn in zip(bodies["position"].astype(float), bodies["orientation"].astype(float), strict=True):
        poses = {name: (position[k], turn[k]) for k, name in enumerate(names.bodies)}
        angles = {name: np.zeros(1) for name in character.joints}
        expected.append([path_length(route_stops(character, one, poses, angles)) for one in character.muscles.values()])
    np.testing.assert_allclose(paths.length, expected, rtol=0.0, atol=1e-6)


def test_the_shortest_path_over_a_row_is_not_shorter_than_over_one_of_it(four: tuple[Path, Stages, np.ndarray]):
    _, stages, q = four
    low, ball, row, via = stages.muscle_paths().length.T
    straight = np.linalg.norm(q[:, 1:] - [-0.5, 0.02, 0.01], axis=1)
    assert np.all(row >= np.maximum(np.maximum(low, ball), straight) - 1e-6)
    assert np.all(via >= row - 1e-6)
    assert np.mean(row > np.maximum(low, ball) + 1e-3) > 0.1


def test_moment_arms_are_the_slopes_of_lengths(four: tuple[Path, Stages, np.ndarray]):
    """Of the arm's hinge, whose angle is moved by 0.004 rad either way."""
    _, stages, _ = four
    character = stages.scene.character
    names = topology(character)
    column, joint = names.coordinate_start[1 + names.joints.index("turn")], names.joints.index("turn")
    q, lengths = stages.state.coordinates.numpy().copy(), []
    for move in (-0.004, 0.004):
        stages.state.coordinates.assign(q + np.float32(move) * (np.arange(q.shape[1]) == column).astype(np.float32))
        lengths.append(stages.muscle_paths().length.copy())
    stages.state.coordinates.assign(q)
    paths, touched = stages.muscle_paths(), 0
    for crossing, (muscle, own) in enumerate(zip(paths.muscle, paths.joint, strict=True)):
        if own == joint:
            along = np.abs(paths.moment_arm[:, crossing] @ np.array(character.joints["turn"].axes[0]))
            slope = np.abs(lengths[1][:, muscle] - lengths[0][:, muscle]) / 0.008
            off = np.abs(along - slope)
            assert np.median(off) < 1e-4  # of differences; paths that begin to touch have another slope on either side
            assert np.quantile(off, 0.75) < 5e-4
            touched += 1
    assert touched == 4


def test_lengths_are_opensims_as_it_follows_the_motion_from_the_start(four: tuple[Path, Stages, np.ndarray]):
    """From the last pose's path, as in a simulation; from anew it finds another one in some poses."""
    osim = pytest.importorskip("opensim")
    osim.Logger.setLevelString("Off")
    file, stages, q = four
    model, start, expected = osim.Model(str(file)), np.array([0.0, 0.5, 0.0, 0.0]), []
    for pose in q[:12]:
        state = model.initSystem()
        for part in np.linspace(0.0, 1.0, 12):
            for name, value in zip(MOVED, start + part * (pose - start), strict=True):
                model.getCoordinateSet().get(name).setValue(state, float(value), False)
            model.realizePosition(state)
            lengths = [model.getMuscles().get(k).getLength(state) for k in range(4)]
            state.autoUpdateDiscreteVariables()
        expected.append(lengths)
    np.testing.assert_allclose(stages.muscle_paths().length[:12], expected, rtol=0.0, atol=1e-6)


def test_a_wrap_out_of_order_is_refused(tmp_path: Path):
    scene, _ = loaded(tmp_path, *VIA)
    wraps = scene.character.muscles["pull"].wraps
    scene.character.muscles["pull"].wraps = [*wraps[1:], Wrap(wraps[0].surface, 1, 2)]
    with pytest.raises(SceneError, match="in the order in which the path meets them"):
        check_scene(scene)
