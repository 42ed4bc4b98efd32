"""Routes as device arrays: which joint moves a point, by which pieces of its curve."""

import numpy as np

from muscle_arm import arm
from warpmuscle.model.build import build_model
from warpmuscle.model.routes import fixed_segments
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import Condition, Muscle, PointMotion, ViaPoint, Wrap


def test_points_that_joints_move_know_their_joint_their_crossing_and_their_pieces():
    scene = arm()
    flexor, extensor = scene.character.muscles["flexor"], scene.character.muscles["extensor"]
    across, along = (0.0, 0.0, 2.0), (0.0, 1.0, 0.0)
    flexor.path[1].motion = [
        PointMotion(across, slope=0.03, joint="elbow"),
        PointMotion(along, slope=-0.01, joint="elbow"),
    ]
    extensor.path[2].motion = [PointMotion(along, slope=0.02, joint="elbow")]
    routes = build_model(scene, structure_of(scene), "cpu").routes
    points, motions = routes.point.numpy(), routes.motion.numpy()
    assert motions["joint"].tolist() == [1, 1, 1]  # the body on the joint
    assert len(motions["crossing"]) == 3
    assert motions["crossing"][0] == motions["crossing"][1] != motions["crossing"][2]  # a muscle's over a joint
    assert (motions["first_piece"][0], *motions["first_piece"][1:]) == (0, *motions["end_piece"][:-1])
    moves = {
        int(k): (first, end)
        for k, (first, end) in enumerate(zip(points["first_motion"], points["end_motion"], strict=True))
        if end > first
    }
    assert sorted(moves.values()) == [(0, 2), (2, 3)]
    np.testing.assert_allclose(routes.motion_axis.numpy()[0], [(0.0, 0.0, 1.0), along, along])
    # On the base from its centre of mass, in which it is hung up; on the tip from the elbow, 0.2 m above its centre.
    places = sorted(map(tuple, np.round(routes.place.numpy()[0].astype(float), 6).tolist()))
    assert places == sorted((0.0, y, z) for z in (0.04, -0.04) for y in (0.2, 0.12, -0.1))


def test_between_points_of_a_body_that_stay_where_they_are_the_length_never_changes():
    moves = PointMotion((0.0, 0.0, 1.0), slope=0.03, joint="elbow")
    path = [ViaPoint(body, (0.0, 0.1 * k, 0.0)) for k, body in enumerate(["base"] * 5 + ["tip"] * 3)]
    path[2].motion = [moves]
    path[6].condition = Condition("elbow", 0.0, 1.0)
    muscle = Muscle(path=path, f_max=1.0, l_opt=0.1, l_slack=0.1)
    assert fixed_segments(muscle) == [(0, 1), (3, 4)]
    muscle.wraps = [Wrap("ball", 4, 6)]
    assert fixed_segments(muscle) == [(0, 1)]
