"""Routes of muscles as a kernel wants them: paths that wrap around surfaces, move, or whose points come in at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import from_rotation_vector, normalized, rotate
from warpmuscle.kernels import structs
from warpmuscle.kernels.path.route_bends import CYLINDER, ELLIPSOID, LEVER_BITS, SPHERE, TORUS, WRAP_BIT, RouteKind
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.kernels.path.wrap_ellipsoid import AXIAL, HYBRID, MIDPOINT
from warpmuscle.kernels.path.wrap_mujoco import SIDED
from warpmuscle.model.bodies import stacked
from warpmuscle.model.joints import by_coordinate
from warpmuscle.model.polynomials import monomial_room, put_polynomials
from warpmuscle.scene import (
    Character,
    CylinderSurface,
    EllipsoidSurface,
    Muscle,
    SphereSurface,
    Surface,
    TorusSurface,
    Wrap,
)
from warpmuscle.scene.joints.displacement import held_beyond, pieces
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.paths import has_rows, is_route, shares

ZERO = (0.0, 0.0, 0.0)
ANY_AXIS = 0  # of surfaces round both sides of which a path may go: none is read
SIDES = {"": (ANY_AXIS, 0)} | {
    f"{sign}{name}": (axis, int(f"{sign}1")) for axis, name in enumerate("xyz") for sign in "+-"
}
KINDS: dict[type[Surface], int] = {
    CylinderSurface: CYLINDER, SphereSurface: SPHERE, EllipsoidSurface: ELLIPSOID, TorusSurface: TORUS
}  # fmt: skip
ENDLESS = 1.0e30  # rad or m, of the coordinate of a point that moves everywhere
POINTS_A_SIZE = 4  # paths that have nearly as many points share a kernel
METHODS = {"hybrid": HYBRID, "midpoint": MIDPOINT, "axial": AXIAL}


def path_kind(muscles: Iterable[Muscle], character: Character, levers: int) -> PathKind:
    """What a step has compiled in for the paths of some muscles, whose routes have so many levers at most."""
    muscles = list(muscles)
    monomials = monomial_room(muscles)
    others = any(muscle.polynomial is None and not is_route(muscle) for muscle in muscles)
    routes = _kind_of_routes(muscles, character, levers)
    return PathKind(routes, monomials, others) if routes is not None or monomials > 0 else PathKind()


def _kind_of_routes(muscles: Sequence[Muscle], character: Character, levers: int) -> RouteKind | None:
    """What a step has compiled in for the routes of some muscles, None if they have none."""
    routes = [muscle for muscle in muscles if is_route(muscle)]
    if not routes:
        return None
    wraps = [wrap for muscle in routes for wrap in muscle.wraps]
    return RouteKind(
        max(len(muscle.wraps) for muscle in routes),
        levers,
        tuple(sorted({KINDS[type(character.surfaces[wrap.surface])] for wrap in wraps})),
        max(len(point.motion) for muscle in routes for point in muscle.path),
        any(point.condition is not None for muscle in routes for point in muscle.path),
        character.wrapping in ("shortest", "mujoco"),
        character.wrapping == "smooth",
        character.wrapping == "mujoco",
        any(muscle.branches for muscle in routes),
        character.wrapping == "mujoco" and any(has_rows(muscle) for muscle in routes),
        character.moving_points == "opensim",
        -(-max(len(muscle.path) for muscle in routes) // POINTS_A_SIZE) * POINTS_A_SIZE if wraps else 0,
    )


def fixed_segments(muscle: Muscle) -> list[tuple[int, int]]:
    """Neighbouring points of a route between which the length never changes; none where it has branches."""
    if muscle.branches:
        return []
    wrapped = [(wrap.first or 1, wrap.last or len(muscle.path)) for wrap in muscle.wraps]

    def fixed(b: int) -> bool:
        ends = muscle.path[b - 1], muscle.path[b]
        still = all(point.condition is None and not point.motion for point in ends)
        return ends[0].body == ends[1].body and still and not any(first <= b < last for first, last in wrapped)

    return [(b - 1, b) for b in range(1, len(muscle.path)) if fixed(b)]


def stops_beyond(muscle: Muscle, beyond: set[str], character: Character) -> tuple[int, bool]:
    """The stops of a route that are on some bodies, a bit each (see `structs.Lever`), and whether these are all."""
    bits = {k: point.body for k, point in enumerate(muscle.path)}
    bits |= {WRAP_BIT + k: character.surfaces[wrap.surface].body for k, wrap in enumerate(muscle.wraps)}
    on = [bit for bit, body in bits.items() if body in beyond]
    return sum(1 << bit for bit in on), len(on) == len(bits)


def moved_by(muscle: Muscle, joint: str) -> bool:
    """Whether a joint moves points of a muscle's path on their bodies."""
    return any(motion.joint == joint for point in muscle.path for motion in point.motion)


