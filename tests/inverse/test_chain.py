"""Chains against the bodies of inverse dynamics, differences, and OpenSim."""

import numpy as np
import pytest

from leg_model import chain_of, leg, walk
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.chain import Place
from warpmuscle.scene.opensim_root import root_motion
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import body_points


def test_bodies_are_where_inverse_dynamics_has_them(tmp_path):
    scene = leg(tmp_path)
    chain = chain_of(scene)
    q = walk(chain, 7)
    names = topology(scene.character)
    root = root_motion(scene.opensim, q[:, :6])
    state = np.concatenate([root.position, root.orientation, np.zeros((7, names.coordinates - 7))], axis=1)
    for number, joint in enumerate(names.joints, start=1):
        if joint in chain.coordinates:
            state[:, names.coordinates_of(number)] = q[:, [chain.coordinates.index(joint)]]
    placed = body_points(scene, state)
    poses = chain.poses(q)
    for joint in scene.character.joints.values():
        at, turn = placed[joint.child]
        expected = at - rotate(turn, np.array(joint.position_in_child))
        own = chain.places(poses, [chain.bodies[joint.child]])[:, 0]
        assert np.abs(own - expected).max() < 1e-12


def test_the_jacobian_is_that_of_differences(tmp_path):
    chain = chain_of(leg(tmp_path))
    q, places = walk(chain, 5), list(chain.markers.values())
    found = chain.jacobian(q, places)
    for k in range(q.shape[1]):
        step = 1e-6 * np.eye(q.shape[1])[k]
        after, before = (chain.places(chain.poses(q + sign * step), places) for sign in (1.0, -1.0))
        assert np.abs(found[..., k] - (after - before) / 2e-6).max() < 1e-8


def test_locked_coordinates_stay_and_coupled_ones_follow(tmp_path):
    chain = chain_of(leg(tmp_path, locked="ankle"))
    assert "ankle" not in chain.coordinates
    assert "beta" not in chain.coordinates
    names, values = chain.all_values(walk(chain, 4))
    assert np.all(values[:, names.index("ankle")] == 0.0)
    assert values[:, names.index("beta")] == pytest.approx(0.5 * values[:, names.index("knee")] + 0.05)


def test_ranges_are_those_that_the_model_clamps_but_for_the_root(tmp_path):
    chain = chain_of(leg(tmp_path))
    at = chain.coordinates.index("knee")
    assert (chain.low[at], chain.high[at]) == (-2.0, 0.2)
    assert chain.high[chain.coordinates.index("tx")] == np.inf
    assert set(chain_of(leg(tmp_path, clamped=False)).high) == {np.inf}


def test_a_chain_of_a_shipped_scene_has_coordinates_of_balls_and_hinges():
    chain = chain_of(load("fwalk"))
    assert chain.coordinates[:3] == ["pelvis_tilt", "pelvis_list", "pelvis_rotation"]
    assert len(set(chain.coordinates)) == len(chain.coordinates)
    q = 0.1 * np.random.default_rng(0).normal(size=(3, len(chain.coordinates)))
    ends = [place for place in chain.bodies.values() if place.element >= 0]
    found = chain.jacobian(q, ends)
    step = 1e-6 * np.eye(q.shape[1])[-1]
    moved = (chain.places(chain.poses(q + step), ends) - chain.places(chain.poses(q - step), ends)) / 2e-6
    assert np.abs(found[..., -1] - moved).max() < 1e-8


@pytest.mark.parametrize("model", ["opensim_walk/subject01.osim", "inverse/synthetic_walk/unscaled_generic.osim"])
def test_markers_are_where_opensim_has_them(reference_data, model):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    path = reference_data / model
    if not path.is_file():
        pytest.skip(f"no reference data: {path}")
    opensim.Logger.setLevelString("off")
    chain = chain_of(load(path, ignored=[]))
    theirs = opensim.Model(str(path))
    state = theirs.initSystem()
    q = np.array(chain.neutral) + 0.15 * np.random.default_rng(3).normal(size=(3, len(chain.coordinates)))
    q = np.clip(q, chain.low, chain.high)
    places = chain.places(chain.poses(q), list(chain.markers.values())) @ TO_OPENSIM.T
    for row, place in zip(q, places, strict=True):
        for name, value in zip(chain.coordinates, row, strict=True):
            theirs.getCoordinateSet().get(name).setValue(state, float(value), False)
        theirs.assemble(state)
        theirs.realizePosition(state)
        for name, own in zip(chain.markers, place, strict=True):
            at = theirs.getMarkerSet().get(name).getLocationInGround(state)
            assert np.abs([at[k] - own[k] for k in range(3)]).max() < 5e-6, name  # couplers are assembled


def test_a_point_of_the_ground_stays(tmp_path):
    chain = chain_of(leg(tmp_path))
    place = Place(-1, np.array([1.0, 2.0, 3.0]))
    assert np.all(chain.places(chain.poses(walk(chain, 3)), [place]) == [1.0, 2.0, 3.0])
    assert np.all(chain.jacobian(walk(chain, 3), [place]) == 0.0)
