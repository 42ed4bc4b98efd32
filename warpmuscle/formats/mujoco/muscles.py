"""Muscles from actuators that have MuJoCo's dynamics, gain and bias of muscles; springs of tendons as ligaments."""

from __future__ import annotations

from typing import Any

import msgspec

from warpmuscle.formats.mujoco.reference import Reference
from warpmuscle.formats.mujoco.tendons import Route, Tendons
from warpmuscle.scene import Ligament, MujocoCurves, Muscle, MuscleModel

MUSCLE_DYNAMICS, MUSCLE_GAIN, MUSCLE_BIAS = 4, 2, 2  # mjtDyn, mjtGain and mjtBias
ON_JOINT, ON_TENDON = 0, 3  # mjtTrn
SMALLEST = 1.0e-9  # of what is divided by
PASSIVE = [0, 1, 2, 3, 5, 7]  # numbers of a bias that its force depends on: range, force, scale, lmax, fpmax
TIMES = 1.0e-6  # s, least time constant


def build_muscles(
    reference: Reference, tendons: Tendons, moving: set[str], drives: set[int]
) -> tuple[MuscleModel, dict[str, Muscle]]:
    """All muscles, and what most of them have in common.

    Args:
        moving: joints that have a coordinate of their own, on which polynomials may depend.
        drives: actuators that are forces of the scene instead.
    """
    model = reference.model
    common = MuscleModel(curves="mujoco", activation="scaled", damping=0.0, initial_activation=0.0)
    muscles: dict[str, Muscle] = {}
    for actuator in range(model.nu):
        if actuator in drives:
            continue
        name = model.actuator(actuator).name or f"actuator{actuator}"
        found = _muscle(reference, tendons, actuator)
        if isinstance(found, Muscle) and found.polynomial and not set(found.polynomial.joints) <= moving:
            found = "is of a joint that has no coordinate of its own"
        if isinstance(found, str):
            reference.lose(f"actuator {name}", f"{found}; it is left out, and pulls on nothing")
            continue
        muscles[name] = found
    if muscles:
        _settle(common, list(muscles.values()))
    muscles |= _ligaments(reference, tendons, set(muscles))
    return common, muscles


def _settle(common: MuscleModel, muscles: list[Muscle]) -> None:
    """Give the model of all muscles the numbers that most of them have, and those their own no longer."""
    for field in ("v_max", "rise_time", "fall_time", "activation_smoothing", "curve_shape"):
        values = [getattr(muscle, field) for muscle in muscles]
        most = max(values, key=values.count)
        setattr(common, field, most)
        for muscle in muscles:
            if getattr(muscle, field) == most:
                setattr(muscle, field, None)


def _muscle(reference: Reference, tendons: Tendons, actuator: int) -> Muscle | str:
    """The muscle of an actuator, or why there is none."""
    model = reference.model
    kinds = (model.actuator_dyntype[actuator], model.actuator_gaintype[actuator], model.actuator_biastype[actuator])
    if kinds != (MUSCLE_DYNAMICS, MUSCLE_GAIN, MUSCLE_BIAS):
        return "is no muscle"
    of, gear = int(model.actuator_trnid[actuator, 0]), float(model.actuator_gear[actuator, 0])
    route: Route | str = "acts on neither a tendon nor a joint"
    if model.actuator_trntype[actuator] == ON_TENDON:
        route = tendons.route(of)
        if isinstance(route, Route) and route.path and gear <= 0.0:
            return "has a gear that is not positive"
    elif model.actuator_trntype[actuator] == ON_JOINT:
        route = tendons.sum_of([(of, 1.0)])
    if isinstance(route, str):
        return route
    if route.polynomial is not None:  # of whose length the gear is a part
        route.polynomial.coefficients = [gear * float(c) for c in route.polynomial.coefficients]  # type: ignore[arg-type]
        gear = 1.0
    return _hill(model, actuator, route, gear)


