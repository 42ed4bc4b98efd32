"""Muscles as MuJoCo's tendons, with sites at their via points, and its muscle actuators; see `mjcf.py`."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.mjcf_text import numbers, text, texts
from warpmuscle.formats.mjcf_wraps import add_geom, wrap_geoms
from warpmuscle.model.muscles import driven
from warpmuscle.scene import Character, Ligament, MujocoCurves, Muscle, MuscleModel, PathActuator, Scene
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.muscles import given, is_cable
from warpmuscle.scene.muscles.cables import LIGAMENTS, is_straight
from warpmuscle.scene.topology import topology

_OPERATING = (0.5, 1.5)  # fibre lengths over the optimal one that MuJoCo's lengthrange stands for; any two would do


def add_muscles(model: Element, scene: Scene) -> int:
    """Append sites, tendons and actuators of the muscles; the number of actuators that have an activation."""
    muscles = scene.character.muscles
    if not muscles:
        return 0
    bodies = {element.get("name"): element for element in model.iter("body")}
    tendons, actuators = SubElement(model, "tendon"), SubElement(model, "actuator")
    for name, muscle in muscles.items():
        if muscle.pulleys:
            _add_pulleys(SubElement(tendons, "fixed", name=name), muscle, scene.character)
            continue
        if muscle.polynomial is not None:
            message = "MuJoCo has no path that is a polynomial; leave the muscle out, or give it points"
            raise SceneError(message, key=f"character.muscles.{name}.polynomial")
        around = wrap_geoms(tendons, name, muscle, scene.character)
        surfaces = {id(surface): key for key, surface in scene.character.surfaces.items()}
        tendon = SubElement(tendons, "spatial", _spring(name, muscle), name=name)
        divisors = {branch.first - 1: branch.divisor for branch in muscle.branches}
        for index, point in enumerate(muscle.path):
            if index in divisors:
                SubElement(tendon, "pulley", divisor=text(plain_number(divisors[index])))
            if point.condition is None:
                if point.body not in bodies:
                    message = f"{point.body!r} has no mass, so that MuJoCo knows no such body; put the point elsewhere"
                    raise SceneError(message, key=f"character.muscles.{name}.path.{index}.body")
                site = f"{name}_{index}"
                SubElement(bodies[point.body], "site", name=site, pos=texts(numbers(point.place())), size="0.005")
                SubElement(tendon, "site", site=site)
                if index in around:
                    add_geom(tendon, around[index], surfaces[id(around[index])], bodies)
    acting = driven(scene, topology(scene.character)).muscles
    for name in acting:
        muscle = muscles[name]
        if not is_cable(muscle):
            tag, numbers_of_it = _actuator(muscle, scene.muscle_model)
            SubElement(actuators, tag, numbers_of_it, name=name, tendon=name)
        elif isinstance(muscle.curve_shape, PathActuator):
            pull = {"gear": text(-plain_number(muscle.f_max)), "ctrlrange": "0 1"}
            SubElement(actuators, "motor", pull, name=name, tendon=name)
    return sum(not is_cable(muscles[name]) for name in acting)


def _spring(name: str, muscle: Muscle) -> dict[str, str]:
    """Attributes of a tendon that is a ligament, slack up to its length at rest.

    Raises:
        SceneError: its tension is not straight over its length.
    """
    shape = muscle.curve_shape
    if not isinstance(shape, LIGAMENTS):
        return {}
    if not isinstance(shape, Ligament) or not is_straight(shape):
        message = "MuJoCo's tendons are springs without damping; leave the ligament out, or make its curve straight"
        raise SceneError(message, key=f"character.muscles.{name}.curve_shape")
    rest = plain_number(muscle.l_slack)
    return {"stiffness": text(plain_number(muscle.f_max) / rest), "springlength": texts([0.0, rest])}


def _add_pulleys(tendon: Element, muscle: Muscle, character: Character) -> None:
    """The joint angles that a muscle runs over at constant radii; MuJoCo counts its length from the reference pose."""
    for pulley in muscle.pulleys:
        stands_for = joint_type(character.joints[pulley.joint]).mujoco
        suffix = next(part.suffix for part in stands_for if part.axis == pulley.axis)
        SubElement(tendon, "joint", joint=pulley.joint + suffix, coef=text(-plain_number(pulley.moment_arm)))


def _length_in_reference_pose(muscle: Muscle) -> float:
    """Of a muscle on pulleys, m; 0 of others, whose lengths MuJoCo computes itself."""
    if muscle.rest_length is None:
        return 0.0
    return plain_number(muscle.rest_length) + sum(
        plain_number(p.moment_arm) * plain_number(p.rest_angle) for p in muscle.pulleys
    )


def _actuator(muscle: Muscle, model: MuscleModel) -> tuple[str, dict[str, str]]:
    """Tag and attributes of MuJoCo's muscle actuator, or a general one where its passive force begins elsewhere.

    It knows a muscle's lengths by the path lengths, m, at which its fibre has the lengths `range`. With pennation the
    fibre counts as it acts along the tendon about its optimal length.
    """
    cosine = math.cos(plain_number(muscle.pennation))
    optimal = plain_number(muscle.l_slack) + plain_number(muscle.l_opt) * cosine - _length_in_reference_pose(muscle)
    shape = given(muscle, model, "curve_shape")
    lengths = (optimal + (relative - 1.0) * plain_number(muscle.l_opt) / cosine for relative in _OPERATING)
    plain = (
        {
            "ctrlrange": "0 1",
            "force": text(plain_number(muscle.f_max) * cosine),
            "range": texts(_OPERATING),
            "lengthrange": texts(lengths),
            "vmax": text(plain_number(given(muscle, model, "v_max"))),
            "timeconst": texts(plain_number(given(muscle, model, field)) for field in ("rise_time", "fall_time")),
        }
        | _smoothing(muscle, model)
        | (_curves(shape) if isinstance(shape, MujocoCurves) else {})
    )
    if not isinstance(shape, MujocoCurves) or (shape.passive_until is None and shape.passive_from == 1.0):
        return "muscle", plain
    return "general", _with_bias(plain, shape)


def _with_bias(plain: dict[str, str], shape: MujocoCurves) -> dict[str, str]:
    """The same as attributes of a general actuator, whose bias counts lengths from where the passive force begins."""
    usual = {"scale": "200"}
    gain = [(plain | usual)[name] for name in ("force", "scale", "lmin", "lmax", "vmax", "fpmax", "fvmax")]
    begins = plain_number(shape.passive_from)
    ends = plain_number(shape.active_until if shape.passive_until is None else shape.passive_until)
    bias = [*gain[:3], text(1.0 + ends - begins), *gain[4:]]
    lengths = [texts(relative + off for relative in _OPERATING) for off in (0.0, 1.0 - begins)]
    times = " ".join([plain["timeconst"], *([plain["tausmooth"]] if "tausmooth" in plain else [])])
    return {
        "ctrlrange": plain["ctrlrange"], "dyntype": "muscle", "gaintype": "muscle", "biastype": "muscle",
        "dynprm": times, "gainprm": f"{lengths[0]} {' '.join(gain)}", "biasprm": f"{lengths[1]} {' '.join(bias)}",
        "lengthrange": plain["lengthrange"],
    }  # fmt: skip


def _smoothing(muscle: Muscle, model: MuscleModel) -> dict[str, str]:
    """Over what the time constant changes, where it does not change at once."""
    width = plain_number(given(muscle, model, "activation_smoothing"))
    return {"tausmooth": text(width)} if width > 0.0 else {}


def _curves(shape: MujocoCurves) -> dict[str, str]:
    """Attributes of MuJoCo's own curves."""
    fields = {"lmin": "active_from", "lmax": "active_until", "fpmax": "passive_force", "fvmax": "lengthening_force"}
    return {name: text(plain_number(getattr(shape, field))) for name, field in fields.items()}
