"""Joints that one coordinate moves are one for the paths that cross them together."""

from itertools import pairwise

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels import stages
from warpmuscle.model.build import replaced
from warpmuscle.model.joint_groups import GroupedPaths, grouped_paths
from warpmuscle.model.path_table import path_table
from warpmuscle.model.paths import paths_struct, route_struct
from warpmuscle.scene import (
    Body,
    Character,
    Condition,
    CylinderSurface,
    Displacement,
    Ground,
    Joint,
    Muscle,
    Scene,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages

UP, DOWN = (0.01, 0.08, -0.02), (0.02, -0.07, 0.01)
CURVE = Displacement((0.2, 0.9, -0.3), x=[-2.0, -1.0, 0.0, 1.0, 2.0], y=[-0.5, -0.2, 0.1, 0.3, 0.4])
SHIFT = Displacement((0.0, 1.0, 0.0), polynomial=[0.02, -0.03, 0.01])
BODIES = ("pelvis", "l5", "l4", "l3", "l2", "chest")
PLACES = (0.05, 0.01, -0.03), (-0.04, 0.02, 0.02)


def spine() -> Scene:
    """Five bodies, one on another: four joints follow the lowest, but for the middle one, which follows none."""
    character = Character("pelvis", {name: Body(1.0, (0.01, 0.02, 0.01)) for name in BODIES}, {}, "free")
    for k, (parent, child) in enumerate(pairwise(BODIES), 1):
        turns = [CURVE, Displacement((1.0, 0.3, 0.0), 0.1 * k, 0.3)]
        follows = "" if k in (1, 3) else "j1"
        character.joints[f"j{k}"] = Joint("coupled", parent, child, UP, DOWN, rotations=turns, translations=[SHIFT])
        character.joints[f"j{k}"].follows = follows
    ways = {"long": ("pelvis", "chest"), "back": ("chest", "l5"), "low": ("l5", "l4", "l3"), "upper": ("l2", "chest")}
    for name, way in ways.items():
        path = [ViaPoint(body, PLACES[k % 2]) for k, body in enumerate(way)]
        character.muscles[name] = Muscle(path=path, f_max=100.0, l_opt=0.1, l_slack=0.1)
    return Scene("spine", character, ground=Ground(stiffness=0.0))


def grouped(scene: Scene, together: bool = True) -> GroupedPaths:
    names = topology(scene.character)
    return grouped_paths(path_table(scene.character.muscles, names, scene.character), names, scene.character, together)


def arms(scene: Scene, together: bool) -> tuple[np.ndarray, np.ndarray]:
    """Speeds of paths (n, M) and moment arms (n, C, 3) in drawn states, with joints together or not."""
    scene_stages, names, c = Stages(scene, 5, "cpu"), topology(scene.character), scene.character
    rng, own = np.random.default_rng(3), grouped(scene, together)
    n, state = 5, scene_stages.state
    q = rng.uniform(-0.8, 0.8, (n, names.coordinates)).astype(np.float32)
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    state.coordinates.assign(q)
    state.speeds.assign(rng.normal(size=(n, names.speeds)).astype(np.float32))
    for name in ("group_turning", "group_moving"):
        setattr(state.muscles, name, wp.zeros((n, len(own.groups)), dtype=wp.vec3, device="cpu"))
    table = path_table(c.muscles, names, c)
    fields = {
        "paths": paths_struct(table, own, names, c, "cpu"), "muscles.count": len(c.muscles),
        "routes": route_struct(table, own, c.muscles, names, c, "cpu"),
    }  # fmt: skip
    kind = own.kind_of(c.muscles.values(), c)._replace(gathers=own.gathers)
    outputs = [((len(c.muscles),), float)] * 2 + [((len(table.crossings),), wp.vec3)]
    with replaced(scene_stages.model, fields):
        _, speed, arm = scene_stages._run(stages.muscle_paths_of(kind), [], outputs)
    return speed, arm


def test_joints_of_one_coordinate_between_the_ends_of_a_segment_are_one():
    own = grouped(spine())
    assert own.groups == [((1, 1), (2, 1), (4, 1), (5, 1)), ((2, 1), (4, 1), (5, 1))]
    by_muscle = [[(t.sign, t.joint, t.group) for t in terms] for terms in own.terms]
    assert (1, 1, 0) in by_muscle[0]  # pelvis to chest
    assert (-1, 2, 1) in by_muscle[1]  # the other way round, from above the lowest joint
    assert not own.gathers
    apart = grouped(spine(), together=False)
    assert apart.groups == []
    assert apart.gathers
    assert sum(map(len, apart.terms)) > sum(map(len, own.terms))


def test_a_joint_on_which_a_segment_counts_stays_by_itself():
    scene = spine()
    scene.character.muscles["long"].path.insert(1, ViaPoint("l3", PLACES[0], condition=Condition("j1", 0.1, 0.9, 0.3)))
    own = grouped(scene)
    assert ((2, 1), (4, 1), (5, 1)) in own.groups
    assert all(1 not in dict(group) for group in own.groups)


def test_stops_of_a_route_on_the_same_side_of_joints_make_them_one():
    scene = spine()
    scene.character.surfaces = {"rib": CylinderSurface("l3", (0.0, 0.0, 0.0), 0.03, 1.0)}
    scene.character.muscles["long"].wraps = [Wrap("rib")]
    for wrapping, count in (("smooth", 3), ("opensim", 5)):
        scene.character.wrapping = wrapping
        own = grouped(scene)
        assert own.most_levers == count
        assert any(lever.group >= 0 for levers in own.levers for lever in levers) == (wrapping == "smooth")


@pytest.mark.parametrize("change", ["none", "condition", "route"])
def test_moment_arms_are_those_of_joint_by_joint(change: str):
    scene = spine()
    if change == "condition":
        via = ViaPoint("l3", PLACES[0], condition=Condition("j1", -0.5, 0.5, 0.6))
        scene.character.muscles["long"].path.insert(1, via)
    if change == "route":
        scene.character.surfaces = {"rib": CylinderSurface("l3", (0.0, 0.0, 0.0), 0.03, 1.0)}
        scene.character.muscles["long"].wraps = [Wrap("rib")]
        scene.character.wrapping = "shortest"
    speed, arm = arms(scene, together=True)
    alone_speed, alone_arm = arms(scene, together=False)
    assert np.abs(alone_arm).max() > 0.05
    np.testing.assert_allclose(arm, alone_arm, atol=3e-7)
    np.testing.assert_allclose(speed, alone_speed, atol=3e-6)