def routes_struct(
    muscles: Mapping[str, Any],
    levers: Sequence[Sequence[tuple[int, int, int, int]]],
    crossing: Mapping[tuple[int, int], int],
    first_condition: Sequence[int],
    names: Topology,
    character: Character,
    device: Any,
) -> structs.Routes:
    """The device structure of the routes of all muscles, by name (see `kernels.structs.Routes`).

    Args:
        muscles: their numbers are floats, or (n,) arrays with one value an instance.
        levers: of each muscle, crossing, joint, stops beyond it, and group of joints.
        crossing: by muscle and joint. first_condition: number of the first condition of each muscle's points.
    """
    paths = [muscle if isinstance(muscle, Muscle) and is_route(muscle) else None for muscle in muscles.values()]
    points = [[] if muscle is None else muscle.path for muscle in paths]
    wraps = [[] if muscle is None else muscle.wraps for muscle in paths]
    point_start, wrap_start, lever_start = (starts(map(len, lists)) for lists in (points, wraps, levers))
    r = structs.Routes()
    r.order = to_device(_order(list(muscles.values())), int, device)
    r.span = records_to_device(
        structs.RouteSpan, device,
        first_point=point_start[:-1], end_point=point_start[1:],
        first_wrap=wrap_start[:-1], end_wrap=wrap_start[1:],
        first_lever=lever_start[:-1], end_lever=lever_start[1:],
        origin=[_origin(muscle, names, character) for muscle in paths],
    )  # fmt: skip
    flat = [lever for of_muscle in levers for lever in of_muscle]
    r.lever = records_to_device(
        structs.Lever, device,
        crossing=[lever[0] for lever in flat], joint=[lever[1] for lever in flat], beyond=[lever[2] for lever in flat],
        group=[lever[3] for lever in flat],
        last=_ends_of_crossings(levers, names, character),
    )  # fmt: skip
    on_points = [bits_of_levers(own, k) for own, path in zip(levers, points, strict=True) for k in range(len(path))]
    _put_points(r, paths, on_points, crossing, first_condition, names, character, device)
    counts = [len(path) for path, around in zip(points, wraps, strict=True) for _ in around]
    on_wraps = [
        bits_of_levers(own, WRAP_BIT + k) for own, around in zip(levers, wraps, strict=True) for k in range(len(around))
    ]
    _put_wraps(r, [wrap for around in wraps for wrap in around], counts, on_wraps, names, character, device)
    put_polynomials(r, list(muscles.values()), crossing, names, device)
    return r


def _ends_of_crossings(
    levers: Sequence[Sequence[tuple[int, int, int, int]]], names: Topology, character: Character
) -> list[int]:  # fmt: skip
    """1 where what levers have gathered is to be given: the next one is of another crossing, or of another kind."""
    found = []
    for of_route in levers:
        kinds = [(crossing, by_coordinate(names.joints[joint - 1], character)) for crossing, joint, _, _ in of_route]
        found += [int(kinds[k + 1 : k + 2] != [kind]) for k, kind in enumerate(kinds)]
    return found


def bits_of_levers(levers: Sequence[tuple[int, int, int, int]], stop: int) -> int:
    """Which of a route's levers a stop is beyond, a bit each, see `structs.RoutePoint`."""
    return sum(1 << k for k, lever in enumerate(levers[:LEVER_BITS]) if lever[2] >> stop & 1)


def _order(muscles: Sequence[Any]) -> list[int]:
    """Numbers of muscles, those that take longest first, alike ones together: lanes that take one each wait for all."""

    def work(number: int) -> tuple[int, ...]:
        muscle = muscles[number]
        if not isinstance(muscle, Muscle):
            return 0, 0, 0, 0, 0, 0, len(muscle)
        terms = len(muscle.polynomial.coefficients) if muscle.polynomial is not None else 0
        motions = sum(len(point.motion) for point in muscle.path)
        conditions = sum(point.condition is not None for point in muscle.path)
        elastic = int(muscle.tendon != "rigid")
        return len(muscle.wraps), motions, conditions, terms, elastic, int(is_route(muscle)), len(muscle.path)

    return sorted(range(len(muscles)), key=work, reverse=True)


def _origin(muscle: Muscle | None, names: Topology, character: Character) -> int:
    """The body from whose joint a route is measured: that of its first surface, or of its first point."""
    if muscle is None:
        return 0
    body = character.surfaces[muscle.wraps[0].surface].body if muscle.wraps else muscle.path[0].body
    return names.bodies.index(body)


def from_joint(place: Floats, body: str, names: Topology, character: Character) -> Floats:
    """A place on a body, (rows, 3) m, from its joint instead of its centre of mass."""
    number = names.bodies.index(body)
    return place - rows(character.joints[names.joints[number - 1]].position_in_child if number > 0 else ZERO)


