"""What of a scene is the same whatever its numbers are: what there is, and how it hangs together."""

from __future__ import annotations

from dataclasses import dataclass

from warpmuscle.kernels.body.joint_stages import SkeletonKind
from warpmuscle.kernels.control.control import ControllerKind
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.objective.term_sums import ObjectiveKind
from warpmuscle.model.collisions import Pair, collision_pairs
from warpmuscle.model.controllers.reads import check_reads
from warpmuscle.model.controllers.table import compiled_controller
from warpmuscle.model.forces import ForceEntries, force_kinds
from warpmuscle.model.joints import compiled_skeleton
from warpmuscle.model.muscles import ActuationMap, driven
from warpmuscle.model.objective import counted_terms, objective_kind
from warpmuscle.model.parts import CustomParts, custom_parts
from warpmuscle.model.prescribed_motion import Kinematic, kinematic
from warpmuscle.scene import Scene
from warpmuscle.scene.force import power_name
from warpmuscle.scene.objects.motion import QUANTITIES, object_quantities
from warpmuscle.scene.topology import Topology, coordinate_names, topology
from warpmuscle.scene.treadmill.belt_motion import BELTS


@dataclass(frozen=True)
class Structure:
    """What all instances of a scene have in common, whatever their free parameters are."""

    names: Topology
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    actuation: ActuationMap  # what drives the joints, and the muscles that are simulated
    kinematic: Kinematic  # coordinates that move as prescribed
    collision_pairs: list[Pair]  # of bodies that must not run into each other
    skeleton: SkeletonKind  # what a step has compiled in for bodies and joints
    objective: ObjectiveKind  # the sums that a step makes
    controller: ControllerKind  # what a step has compiled in of it
    forces: tuple[ForceEntries, ...]  # besides those of muscles and controller, by kind
    parts: CustomParts  # of the scene's own

    @property
    def force_kinds(self) -> tuple[ForceKind, ...]:
        """Kinds of forces that a step has compiled in."""
        return tuple(entries.kind for entries in self.forces)

    @property
    def devices(self) -> tuple[str, ...]:
        """Forces whose power recordings have, in the order of a step."""
        return tuple(name for entries in self.forces for name in entries.devices)

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects beside the character."""
        return tuple(str(name) for entries in self.forces if entries.kind.objects for name in entries.names)

    @property
    def recorded_names(self) -> tuple[str, ...]:
        """Of the numbers that are recorded of what only some scenes have: their own quantities, objects, devices."""
        objects = (quantity for name in self.objects for quantity in object_quantities(name))
        belts = BELTS if self.skeleton.moves else ()
        return (*self.parts.recorded_names, *objects, *belts, *map(power_name, self.devices))

    @property
    def recorded_units(self) -> tuple[str, ...]:
        """The unit of each."""
        objects = (unit for _ in self.objects for _, unit in QUANTITIES)
        belts = ("m/s",) * len(BELTS) if self.skeleton.moves else ()
        return (*self.parts.recorded_units, *objects, *belts, *("W" for _ in self.devices))


def structure_of(scene: Scene) -> Structure:
    """The structure of a checked scene, whose numbers may be free.

    Raises:
        SceneError: no muscle can run so, no two bodies could collide, or a user's function cannot be used.
    """
    names = topology(scene.character)
    coordinates, speeds = coordinate_names(names, scene.character)
    actuation = driven(scene, names)
    parts = custom_parts(scene, actuation.muscles, counted_terms(scene.objective))
    forces = force_kinds(scene, names)
    objective = objective_kind(scene, not actuation.by_torque_alone, parts)
    cycles = objective.cycles or any(entries.kind.of_leg for entries in forces)
    found = Structure(
        names=names,
        coordinate_names=coordinates,
        speed_names=speeds,
        actuation=actuation,
        kinematic=kinematic(scene, names, actuation.drives),
        collision_pairs=collision_pairs(scene, names),
        skeleton=compiled_skeleton(scene.character, scene.ground),
        objective=objective._replace(cycles=cycles),
        controller=compiled_controller(scene, actuation.muscles),
        forces=forces,
        parts=parts,
    )
    check_reads(scene)
    return found
