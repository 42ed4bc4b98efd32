"""The objective of a scene from the measures of a SCONE scenario, as far as there are terms for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.scone.start import matches
from warpmuscle.formats.scone.unknown import put_off, refuse
from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import plain_number

LABELS = (
    "name", "signature", "signature_prefix", "signature_postfix", "symmetric", "dual_sided", "minimize", "threshold",
    "threshold_transition", "result_offset", "omnidirectional", "soft_threshold", "scale_weight_by_relative_duration",
)  # fmt: skip
ENERGY = {"Wang2012": "wang", "Uchida2016": "umberger"}
EFFORT = {"SquaredMuscleActivation": "effort_squared", "CubedMuscleActivation": "effort_cubed"}
APPROXIMATE = "the nearest term is another one: "

PENALTIES = (("abs_penalty", "abs_range_penalty"), ("squared_penalty", "squared_range_penalty"))  # per what exceeds
CENTIMETRES = 100.0  # in a metre
UNCOUNTED = (
    "DofMeasure", "DofLimitMeasure", "JointMeasure", "JointLoadMeasure", "BodyMeasure", "MuscleMeasure", "StepMeasure",
)  # fmt: skip
BACKWARDS = "by its weight and `minimize` SCONE seeks falls, effort or low jumps; taken with the other sign"
THROUGHOUT = "counts over the whole time here"
PER_METRE = "activations over the mass and the way at the wanted speed, where SCONE takes the way that is walked"


def read_measures(nodes: Iterable[Node], scene: Scene, notes: Notes) -> None:
    """Put the measures of a scenario into a scene, and note what of them counts otherwise.

    Raises:
        SceneError: a measure is not known, with file and line.
    """
    for node in nodes:
        _measure(node, scene, notes, 1.0 if _minimized(node) else -1.0)


def _minimized(node: Node) -> bool:
    """Whether a search wants little of a measure; of several it wants what it wants of the first, unless it is said."""
    if node.key == "CompositeMeasure" and node.find("minimize") is None:
        counted = (child for child in _parts(node) if not child.truth_of("disabled", False))
        first = next((child for child in counted if child.key in MEASURES), None)
        return first is None or _minimized(first)
    usual = node.key != "JumpMeasure" or node.truth_of("negate_result", False)
    return node.truth_of("minimize", usual)


def _parts(node: Node) -> list[Node]:
    """The measures of a composite one, and what else has braces in it."""
    within = [*node.children, *(one for group in node.every("Measures") for one in group.children)]
    return [child for child in within if (child.children or child.key in MEASURES) and child.key != "Measures"]


def _measure(node: Node, scene: Scene, notes: Notes, factor: float) -> None:
    if node.key not in MEASURES:
        refuse(node, "measures", MEASURES)
    if put_off(node):
        return
    weight = factor * node.number_of("weight", 1.0)
    for label in LABELS:
        node.find(label)
    MEASURES[node.key](node, scene, notes, weight)
    for time in node.children:
        if time.key in ("start_time", "stop_time") and not time.used:
            time.used = True
            notes.ignore(time.file, time.line, f"{time.key} of {node.key}", THROUGHOUT)
    node.tell_unused()


def _weigh(node: Node, scene: Scene, notes: Notes, terms: Mapping[str, float], **fields: Any) -> None:
    """Give terms of the objective the weights that a measure says, and some of its fields other values."""
    if min(terms.values()) < 0.0:
        notes.ignore(node.file, node.line, node.key, BACKWARDS)
    weights = {name: abs(weight) for name, weight in terms.items()}
    scene.objective = msgspec.structs.replace(scene.objective, **weights, **fields)


def _composite(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """The weighted sum of others."""
    for child in _parts(node):
        child.used = True
        _measure(child, scene, notes, weight)


def _gait(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """A least speed of steps, and the height at which a fall ends the simulation."""
    for key in (
        "load_threshold", "min_step_duration", "initiation_steps", "base_bodies", "max_velocity", "continue_after_fall",
    ):  # fmt: skip
        node.find(key)
    scene.failure.com_height = node.number_of("termination_height", 0.5)
    speed = node.number_of("min_velocity", 0.0)
    if speed > 0.0:
        _weigh(node, scene, notes, {"speed": weight / scene.duration}, target_speed=speed)
        reason = f"squared error of the speed {speed:g} m/s, where SCONE counts what steps lack of it"
        notes.ignore(node.file, node.line, node.key, APPROXIMATE + reason)


def _balance(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """The part of the time that is missed by falling, and the height at which a fall ends the simulation."""
    scene.failure.com_height = node.number_of("termination_height", 0.5)
    _weigh(node, scene, notes, {"fall": weight / scene.duration})


def _effort(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """Metabolic energy over mass and distance, or activations."""
    kind = node.need("measure_type")
    transport = node.truth_of("use_cost_of_transport", False)
    tension = node.number_of("specific_tension", 2.5e5)
    for key in ("muscle_density", "min_distance", "order", "mechanical_work_order", "use_symmetric_fiber_ratios"):
        node.find(key)
    ratio = node.number_of("default_muscle_slow_twitch_ratio", 0.5)
    for muscle in scene.character.muscles.values():
        muscle.slow_fibres = ratio
    for group in node.every("MuscleProperties"):
        for one in group.every("MuscleProperties"):
            _put_ratio(one, scene)
        group.tell_unused()
    scene.muscle_model.specific_tension = tension
    each = node.truth_of("use_average_per_muscle", False)
    weight /= max(len(scene.character.muscles), 1) if each else 1
    if kind.text() in ENERGY:
        term = {"cost_of_transport": weight} if transport else {"metabolic": weight / scene.duration}
        _weigh(node, scene, notes, term, metabolic_model=ENERGY[kind.text()])
    elif kind.text() in EFFORT:
        over = (
            _mass(scene) * max(plain_number(scene.objective.target_speed) * scene.duration, 1.0)
            if transport
            else scene.duration
        )
        _weigh(node, scene, notes, {EFFORT[kind.text()]: weight / over})
        if transport:
            notes.ignore(node.file, node.line, node.key, APPROXIMATE + PER_METRE)
    else:
        kind.fail(f"{kind.text()!r} is not known here; there are {', '.join((*ENERGY, *EFFORT))}")


def _put_ratio(node: Node, scene: Scene) -> None:
    """The share of slow fibres of some muscles."""
    ratio, named = node.need("slow_twitch_ratio").number(), node.need("muscle")
    if not 0.0 <= ratio <= 1.0:
        node.fail(f"its slow_twitch_ratio is from 0 to 1, not {ratio:g}")
    for name, muscle in scene.character.muscles.items():
        if matches(name, named.text()):
            muscle.slow_fibres = ratio
    node.tell_unused()


def _mass(scene: Scene) -> float:
    """Of the body, kg."""
    return sum(plain_number(body.mass) for body in scene.character.bodies.values()) or 1.0


def _jump(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """How high the centre of mass comes, cm, of which a search wants much if its cost has a negative weight."""
    if node.number_of("jump_type", 0.0) != 0.0:
        node.fail("long jumps are not known here: leave out jump_type")
    if (body := node.find("body", "target_body")) is not None:
        reason = f"height of the centre of mass, where SCONE counts that of {body.text()}"
        notes.ignore(body.file, body.line, body.key, APPROXIMATE + reason)
    for key in ("termination_height", "prepare_time", "recover_time", "terminate_on_peak"):
        node.find(key)
    if not node.truth_of("negate_result", False):
        weight = -weight
    scene.failure.com_height = 0.0  # to land badly costs nothing there
    _weigh(node, scene, notes, {"rise": CENTIMETRES * weight})
    reason = "height above the start, to the end of the time, where SCONE may end at the peak and blames early jumps"
    notes.ignore(node.file, node.line, node.key, APPROXIMATE + reason)


def _left_out(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """A measure that no term is near to."""
    for child in node.children:
        child.used = True
    name = next((child.value for child in node.children if child.key in ("dof", "body", "muscle")), None)
    notes.ignore(
        node.file, node.line, node.key, f"{f'of {name}: ' if name else ''}no term counts what it does; left out"
    )


def _ground_force(node: Node, scene: Scene, notes: Notes, weight: float) -> None:
    """Ground forces beyond a bound."""
    bound = node.need("max").number()
    for key in ("start_time", "stop_time", "min", "use_force_per_leg", "mode"):
        node.find(key)
    for key in ("velocity", "acceleration"):
        if (change := node.find(key)) is not None:
            notes.ignore(change.file, change.line, f"{key} of {node.key}", "no term counts what it does; left out")
    penalties = [one.number() for key in PENALTIES if (one := node.find(*key)) is not None]
    weight *= next((one for one in penalties if one != 0.0), 0.0)
    _weigh(node, scene, notes, {"ground_force": weight / scene.duration}, ground_force_bound=bound)
    reason = "vertical force on each foot, from the start, where SCONE takes the length of that on both"
    notes.ignore(node.file, node.line, node.key, APPROXIMATE + reason)


MEASURES: dict[str, Callable[[Node, Scene, Notes, float], None]] = {
    "CompositeMeasure": _composite, "GaitMeasure": _gait, "BalanceMeasure": _balance, "EffortMeasure": _effort,
    "ReactionForceMeasure": _ground_force, "JumpMeasure": _jump, **dict.fromkeys(UNCOUNTED, _left_out),
}  # fmt: skip