def _put_points(
    r: structs.Routes,
    paths: Sequence[Muscle | None],
    levers: Sequence[int],
    crossing: Mapping[tuple[int, int], int],
    first_condition: Sequence[int],
    names: Topology,
    character: Character,
    device: Any,
) -> None:
    """Points of all routes, and how they move; `levers` has the bits of each."""
    table: dict[str, list[int]] = {name: [] for name in structs.RoutePoint.vars}
    table["levers"] += levers
    moving: dict[str, list[float]] = {name: [] for name in structs.RouteMotion.vars}
    places: list[Floats] = []
    axes: list[Floats] = []
    start: list[Floats] = []
    cubics: list[Floats] = []
    for number, muscle in enumerate(paths):
        condition = first_condition[number]
        fixed = {b for _, b in fixed_segments(muscle)} if muscle is not None else set()
        for k, point in enumerate(muscle.path if muscle is not None else ()):
            table["body"].append(names.bodies.index(point.body))
            table["condition"].append(-1 if point.condition is None else condition)
            condition += point.condition is not None
            table["fixed"].append(int(k in fixed))
            table["first_motion"].append(len(axes))
            for motion in point.motion:
                joint = names.driver[names.body_of_joint(motion.joint)]
                knots, coefficients = pieces(motion)
                within = (-ENDLESS, ENDLESS)
                if motion.within and character.moving_points == "opensim":
                    within = (motion.within[0], motion.within[1])
                elif motion.within:
                    knots, coefficients = held_beyond(knots, coefficients, *motion.within)
                moving["low"].append(within[0])
                moving["high"].append(within[1])
                for name, value in (("joint", joint), ("crossing", crossing[number, joint])):
                    moving[name].append(value)
                moving["first_piece"].append(sum(map(len, start)))
                moving["end_piece"].append(sum(map(len, start)) + len(knots))
                axes.append(normalized(rows(motion.axis)))
                start.append(knots)
                cubics.append(coefficients)
            table["end_motion"].append(len(axes))
            places.append(from_joint(rows(point.place()), point.body, names, character))
    r.point = records_to_device(structs.RoutePoint, device, **table)
    if any(muscle is not None and muscle.branches for muscle in paths):
        counted = [share for muscle in paths if muscle is not None for share in shares(muscle)]
        r.share = to_device(rows(counted), float, device)
    r.motion = records_to_device(structs.RouteMotion, device, **moving)
    r.place = to_device(stacked(places or [rows(ZERO)]), wp.vec3, device)
    r.motion_axis = to_device(stacked(axes or [rows(ZERO)]), wp.vec3, device)
    count = max(map(len, cubics), default=1)
    every = [np.broadcast_to(part, (count, *part.shape[1:])) for part in cubics] or [np.zeros((1, 1, 4))]
    columns = {"start": np.concatenate(start or [np.zeros(1)])[None], "c": np.concatenate(every, axis=1)}
    r.piece = structs_to_device(structs.CubicPiece, columns, device)


def _put_wraps(
    r: structs.Routes,
    wraps: Sequence[Wrap],
    counts: Sequence[int],
    levers: Sequence[int],
    names: Topology,
    character: Character,
    device: Any,
) -> None:
    """What routes wrap around, with places and sizes of the surfaces.

    Args:
        counts: points of each wrap's route. levers: bits of each wrap.
    """
    surfaces = [character.surfaces[wrap.surface] for wrap in wraps]
    points = [getattr(surface, "side_point", None) for surface in surfaces]
    every = list(character.surfaces)
    r.wrap = records_to_device(
        structs.RouteWrap, device,
        body=[names.bodies.index(surface.body) for surface in surfaces],
        kind=[KINDS[type(surface)] for surface in surfaces],
        axis=[SIDES[surface.side][0] for surface in surfaces],
        side=[SIDES[one.side][1] if point is None else SIDED for one, point in zip(surfaces, points, strict=True)],
        first=[(wrap.first or 1) - 1 for wrap in wraps],
        last=[(wrap.last or count) - 1 for wrap, count in zip(wraps, counts, strict=True)],
        surface=[every.index(wrap.surface) for wrap in wraps],
        method=[METHODS[wrap.method] for wrap in wraps],
        levers=levers,
    )  # fmt: skip
    if not surfaces:
        r.wrap_row = wp.zeros((1, 1), dtype=structs.WrapRow, device=device)
        r.side_point = wp.zeros((1, 1), dtype=wp.vec3, device=device)
        return
    turns = stacked([from_rotation_vector(rows(surface.orientation)) for surface in surfaces])
    places = [from_joint(rows(surface.position), surface.body, names, character) for surface in surfaces]
    columns = {
        "rotation": np.swapaxes(rotate(turns[:, :, None], np.eye(3)), 2, 3),
        "position": stacked(places),
        "size": stacked([size_of(surface) for surface in surfaces]),
    }
    r.wrap_row = structs_to_device(structs.WrapRow, columns, device)
    r.side_point = to_device(stacked([rows(point or ZERO) for point in points]), wp.vec3, device)


def size_of(surface: Surface) -> Floats:
    """Radius, length, or radii of a surface, (rows, 3) m."""
    if isinstance(surface, CylinderSurface):
        return rows([surface.radius, surface.length, 0.0])
    if isinstance(surface, SphereSurface):
        return rows([surface.radius, 0.0, 0.0])
    if isinstance(surface, EllipsoidSurface):
        return rows(surface.radii)
    return rows([surface.inner_radius, surface.outer_radius, 0.0])
