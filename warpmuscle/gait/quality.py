"""How good a recorded walk is: its speed, its curves beside the norm, what it costs, how its feet and muscles behave.

Each measure is a number with a name; `gait_table` has their units and what human walking has.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import first_number
from warpmuscle.gait.body_motion import body_measures
from warpmuscle.gait.cycles import (
    PERCENT,
    Strides,
    body_weight,
    leg_angles,
    over_strides,
    steady_strides,
)
from warpmuscle.gait.device_work import device_work
from warpmuscle.gait.features import KeyPoint, force_humps, greatest, least, norm_deviation, peak
from warpmuscle.gait.foot_contact import SIDES, Support, support
from warpmuscle.gait.foot_sliding import foot_sliding
from warpmuscle.gait.ground_force import vertical_forces
from warpmuscle.gait.joint_moments import MOMENTS_AT, from_people, leg_moments, leg_powers, likeness, mean_curves
from warpmuscle.gait.likeness import dimensionless_speed, from_norm, leg_length, means_at, norms_of, outside_span, trend
from warpmuscle.gait.measures import feet_of, heading, measure, steps_of
from warpmuscle.gait.muscle_effort import bhargava_costs, cost_of_transport, spent, trembling
from warpmuscle.gait.muscle_timing import active_windows, muscle_timing
from warpmuscle.gait.penetration import penetration
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.gait.swing import swing_measures
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import straight_legs
from warpmuscle.scene.masses import total_mass
from warpmuscle.scene.norms import FORCE, LEG_ANGLES, NORMS
from warpmuscle.scene.people.fukuchi import gained_by_speed

Measures = dict[str, float | None]
TIMING = "timing of the muscles"  # %
ACTIVE = "windows in which muscles are active"  # share
VARIABILITY = "variability of the step length"  # mm
INSIDE = "bodies inside each other"  # cm
AT = " at"  # at the end of the name of a percent of the cycle, behind the name of the value there
LEAST_NORMAL_SPEED = 0.3  # m/s forwards, below which norms do not apply
LEAST_FLIGHT = 1.0  # % of the cycle without a foot on the ground, from which on a gait is a run
# Key points by name: the curve, and the function and part of the cycle (%) that find it.
KEY_POINTS = {
    "hip, minimum": ("Hip flexion", least, 20.0, 80.0),
    "hip, maximum": ("Hip flexion", greatest, 50.0, 100.0),
    "knee, maximum in stance": ("Knee flexion", peak, 2.0, 45.0),
    "knee, maximum in swing": ("Knee flexion", greatest, 45.0, 100.0),
    "ankle, maximum in stance": ("Ankle dorsiflexion", greatest, 8.0, 62.0),
    "ankle, minimum at push-off": ("Ankle dorsiflexion", least, 45.0, 85.0),
}


def gait_measures(recording: Recording, scene: Scene) -> Measures:
    """All measures of a walk by name; None where the walk does not give one.

    They are of the steady part of the walk (see `measures.measure`), and those of curves the mean of both legs.

    Args:
        scene: without free parameters.

    Raises:
        Error: no legs, or no whole gait cycle.
    """
    recording = over_belts(recording, scene)
    cycles = steady_strides(recording, scene)
    gait = measure(recording, *feet_of(scene))
    steady = recording.window(gait.start)
    target = aimed_speed(scene)
    found: Measures = {
        "speed": gait.speed_forward,
        "target speed": target,
        "error of the speed": None if target is None else gait.speed_forward - target,
        "step length": gait.step_length,
        "step width": gait.step_width,
        "cadence": gait.cadence,
    }
    deviation = steps_of(recording, scene, gait.start).length_deviation
    found[VARIABILITY] = None if deviation is None else 1000.0 * deviation
    shares = support_of(recording, scene, cycles)
    running = runs(scene, shares)
    normal = gait.speed_forward >= LEAST_NORMAL_SPEED and straight_legs(scene)
    angles = _leg_angles(recording, scene)
    curves = {name: _means(recording.time, of_sides, cycles) for name, of_sides in angles.items()}
    return (
        found
        | {"stance": shares.stance, "double support": shares.double, "flight": shares.flight}
        | (_likeness(curves, scene, gait.speed_forward, running) if normal and curves else {})
        | (_of_angles(recording.time, angles, curves, cycles, normal and not running) if curves else {})
        | _of_force(recording, scene, cycles, normal and not running)
        | (_of_moments(recording, scene, cycles, normal and not running) if curves else {})
        | _of_muscles(steady, scene, gait.speed_horizontal)
        | device_work(steady, scene, gait.cadence)
        | body_measures(recording, scene, cycles, gait.speed_forward, gait.cadence, normal and not running)
        | _of_timing(recording, cycles, normal and not running)
        | swing_measures(recording, scene, cycles, shares.stance)
        | _of_headings(recording, scene, cycles)
        | _of_feet(steady, scene)
        | _of_bodies(recording, scene)
    )


def aimed_speed(scene: Scene) -> float | None:
    """Forward speed that a numeric scene aims at, m/s: the objective's target, if the objective asks for one."""
    objective = scene.objective
    terms = ("speed", "stride_speed")
    asked = any(first_number(getattr(objective, name)) != 0.0 for name in terms)
    asked = asked or any(name in stage.objective for stage in scene.stages for name in terms)
    target = first_number(objective.target_speed)
    return target if asked or target != type(objective)().target_speed else None