def _hill(model: Any, actuator: int, route: Route, gear: float) -> Muscle:
    """Its numbers as those of a fibre on a rigid tendon: with L = (length - l_slack)/l_opt MuJoCo's normalised length.

    MuJoCo's "Muscle actuators": over the range of lengths that the joints allow, L goes through the actuator's `range`.
    """
    lmin, lmax, v_max, fpmax, fvmax = (float(p) for p in model.actuator_gainprm[actuator, 4:9])
    l_opt, l_slack, f_max = _sizes(model, actuator, model.actuator_gainprm[actuator])
    curves = MujocoCurves(lmin, lmax, fpmax, fvmax)
    if tuple(model.actuator_biasprm[actuator, PASSIVE]) != tuple(model.actuator_gainprm[actuator, PASSIVE]):
        curves = _other_passive(model, actuator, curves, l_opt, l_slack, f_max)
    rise, fall = (max(float(time), TIMES) for time in model.actuator_dynprm[actuator, :2])
    return Muscle(
        path=route.path, wraps=route.wraps, branches=route.branches, polynomial=route.polynomial,
        f_max=max(f_max, SMALLEST) * gear, l_opt=l_opt / gear, l_slack=l_slack / gear, v_max=v_max,
        rise_time=rise, fall_time=fall, activation_smoothing=float(model.actuator_dynprm[actuator, 2]),
        curve_shape=curves,
    )  # fmt: skip


def _sizes(model: Any, actuator: int, numbers: Any) -> tuple[float, float, float]:
    """Length and force, m and N, for which 1 stands in the numbers of a gain or bias, and the length for 0, m."""
    low, high, force, scale = (float(p) for p in numbers[:4])
    first, last = (float(length) for length in model.actuator_lengthrange[actuator])
    l_opt = max((last - first) / max(high - low, SMALLEST), SMALLEST)
    f_max = force if force >= 0.0 else scale / max(float(model.actuator_acc0[actuator]), SMALLEST)
    return l_opt, first - low * l_opt, f_max


def _other_passive(
    model: Any, actuator: int, curves: MujocoCurves, l_opt: float, l_slack: float, f_max: float
) -> MujocoCurves:
    """The curves with a passive force as the numbers of the bias have it, over lengths and force of the active one."""
    numbers = model.actuator_biasprm[actuator]
    unit, zero, force = _sizes(model, actuator, numbers)
    begins, ends = ((zero + place * unit - l_slack) / l_opt for place in (1.0, float(numbers[5])))
    strength = float(numbers[7]) * force / max(f_max, SMALLEST)
    return msgspec.structs.replace(curves, passive_from=begins, passive_until=ends, passive_force=strength)


def _ligaments(reference: Reference, tendons: Tendons, taken: set[str]) -> dict[str, Muscle]:
    """Springs of spatial tendons, as far as they pull; what else tendons have is noted."""
    model = reference.model
    found = {}
    for tendon in range(model.ntendon):
        name, what = tendons.name(tendon), f"tendon {tendons.name(tendon)}"
        stiffness = float(model.tendon_stiffness[tendon])
        least, rest = (float(length) for length in model.tendon_lengthspring[tendon])
        for field, of in (("limited", "its limits"), ("damping", "its damping"), ("frictionloss", "its friction")):
            if getattr(model, f"tendon_{field}")[tendon] > 0:
                reference.lose(what, f"{of} have no effect here" if of == "its limits" else f"{of} has no effect here")
        if stiffness == 0.0:
            continue
        route = tendons.route(tendon)
        if isinstance(route, str) or route.polynomial is not None or rest <= 0.0:
            reason = route if isinstance(route, str) else "is no path of points, or pulls at any length"
            reference.lose(what, f"its spring is left out: it {reason}")
            continue
        if least > 0.0:
            reference.lose(what, "its spring pulls, and does not push")
        own = name if name not in taken else f"{name}_spring"
        spring = Ligament([1.0, 2.0], [0.0, 1.0], ends="linear")
        found[own] = Muscle(
            path=route.path, wraps=route.wraps, branches=route.branches, f_max=stiffness * rest, l_opt=rest,
            l_slack=rest, curve_shape=spring,
        )  # fmt: skip
    return found
