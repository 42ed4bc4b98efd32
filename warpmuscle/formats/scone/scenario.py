"""A scene from a SCONE scenario with its model, or from a model of Hyfydy alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.plain_text import readable
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build import load_model
from warpmuscle.formats.scone.controller import CONTROLLERS, read_controllers
from warpmuscle.formats.scone.joints import Coordinate
from warpmuscle.formats.scone.measures import MEASURES, read_measures
from warpmuscle.formats.scone.model import HyfydyModel, Options, read_model
from warpmuscle.formats.scone.modifiers import put_modifiers
from warpmuscle.formats.scone.numbers import FreeNumber, read_number
from warpmuscle.formats.scone.parameters import Parameter, read_parameters
from warpmuscle.formats.scone.reflexes import Bindings, Sensed
from warpmuscle.formats.scone.start import Start, matches, put_load, put_start, read_states
from warpmuscle.formats.scone.unknown import refuse
from warpmuscle.formats.scone.zml import Node, find_beside, parse
from warpmuscle.scene import Scene
from warpmuscle.scene.gait_states.part import sided
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.validation.scene import check_scene

OPTIMIZERS = (
    "CmaOptimizer", "CmaOptimizerSpot", "CmaPoolOptimizer", "EvaOptimizer", "EsOptimizer", "MesOptimizer",
    "SimilarityOptimizer",
)  # fmt: skip
OBJECTIVES = ("SimulationObjective",)
MODELS = (  # the last ones by names of older and newer versions
    "ModelHyfydy", "ModelOpenSim3", "ModelOpenSim4", "ModelHyfydyPrecise", "ModelHfd", "OpenSimModel", "Simbody",
)  # fmt: skip
INIT = ("init", "init_file")
NAMES = ("signature_prefix", "signature_postfix", "name", "output_root")
UNUSED = "the search has options of its own here, see `warpmuscle optimize --help`; not used"
OPTIONS = {"lambda": "--population", "population_size": "--population", "random_seed": "--seed"}  # of `optimize`
FORCES = (
    "planar_joint_force_pnld", "joint_force_pnld", "simple_collision_detection", "joint_motor_force", "gravity",
)  # fmt: skip
SETTINGS = (  # of the model, that change nothing here
    "signature_postfix", "scone_version", "hyfydy_version", "name", "use_fixed_control_step_size", "max_step_size",
    "integration_accuracy", "integration_method", "enable_external_forces", "fixed_measure_step_size",
    "initial_load_dof", "leg_upper_body", "leg_lower_body", "leg_contact_force",
    "max_integration_step_size", "planar", "use_omnidirectional_root_dofs", "zero_velocity_equilibration",
    "neural_delays", "user_input_file", "use_swing_twist_joint_limits",
    "move_static_bodies", "enable_interaction", "include_dofs_in_state",
)  # fmt: skip
UNFELT = {  # settings of a model that change how it moves
    "max_muscle_activation": "muscles are excited up to 1",
    "max_individual_muscle_activation": "muscles are excited up to 1",
    "muscle_input_soft_limits": "excitations are cut at 0 and 1",
    "muscle_input_limit_type": "excitations are cut at 0 and 1", "blueprint": "the ground is level",
}  # fmt: skip
SHARED = "numbers that several places share by a name are not known here: write each where its name stands"
IN_OR_OUT = {"include": "*", "exclude": ""}  # what of a start has offsets, where nothing is said
OFFSETS = "start where their offsets put them, {fixed}: a search does not change them here"
TIME_STEP = 0.001  # s
CONTROL_STEP = 0.005


def load_scenario(path: Path, notes: Notes, values: Path | None = None) -> Scene:
    """A checked scene of a scenario, or of a model.

    Args:
        notes: gets what is not used, or is taken otherwise, with its line.
        values: a .par file, from whose best values free numbers start.

    Raises:
        SceneError: with file and line.
    """
    parameters = {} if values is None else read_parameters(values)
    top = parse(path, notes)
    if top.find("model") is not None:
        found = read_model(top, notes)
        found.scene.name = readable(path.stem)
        found.scene.time_step = TIME_STEP
        put_start(found.scene, found.coordinates, {}, {})
        put_load(found.scene, 1.0)
        scene = found.scene
        bindings = Bindings(parameters)
    else:
        scene, bindings = _Scenario(top, path, notes, parameters).scene()
    if values is not None:
        _tell_unknown(values, parameters, bindings, notes)
    try:
        check_scene(scene)
    except SceneError as error:
        raise notes.placed(error) from None
    return scene


class _Scenario:
    """Reads one scenario."""

    def __init__(self, top: Node, path: Path, notes: Notes, parameters: Mapping[str, Parameter]) -> None:
        self._top, self._path, self._notes = top, path, notes
        self._bindings = Bindings(parameters)
        self._begun: dict[str, float] = {}  # parameters that say how it starts

    def scene(self) -> tuple[Scene, Bindings]:
        """The scene, and where its parameters are."""
        optimizer = self._top.find(*OPTIMIZERS) or self._top
        objective = optimizer.find(*OBJECTIVES)
        if objective is None and any(one.key in MODELS for one in self._top.children):
            optimizer = objective = self._top  # a model alone, as what scripts of SCONE load
        if objective is None:
            parts = [one for one in optimizer.children if one.key.endswith(("Controller", "Measure"))]
            if parts:
                parts[0].fail(
                    "is a part of scenarios, which name its file: open one of them, with an optimizer and a model"
                )
            for one in optimizer.children:
                if one.key.endswith("Objective"):
                    refuse(one, "objectives", OBJECTIVES)
            self._top.fail(f"there is no {OBJECTIVES[0]} in it, nor a model of Hyfydy")
        self._init(optimizer)
        if optimizer is not self._top:
            self._search(optimizer)
        for key in ("signature_prefix", "signature_postfix", "name", "auto_std_minimum", "start_time", "minimize"):
            objective.find(key)
        self._bindings.std_factor = objective.number_of("auto_std_factor", self._bindings.std_factor)
        if (shared := objective.find("Parameters")) is not None:
            shared.fail(SHARED)
        node = objective.find(*MODELS)
        if node is None:
            objective.fail(f"there is no model in it; there are {', '.join(MODELS)}")
        found = self._model(node)
        scene = found.scene
        scene.name, scene.time_step = readable(self._path.stem), TIME_STEP
        scene.duration = objective.number_of("max_duration", node.number_of("simulation_end_time", 10.0))
        scene.failure.heading = 0.0  # measures end a simulation by its height alone
        root = {name: found.coordinates[name] for name in found.root if name in found.coordinates}
        motors = {name: (found.coordinates[name], force) for name, force in found.motors.items()}
        body = Sensed(root, motors, _version(node))
        groups = [objective, node, *node.every("Controllers")]
        read_controllers(_every(groups, CONTROLLERS), scene, body, self._bindings, self._notes)
        read_measures(_every(groups, MEASURES), scene, self._notes)
        for group in groups[2:]:
            _tell_unknown_parts(group)
        _tell_unknown_parts(objective)
        if scene.gait_states is not None:
            scene.gait_states.control_step = node.number_of("fixed_control_step_size", CONTROL_STEP)
            scene.gait_states.least = node.number_of("min_muscle_activation", 0.01)
        node.find("fixed_control_step_size")
        node.find("min_muscle_activation")
        self._start(node, found)
        for one in node.every(*UNFELT):
            self._notes.ignore(one.file, one.line, one.key, f"not known here, and not used: {UNFELT[one.key]}")
        _tell_unknown_parts(node)
        return scene, self._bindings

    def _search(self, optimizer: Node) -> None:
        """Note how SCONE would search, which no scene says; SceneError at what else stands beside the objective."""
        for option in optimizer.children:
            if option.key in NAMES:
                option.used = True
            elif option.value is not None and option.key not in INIT:
                option.used = True
                same = OPTIONS.get(option.key)
                reason = f"{same} {option.value} of `warpmuscle optimize` is the same; not used" if same else UNUSED
                self._notes.ignore(option.file, option.line, option.key, reason)
        optimizer.tell_unused()

    def _init(self, optimizer: Node) -> None:
        """Let numbers start from the file that a search starts from, unless another one was given."""
        node = optimizer.find("init")
        file = optimizer.find("init_file") if node is None else node.find("file")
        if file is None or self._bindings.values:
            return
        try:
            path = find_beside(file.text(), file, self._path.absolute().parent, self._notes)
        except SceneError as error:
            self._notes.ignore(
                file.file,
                file.line,
                file.key,
                f"{error.message.removeprefix(f'{file.key}: ')}; numbers start from their means",
            )
            return
        best = node is not None and node.truth_of("use_best_as_mean", False)
        values = read_parameters(path)
        self._bindings.values = values if best else {name: one._replace(best=one.mean) for name, one in values.items()}
        self._notes.ignore(
            file.file, file.line, file.key, f"numbers start from {path.name}, a search has its own spread"
        )

    def _model(self, node: Node) -> HyfydyModel:
        file = node.need("model_file")
        path = find_beside(file.text(), file, self._path.absolute().parent, self._notes)
        for key in SETTINGS:
            node.find(key)
        options = _options(node)
        if path.suffix.lower() == ".osim":
            found = _of_opensim(load_model(path, self._notes))
        else:
            found = read_model(parse(path, self._notes), self._notes, options)
        if node.truth_of("use_opensim_activation_dynamics", False) and path.suffix.lower() != ".osim":
            found.scene.muscle_model.activation = "scaled"  # with the same rates, as times
        if (begun := node.find("initial_equilibration_activation")) is not None:
            found.scene.muscle_model.initial_activation = begun.number()
        scaling = node.find("sensor_delay_scaling_factor")
        if scaling is not None and scaling.number() != 1.0:
            scaling.fail("a factor of delays other than 1 is not known here")
        put_modifiers(node, found.scene)
        _put_feet(found.scene, node)
        return found

    def _start(self, node: Node, found: HyfydyModel) -> None:
        start = Start({}, {}, {})
        if (file := node.find("state_init_file")) is not None:
            folder = self._path.absolute().parent
            found_file = find_beside(file.text(), file, folder, self._notes, (".sto", ".zml"))
            start = read_states(found_file, self._notes)
            if found_file.suffix != Path(file.text()).suffix:  # of another file only the pose is meant
                start = start._replace(activations={})
        values, speeds, activations = start
        offset = node.find("initial_state_offset")
        included, excluded = (node.string_of(f"initial_state_offset_{way}", usual) for way, usual in IN_OR_OUT.items())
        symmetric = node.truth_of("initial_state_offset_symmetric", False)
        if (older := node.find("state_init_optimization")) is not None:  # as versions before 2019 have it
            offset, symmetric = older.find("offset"), older.truth_of("symmetric", False)
            included, excluded = (older.string_of(f"{way}_states", usual) for way, usual in IN_OR_OUT.items())
            older.tell_unused()
        if offset is not None:
            usual = read_number(offset, self._bindings.std_factor)
            for name in found.coordinates:
                for table, state in ((values, name), (speeds, f"{name}_u")):
                    if matches(state, included) and not matches(state, excluded):
                        own = state.removesuffix("_l").removesuffix("_r") if symmetric else state
                        table[name] = table.get(name, 0.0) + self._fixed(f"{own}.offset", usual)
            how = "by the .par file" if self._bindings.values else "by their means"
            self._notes.ignore(offset.file, offset.line, "initial_state_offset", OFFSETS.format(fixed=how))
        load = node.find("initial_load")
        usual = 0.2 if load is None else read_number(load, self._bindings.std_factor)
        put_start(found.scene, found.coordinates, values, speeds)
        put_load(found.scene, self._fixed("initial_load", usual))
        found.scene.initial_state.scone_parameters = self._begun
        self._activations(node, found.scene, activations)

    def _activations(self, node: Node, scene: Scene, given: Mapping[str, float]) -> None:
        """Let muscles start as active as the file of the start has them, unless the controller is to say it."""
        ignored = node.truth_of("state_init_file_ignore_activations", False)
        if node.truth_of("initialize_activations_from_controller", ignored or not given):
            return
        least = plain_number(scene.gait_states.least) if scene.gait_states is not None else 0.0
        known = {name: value for name, value in given.items() if name in scene.character.muscles}
        common = plain_number(scene.muscle_model.initial_activation)
        scene.initial_state.activations = {
            name: min(max(known.get(name, common), least), 1.0) for name in scene.character.muscles
        }

    def _fixed(self, name: str, usual: float | FreeNumber) -> float:
        """A parameter that a scene has no free number for: its best value, or its mean."""
        known = self._bindings.values.get(name)
        self._bindings.places.setdefault(name, "")
        if known is not None:
            self._begun[name] = known.best
            return known.best
        if not isinstance(usual, FreeNumber):
            return usual
        self._begun[name] = usual.mean
        return usual.mean


def _tell_unknown_parts(node: Node) -> None:
    """SceneError at a controller, a measure or a setting that nobody has asked for, with those that there are."""
    for child in node.children:
        if child.used:
            continue
        for what, known in (("Controller", CONTROLLERS), ("Measure", MEASURES)):
            if child.key.endswith(what):
                refuse(child, f"{what.lower()}s", known)
    node.tell_unused()


def _every(groups: list[Node], keys: Iterable[str]) -> list[Node]:
    """The children of some nodes that have one of some keys."""
    keys = tuple(keys)
    return [child for group in groups for child in group.every(*keys)]


def _version(node: Node) -> tuple[int, ...]:
    """The version of SCONE that a model names, such as 2.1.1.2637; nothing if it names none."""
    words = node.string_of("scone_version").split(".")
    return tuple(int(word) for word in words) if all(word.isdecimal() and len(word) < 10 for word in words) else ()


def _options(node: Node) -> Options:
    """How Hyfydy would compute."""
    options = Options()
    forces = node.find("composite_force")
    if forces is not None:
        for key in FORCES:
            forces.find(key)
        if (contact := forces.find("contact_force_hunt_crossley_sb")) is not None:
            options.transition_velocity = contact.number_of("transition_velocity", 0.1)
            contact.tell_unused()
        if (muscle := forces.find("muscle_force_m2012fast")) is not None:
            options.damping = muscle.number_of("xi", options.damping)
            options.v_max = muscle.number_of("v_max", options.v_max)
            muscle.find("use_pennation_during_equilibration")
            muscle.tell_unused()
        forces.tell_unused("forces are contact_force_hunt_crossley_sb and muscle_force_m2012fast")
    for child in node.children:
        if child.key.endswith(("_integrator", "_integrator_psem")) or "_integrator_" in child.key:
            child.used = True
            options.activation_rate = child.number_of("activation_rate", options.activation_rate)
            options.deactivation_rate = child.number_of("deactivation_rate", options.deactivation_rate)
    return options


def _of_opensim(scene: Scene) -> HyfydyModel:
    """What a scene of an OpenSim model says of its coordinates."""
    model = scene.opensim
    found = HyfydyModel(scene, {}, list(model.root_coordinates) if model is not None else [])
    root = scene.character.root
    turns = len(model.root.rotations) if model is not None and model.root is not None else 0
    axes = ("z", "x", "y") if scene.character.root_joint == "planar" else ("z", "x", "y", "x", "y", "z")
    for index, (name, axis) in enumerate(zip(found.root, axes, strict=False)):
        found.coordinates[name] = Coordinate(name, 0, root, "r" if index < turns else "t", axis, 1.0)
    for name in scene.character.joints:
        found.coordinates[name] = Coordinate(name, 0, name, "r", "z", 1.0)
    return found


def _put_feet(scene: Scene, node: Node) -> None:
    """The feet are the bodies of either side that touch the ground, the first of each leg."""
    bodies = scene.character.bodies
    touching = [name for name, body in bodies.items() if body.shapes]
    unsided = [name[:-2] for name in touching if name.endswith("_l") and f"{name[:-2]}_r" in touching]
    if not unsided:
        node.fail("its model has no feet, bodies with names in _l and _r that touch the ground")
    scene.character.feet = (sided(unsided[0], bodies, "l"), sided(unsided[0], bodies, "r"))


def _tell_unknown(path: Path, parameters: Mapping[str, Parameter], bindings: Bindings, notes: Notes) -> None:
    """Note what of a file of parameters the scenario has no number for; SceneError if that is all of it."""
    if not any(name in bindings.places for name in parameters):
        first, own = shortened(next(iter(parameters))), next(iter(bindings.places), "")
        there = f"its names are such as {own}" if own else "it has none"
        raise SceneError(f"no name in it, such as {first}, is of a free number of the scenario: {there}", file=path)
    for name, one in parameters.items():
        if name not in bindings.places:
            notes.ignore(path, one.line, name, "the scenario has no free number of this name; not used")