def support_of(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> Support:
    """Stance, double support and flight over gait cycles: from the first of them to the end of the last."""
    ends = [(of_side[0][0], of_side[-1][1]) for of_side in cycles.values()]
    shares = [support(recording, begin, end, body_weight(scene)) for begin, end in ends]
    return Support(*np.mean(shares, axis=0).tolist())


def runs(scene: Scene, shares: Support) -> bool:
    """Whether a gait is judged as running: its scene means a run, or, if it does not say, there is a flight."""
    if scene.objective.gait:
        return scene.objective.gait == "run"
    return shares.flight > LEAST_FLIGHT


def _leg_angles(recording: Recording, scene: Scene) -> dict[str, dict[str, Floats]]:
    """Angles of the legs, see `cycles.leg_angles`; none of legs that have fewer joints."""
    try:
        return leg_angles(recording, scene)
    except Error:
        return {}


def _likeness(angle_curves: Mapping[str, list[Floats]], scene: Scene, speed: float, running: bool) -> Measures:
    """Distances of the angles of both legs from published norms, in standard deviations; see `likeness`."""
    relative = dimensionless_speed(speed, leg_length(scene))
    norms = norms_of(running)
    outside: Measures = {}
    as_published: list[float | None] = []
    each: dict[str, list[float | None]] = {norm.source: [] for norm in norms}
    for name in LEG_ANGLES:
        curves = angle_curves[name]
        bands = [norm.angles[name] for norm in norms]
        moved = gained_by_speed(name, PERCENT, speed) if running else trend(name, relative)
        means, sds = means_at(bands, moved)
        published, _ = means_at(bands)
        outside[f"{_short(name)} outside the norms"] = _mean([outside_span(c, means, sds) for c in curves])
        as_published.append(_mean([outside_span(c, published, sds) for c in curves]))
        for norm, mean, sd in zip(norms, means, sds, strict=True):
            each[norm.source].append(_mean([from_norm(c, mean, sd) for c in curves]))
    found: Measures = {"angles outside the norms": _mean(list(outside.values())), **outside}
    found["angles outside the norms as published"] = _mean(as_published)
    return found | {f"angles from {source}": _mean(values) for source, values in each.items()}


def _of_angles(
    time: Floats,
    angles: Mapping[str, Mapping[str, Floats]],
    curves: Mapping[str, list[Floats]],
    cycles: dict[str, Strides],
    normal: bool,
) -> Measures:
    found: Measures = {}
    for name in LEG_ANGLES:
        found[f"deviation of the {_short(name)}"] = _deviation(name, curves[name], normal)
    three = [found[f"deviation of the {_short(name)}"] for name in LEG_ANGLES]
    found["deviation of the three angles"] = _mean(three)
    for key, (name, find, low, high) in KEY_POINTS.items():
        _put_point(found, key, [find(curve, low, high) for curve in curves[name]])
    begin = min(cycle[0][0] for cycle in cycles.values())
    found["knee, minimum"] = min(float(side[time >= begin].min()) for side in angles["Knee flexion"].values())
    for name in LEG_ANGLES:
        found[f"{name.lower()} within the norm band"] = _within(name, curves[name], normal)
    return found


def _of_force(recording: Recording, scene: Scene, cycles: dict[str, Strides], normal: bool) -> Measures:
    curves = _means(recording.time, vertical_forces(recording, scene), cycles)
    humps = [force_humps(curve) for curve in curves]
    found: Measures = {
        "deviation of the ground force": _deviation(FORCE, curves, normal),
        "maximum vertical force": float(np.mean([curve.max() for curve in curves])),
    }
    both = all(one.valley is not None for one in humps)  # else the legs have no shape in common
    _put_point(found, "first hump of the force", [one.first for one in humps])
    _put_point(found, "valley of the force", [one.valley if both else None for one in humps])
    _put_point(found, "second hump of the force", [one.second if both else None for one in humps])
    found["depth of the valley"] = min(one.depth for one in humps)
    found[f"{FORCE.lower()} within the norm band"] = _within(FORCE, curves, normal)
    return found


def _of_moments(recording: Recording, scene: Scene, cycles: dict[str, Strides], normal: bool) -> Measures:
    """Sagittal moments, N m/kg, where people's say most, and how far their curves are from people's, SD."""
    found: Measures = {}
    means: dict[str, Floats] = {}
    for name, of_sides in leg_moments(recording, scene).items():
        curves = mean_curves(recording, of_sides, cycles)
        means[name] = np.mean(curves, axis=0)
        found[f"{name.lower()} from people"] = from_people(name, curves) if normal else None
        found[f"likeness of the {name.lower()}"] = likeness(name, curves) if normal else None
    if normal:
        found |= {key: float(means[name][int(percent)]) for key, (name, percent) in MOMENTS_AT.items()}
        found["ankle moment, maximum"] = float(means["Ankle moment"].max())
    for name, of_sides in leg_powers(recording, scene).items():
        curves = mean_curves(recording, of_sides, cycles)
        found[f"{name.lower()}, maximum"] = float(np.mean(curves, axis=0).max())
        found[f"{name.lower()} from people"] = from_people(name, curves) if normal else None
    return found


def _of_bodies(recording: Recording, scene: Scene) -> Measures:
    """How deep bodies are inside each other, from the first frame on; nothing where no two bodies have shapes."""
    deepest = penetration(recording, scene)
    if deepest is None:
        return {}
    return {INSIDE: 100.0 * deepest.depth, "time inside each other": 100.0 * deepest.share}


def _of_muscles(steady: Recording, scene: Scene, speed: float) -> Measures:
    effort = spent(steady, scene)
    muscles = bool(steady.muscle_names)
    shaken = trembling(steady.time, steady.muscle_activation) if muscles else None
    mass = total_mass([scene.character.muscles[name] for name in steady.muscle_names], scene.muscle_model)
    return {
        "muscle mass": None if effort is None else mass,
        "metabolic power": None if effort is None else effort.power,
        "cost of transport": None if effort is None else cost_of_transport(effort.power, speed),
        "cost of transport at 0.25 MPa": None if effort is None else cost_of_transport(effort.common_power, speed),
        **bhargava_costs(steady, scene, speed),
        "share of passive force": None if effort is None else 100.0 * effort.passive_share,
        "mean activation": float(steady.muscle_activation.mean()) if muscles else None,
        "activation above 15 Hz": None if shaken is None else 100.0 * shaken,
    }


def _of_timing(recording: Recording, cycles: dict[str, Strides], normal: bool) -> Measures:
    """Whether muscles are excited when people's are, %, each and the mean of them; and the share of active windows."""
    if not normal:
        return {}
    each, windows = muscle_timing(recording, cycles), active_windows(recording, cycles)
    found: Measures = {} if not each else {TIMING: float(np.mean(list(each.values())))}
    found |= {f"timing of {muscle}": value for muscle, value in each.items()}
    return found | ({ACTIVE: float(np.mean([one.is_met for one in windows]))} if windows else {})


def _of_headings(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> Measures:
    """Headings in the mean of a gait cycle, in which the pelvis turns to and fro."""
    turned, desired = np.degrees(heading(recording)), float(np.degrees(first_number(scene.heading)))
    means = [[over_strides(recording.time, turned, [cycle]).mean() for cycle in cycles[side]] for side in SIDES]
    drift = float(np.mean([side[-1] - side[0] for side in means]))
    return {"drift of the heading": drift, "maximum error of the heading": _greatest_error(means, desired)}


def _greatest_error(means: list[list[float]], desired: float) -> float:
    """The heading that is farthest from the desired one, deg, 180 at most."""
    errors = [abs((value - desired + 180.0) % 360.0 - 180.0) for side in means for value in side]
    return float(max(errors))


def _of_feet(steady: Recording, scene: Scene) -> Measures:
    contact = foot_sliding(steady, scene)
    return {
        "slide of the stance foot": 100.0 * contact.mean_slide,
        "maximum slide of the stance foot": 100.0 * contact.greatest_slide,
        "drag of the trailing foot": 100.0 * contact.mean_drag,
        "depth of the feet": 1000.0 * contact.depth,
    }


def _means(time: Floats, sides: Mapping[str, Floats], cycles: dict[str, Strides]) -> list[Floats]:
    """The mean curve (101,) of each side over its gait cycles."""
    return [over_strides(time, sides[side], cycles[side]).mean(axis=0) for side in SIDES]


def _deviation(name: str, curves: list[Floats], normal: bool) -> float | None:
    return float(np.mean([norm_deviation(name, curve) for curve in curves])) if normal else None


def _within(name: str, curves: list[Floats], normal: bool) -> float | None:
    """Part of the cycle in which the mean of both legs is in the norm band, %."""
    if not normal:
        return None
    norm = NORMS[name]
    inside = np.abs(np.mean(curves, axis=0) - norm.mean(PERCENT)) <= norm.half_width
    return 100.0 * float(inside.mean())


def _put_point(found: Measures, key: str, points: list[KeyPoint | None]) -> None:
    """A key point, the mean of the legs that have it, and the percent of the cycle at which it is."""
    there = [point for point in points if point is not None]
    found[key] = float(np.mean([point.value for point in there])) if there else None
    found[key + AT] = float(np.mean([point.percent for point in there])) if there else None


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _short(name: str) -> str:
    return name.split()[0].lower()
