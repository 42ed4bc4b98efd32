"""What a body leans on, beside the nearest points of a box and a segment that a search in float64 finds."""

import numpy as np
import warp as wp
from probes import filled, matrix
from scipy.optimize import minimize_scalar

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.object_structs import ObjectCapsule, ObjectExtension, ObjectRow
from warpmuscle.kernels.program.structs import Frames, Layout
from warpmuscle.kernels.program.supports import support_of

INSTANCES, BODIES = 40, 3
SUPPORTS = np.int32([[1, 0, 2], [0, 1, 1]])  # shape, object, body
HALF = np.array([[0.3, 0.04, 0.2], [0.0, 0.4, 0.0]])  # m, of a box thinner than it is rounded by, and of a capsule
RADIUS, ROUNDING = np.array([0.0, 0.03]), np.array([0.05, 0.0])  # m
FRICTION = np.array([0.3, 0.9])
CAPSULE = {
    "middle": np.array([[0.1, 0.02, -0.05], [-0.04, 0.0, 0.07]]),  # m
    "half": np.array([[0.0, 0.12, 0.05], [0.0, 0.0, 0.0]]),  # m; the second is a ball
    "radius": np.array([0.06, 0.09]),
}


@wp.kernel(enable_backward=False, module="unique")
def all_supports(
    layout: Layout,
    frames: Frames,
    objects: ObjectExtension,
    point: wp.array2d[wp.vec3],
    normal: wp.array2d[wp.vec3],
    number: wp.array2d[wp.vec2],
):
    instance, k = wp.tid()
    s = support_of(instance, k, layout, frames, objects)
    point[instance, k] = s.point
    normal[instance, k] = s.normal
    number[instance, k] = wp.vec2(s.gap, s.friction)


def nearest(first: np.ndarray, last: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a segment the point that is nearest to a box about the origin, and of the box the point nearest to that."""

    def at(t: float) -> np.ndarray:
        return first + t * (last - first)

    def distance(t: float) -> float:
        return float(np.linalg.norm(at(t) - np.clip(at(t), -half, half)))

    t = minimize_scalar(distance, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12}).x
    t = min((0.0, t, 1.0), key=distance)
    return at(t), np.clip(at(t), -half, half)


def test_points_normals_gaps_and_friction_are_those_of_the_nearest_points():
    rng = np.random.default_rng(4)
    places, turns = rng.uniform(-0.9, 0.9, (2, INSTANCES, BODIES, 3))[0], rng.normal(size=(INSTANCES, BODIES, 4))
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    of_object, place = rng.normal(size=(INSTANCES, 2, 4)), rng.uniform(-0.2, 0.2, (INSTANCES, 2, 3))
    of_object /= np.linalg.norm(of_object, axis=-1, keepdims=True)
    rows = {
        "half": np.broadcast_to(HALF, (INSTANCES, 2, 3)), "radius": np.broadcast_to(RADIUS, (INSTANCES, 2)),
        "rounding": np.broadcast_to(ROUNDING, (INSTANCES, 2)), "place": place, "orientation": of_object,
        "friction": FRICTION + 0.001 * np.arange(INSTANCES)[:, None],
    }  # fmt: skip
    objects = ObjectExtension()
    objects.row = structs_to_device(ObjectRow, {name: np.float32(values) for name, values in rows.items()}, "cpu")
    shapes = {name: np.float32(values)[None] for name, values in CAPSULE.items()}
    objects.capsule = structs_to_device(ObjectCapsule, shapes, "cpu")
    frames = filled(Frames, position=np.float32(places), orientation=np.float32(turns))
    point, normal = (wp.zeros((INSTANCES, 2), dtype=wp.vec3, device="cpu") for _ in range(2))
    number = wp.zeros((INSTANCES, 2), dtype=wp.vec2, device="cpu")
    given = [filled(Layout, support=SUPPORTS), frames, objects, point, normal, number]
    wp.launch(all_supports, (INSTANCES, 2), given, device="cpu")
    far = 0
    for i in range(INSTANCES):
        for k, (shape, which, body) in enumerate(SUPPORTS):
            turn, axes = matrix(turns[i, body][None])[0], matrix(of_object[i, which][None])[0]
            middle = places[i, body] + turn @ CAPSULE["middle"][shape] - place[i, which]
            along = turn @ CAPSULE["half"][shape]
            core = HALF[which] - np.minimum(ROUNDING[which], HALF[which])
            near, on = nearest(axes.T @ (middle - along), axes.T @ (middle + along), core)
            distance = np.linalg.norm(near - on)
            if distance < 0.02:  # inside a thin box: the way out is not that of a search
                continue
            far += 1
            away, skin = axes @ (near - on) / distance, RADIUS[which] + ROUNDING[which]
            np.testing.assert_allclose(normal.numpy()[i, k], away, atol=2e-3)
            np.testing.assert_allclose(point.numpy()[i, k], place[i, which] + axes @ on + skin * away, atol=2e-3)
            gap, friction = number.numpy()[i, k]
            np.testing.assert_allclose(gap, distance - skin - CAPSULE["radius"][shape], atol=1e-4)
            np.testing.assert_allclose(friction, rows["friction"][i, which], rtol=1e-6)
    assert far > 60
