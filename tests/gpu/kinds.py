"""One scene of every kind of kernel, short, with a number that differs between instances."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from model_kinds import MODEL_KINDS

import small_scone
from muscle_arm import REACH, constant, leg
from warpmuscle.formats import load
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.scene import (
    Actuation,
    BallObject,
    Body,
    BodyContact,
    BoxObject,
    CapsuleObject,
    Controller,
    Displacement,
    Force,
    Held,
    Joint,
    Motion,
    Scene,
    Terrain,
    Treadmill,
    ViaPoint,
    Water,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.terrain.tiles import Patch, Profile, Rough, Stairs, Stones

DURATION = 0.06  # s
# s, after which motion on a GPU is compared with that on a CPU, if not after all of it. Rounding turns the toes of this
# body, at 2600 rad/s^2, by 2e-5 rad/s in the first step, 500 times what the tests change of its start, and that grows
# by half in each step of 1 ms, up to 0.3 rad. After this time it is a third of what may be; a per mille more force,
# three times that.
COMPARED_AFTER = {"shared over joints": 0.02}
USER_MODULE = "parts_for_gpu_tests"
USER_CODE = '''"""A term, a curve, a controller and a force of a user's own."""

import warp as wp

from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.structs import Model, State, Scratch
from warpmuscle.kernels.objective.term_functions import MuscleWork


@wp.func
def effort(instance: int, m: int, w: MuscleWork, model: Model) -> float:
    return w.activation * w.activation


@wp.func
def bell(length: float) -> float:
    return wp.exp((length - 1.0) * (length - 1.0) * -2.0)


@wp.struct
class Rhythm:
    frequency: float
    torque: float


@wp.func
def tick(instance: int, model: Model, state: State, work: Scratch, rhythm: Rhythm, memory: wp.array[float]):
    memory[0] = memory[0] + model.time_step * rhythm.frequency
    memory[1] = memory[1] + work.center[1][1]


@wp.func
def swing(
    instance: int, body: int, model: Model, state: State, work: Scratch, rhythm: Rhythm, memory: wp.array[float]
) -> wp.vec3:
    return wp.vec3(rhythm.torque * wp.sin(memory[0]), 0.01 * memory[1], 0.0)


@wp.func
def beat(instance: int, muscle: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    return 0.5 + 0.5 * wp.sin(memory[0] + float(muscle))


rhythmic = CustomController(effort=swing, excitation=beat, update=tick, parameters=Rhythm, state=2)


@wp.func
def creep(instance: int, body: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> wp.vec3:
    memory[0] = memory[0] + 0.1 * work.joint_velocity[body][0]
    return wp.vec3(-memory[0], 0.0, 0.0)


creeping = ForceKind(effort=creep, state=1)
'''


def walk(name: str = "fwalk", **model: Any) -> Scene:
    """A shipped walk with another muscle model."""
    scene = load(name, ignored=[])
    for field, value in model.items():
        setattr(scene.muscle_model, field, value)
    return scene


def colliding() -> Scene:
    """A walk whose bodies are tested for running into each other, of which some do."""
    scene = walk()
    scene.failure.self_collision = 0.005
    return scene


def touching() -> Scene:
    """A walk on muscles with legs so thick that they push each other."""
    scene = walk("walk56")
    scene.body_contact = BodyContact()
    for side in "lr":
        scene.character.bodies[f"{side}Lowerleg"].shapes[0].radius = 0.12
    return scene


def on_bumps() -> Scene:
    """A walk on muscles on bumps of 1 cm, some of which are slippery and soft."""
    scene = walk("walk56")
    patch = Patch((0.0, 0.5), (-0.5, 0.6), friction=0.3, stiffness=0.5)
    scene.ground.terrain = Terrain([Rough(height=0.01, spacing=0.1, patches=[patch])], yaw=0.3, x=0.1)
    return scene


def on_stones() -> Scene:
    """A walk among stones and over a stair, whose walls are beside toes."""
    scene = load("fwalk")
    tiles = [Stones((0.3, 0.2), gap=0.05, height=0.02, depth=0.05), Stairs(rise=0.03, tread=0.2, start=0.3)]
    scene.ground.terrain = Terrain(tiles, yaw=0.3, x=0.1)
    return scene


def objects_on_bumps() -> Scene:
    """A ball and a capsule roll over bumps smaller than they are."""
    scene = walk("fwalk")
    scene.ground.terrain = Terrain([Rough(height=0.01, spacing=0.1)], yaw=0.3, x=0.1)
    scene.objects = {
        "ball": BallObject(radius=0.1, position=(1.0, 0.1, 0.0), velocity=(0.0, 0.0, 2.0)),
        "bar": CapsuleObject(position=(2.0, 0.1, 0.0), velocity=(0.0, -1.0, 1.0), angular_velocity=(3.0, 0.0, 1.0)),
    }
    return scene


def on_edges() -> Scene:
    """A box and a bar lie across a wall, with their corners in the air, and a plank falls across the box."""
    scene = walk("fwalk")
    scene.ground.terrain = Terrain([Stairs(0.3, 0.3, 1, start=1.0, landing=0.3)])
    along_z = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    scene.objects = {
        "box": BoxObject(size=(0.3, 0.1, 1.2), position=(0.0, 0.349, 1.14)),
        "bar": CapsuleObject(radius=0.05, length=0.6, position=(0.5, 0.349, 1.14), orientation=along_z),
        "plank": BoxObject(size=(1.0, 0.04, 0.1), position=(0.0, 0.42, 1.1), velocity=(0.0, -0.5, 0.0)),
    }
    return scene


def boxes_on_crests() -> Scene:
    """A box and a plank on crests that only their edges and faces touch, a log across them, and crossed planks."""
    scene = walk("fwalk")
    crests = Profile([(0.0, 0.0), (0.4, 0.0), (0.5, 0.1), (0.6, 0.0), (1.4, 0.0), (1.42, 0.2), (1.6, 0.2), (1.62, 0.0)])
    scene.ground.terrain = Terrain([crests], yaw=0.3, x=3.0)
    scene.objects = {
        "box": BoxObject(size=(0.4, 0.1, 0.3), position=(3.2, 0.16, 0.45), velocity=(0.0, -1.0, 0.0)),
        "plank": BoxObject(size=(0.2, 0.04, 1.0), position=(3.4, 0.22, 1.45), velocity=(0.0, -0.5, 0.1)),
        "across": BoxObject(size=(1.0, 0.04, 0.1), position=(3.4, 0.27, 1.4), touches=["plank"]),
        "log": CapsuleObject(length=0.8, position=(2.6, 0.16, 0.6), orientation=(0.7071068, 0.0, 0.0, 0.7071068)),
    }
    return scene


def among_objects() -> Scene:
    """A walk with a ball in the hand that is let go, and a box that the leg that swings meets."""
    scene = walk("fwalk")
    scene.objects = {
        "ball": BallObject(mass=0.5, held=Held("rLowerarm", (-0.3, 0.0, 0.0), until=0.03)),
        "box": BoxObject(size=(0.6, 0.5, 0.4), position=(0.0, 0.25, 0.5), velocity=(0.0, 0.0, -2.0)),
    }
    return scene


def on_belts() -> Scene:
    """A walk on muscles on two belts, whose speeds grow."""
    scene = walk("walk56")
    scene.ground.treadmill = Treadmill(speed=0.5, left=0.3, sideways=0.1, profile=[(0.0, 0.0), (0.05, 1.0)])
    return scene


def under_water() -> Scene:
    """A walk on muscles in water to the hips."""
    scene = walk("walk56")
    scene.water = Water(level=0.9, current=0.2)
    return scene


def judged() -> Scene:
    """A walk on muscles whose objective has all terms but those that track a gait."""
    scene = walk("walk56")
    for name in set(TERMS) - {"tracking"}:
        setattr(scene.objective, name, 1.0)
    return scene


def prescribed() -> Scene:
    """A leg whose hip is moved while muscles drive its knee."""
    scene = leg()
    scene.actuation = {"hip": Actuation("kinematic")}
    scene.motion = {"hip": Motion([0.0, 0.2], rotation=[(0.0, 0.0, 0.0), (0.3, 0.1, 0.0)])}
    return scene


def of_users(folder: Path) -> Scene:
    """A leg with code of others in its term, curve and controller."""
    (folder / f"{USER_MODULE}.py").write_text(USER_CODE)
    scene = leg()
    for index, muscle in enumerate(scene.character.muscles.values()):
        muscle.excitation = constant(0.2 + 0.3 * index)
    scene.objective.custom = {f"{USER_MODULE}:effort": 2.0}
    scene.muscle_model.active_force_length = f"{USER_MODULE}:bell"
    return scene


def user_controlled(folder: Path) -> Scene:
    """A leg with a user's controller, which has a state: torques at the hip, excitations of muscles at the knee."""
    (folder / f"{USER_MODULE}.py").write_text(USER_CODE)
    scene = leg()
    scene.actuation = {"hip": Actuation("torque")}
    scene.custom_controller = f"{USER_MODULE}:rhythmic"
    scene.custom_controller_parameters = {"frequency": 20.0, "torque": 5.0}
    return scene


def by_states(folder: Path) -> Scene:
    """Two legs on reflexes of points, turns and the centre of mass, patterns and noise, by their states of gait."""
    return load(small_scone.write(folder, controller=small_scone.with_noise()), ignored=[])


def by_spindles(folder: Path) -> Scene:
    """Two legs on reflexes of spindles and of activations."""
    return load(small_scone.write(folder, controller=small_scone.SPINDLES), ignored=[])


def by_joint() -> Scene:
    """A leg whose joints are held by gains of their own."""
    scene = leg()
    scene.actuation = {"hip": Actuation("torque"), "knee": Actuation("torque")}
    gains = {"others": {"kp": 40.0, "kd": 4.0, "angle": 0.2}, "knee": {"angle": 0.5}}
    scene.controller = Controller(type="joint_pd", by_joint=gains)
    return scene


def worn(folder: Path) -> Scene:
    """A walk on muscles in air, with devices at its ankles and a user's at its elbows, which has a state."""
    (folder / f"{USER_MODULE}.py").write_text(USER_CODE)
    scene = walk("walk56")
    spring = {"rest_angle": 0.1, "stiffness_above": 100.0, "stiffness_below": 20.0, "damping": 1.0}
    for side in "lr":
        scene.forces[f"{side} exo"] = Force("bilinear_spring", joint=f"{side}Ankle", parameters=spring)
        scene.forces[f"{side} creep"] = Force(f"{USER_MODULE}:creeping", joint=f"{side}Elbow")
    scene.forces["air"] = Force("air_drag", body="torso", parameters={"drag_area": 0.5, "density": 1.2})
    return scene


def held() -> Scene:
    """A walk whose controller renews its targets at times."""
    scene = walk()
    scene.control_rate = 100.0
    return scene


def implicit_pd() -> Scene:
    """A walk with an implicit controller."""
    scene = walk()
    scene.implicit_pd = True
    return scene


def forced() -> Scene:
    """A walk with a spring on a knee, in the wind."""
    scene = walk()
    spring = {"rest_angle": 0.1, "stiffness_above": 20.0, "stiffness_below": 0.0, "damping": 0.1}
    scene.forces = {
        "knee": Force("bilinear_spring", joint="lKnee", parameters=spring),
        "air": Force("air_drag", body="torso", parameters={"drag_area": 0.5, "density": 1.2}),
    }
    return scene


def sliding() -> Scene:
    """Two bodies, one of which slides along the other."""
    scene = leg()
    scene.character.muscles = {}
    knee = scene.character.joints["knee"]
    knee.type, knee.axes = "slide", [(0.1, 1.0, 0.2)]
    return scene


def coupled() -> Scene:
    """A leg whose knee rolls and slides as functions of its angle."""
    scene = sliding()
    knee = scene.character.joints["knee"]
    knee.type, knee.axes = "coupled", []
    knee.rotations = [Displacement((1.0, 0.0, 0.0), slope=1.0)]
    knee.translations = [Displacement((0.0, 1.0, 0.0), x=[-2.0, -1.0, 0.0, 1.0], y=[0.02, -0.01, 0.03, 0.0])]
    return scene


def following() -> Scene:
    """A leg with a patella, a hip of three hinges in a row, and turned axes of inertia."""
    scene = coupled()
    character, muscles = scene.character, leg().character.muscles
    turned = Body(0.2, (1.0e-3, 1.5e-3, 2.0e-3), inertia_axes=(0.3, -0.2, 0.5, 0.8))
    nothing = Body(0.0, (0.0, 0.0, 0.0))
    character.bodies |= {"patella": turned, "flexed": nothing, "tilted": nothing}
    hip = character.joints["hip"]
    hip.type, hip.child, hip.axes, hip.position_in_child = "hinge", "flexed", [(1.0, 0.0, 0.0)], (0.0, 0.0, 0.0)
    centre = (0.0, 0.0, 0.0)
    character.joints["tilt"] = Joint("hinge", "flexed", "tilted", centre, centre, [(0.0, 0.0, 1.0)])
    character.joints["turn"] = Joint("hinge", "tilted", "thigh", centre, (0.0, REACH, 0.0), [(0.0, 1.0, 0.0)])
    turns = [Displacement((1.0, 0.0, 0.0), slope=0.6)]
    moves = [Displacement((0.0, 1.0, 0.0), polynomial=[0.0, -0.02, 0.0, 0.01, 0.004])]
    character.joints["patella"] = Joint(
        "coupled", "thigh", "patella", (0.0, -REACH, 0.05), centre, rotations=turns, translations=moves, follows="knee"
    )
    muscles["knee"].path.insert(1, ViaPoint("patella", (0.0, 0.01, 0.01)))
    character.muscles = muscles
    return scene


def followed_from_afar() -> Scene:
    """The same with a lever on the root that follows the knee, so that its coordinate stays open to the root."""
    scene = following()
    character = scene.character
    character.bodies["lever"] = Body(0.3, (1.0e-3, 2.0e-3, 1.5e-3))
    turns = [Displacement((0.0, 1.0, 0.0), polynomial=[0.1, -0.5, 0.2])]
    character.joints["lever"] = Joint(
        "coupled", character.root, "lever", (0.1, 0.0, 0.0), (0.0, 0.05, 0.0), rotations=turns, follows="knee"
    )
    return scene


KINDS: dict[str, Callable[[Path], Scene]] = {
    "torques": lambda _: walk(),
    "rigid": lambda _: walk("walk56"),
    "compliant": lambda _: walk("walk56", tendon="compliant"),
    "switch": lambda _: walk("walk56", tendon="switch"),
    "ideal": lambda _: walk("walk56", ideal=True),
    "legacy": lambda _: walk("walk56_legacy"),
    "neural": lambda _: walk("walk56", activation="neural"),
    "implicit": lambda _: walk("walk56", implicit_damping=True),
    "shared": lambda _: walk("walk56", sharing="least_effort"),
    "shared over joints": lambda _: walk("wang2012", sharing="least_effort"),
    "shared, in the state": lambda _: walk("wang2012", sharing="least_effort", implicit_damping=True),
    "reflex": lambda _: walk("reflex_walk"),
    "planar": lambda _: walk("reflex_planar"),
    "gait states": lambda folder: by_states(folder),
    "spindles": lambda folder: by_spindles(folder),
    "motion": lambda _: prescribed(),
    "pulleys": lambda _: walk("throw_ball"),
    "collisions": lambda _: colliding(),
    "touching": lambda _: touching(),
    "terrain": lambda _: on_bumps(),
    "terrain with walls": lambda _: on_stones(),
    "objects": lambda _: among_objects(),
    "objects on bumps": lambda _: objects_on_bumps(),
    "objects on edges": lambda _: on_edges(),
    "boxes on crests": lambda _: boxes_on_crests(),
    "treadmill": lambda _: on_belts(),
    "water": lambda _: under_water(),
    "objective": lambda _: judged(),
    "forces": lambda _: forced(),
    "slide": lambda _: sliding(),
    "coupled": lambda _: coupled(),
    "following": lambda _: following(),
    "followed from afar": lambda _: followed_from_afar(),
    "held": lambda _: held(),
    "implicit PD": lambda _: implicit_pd(),
    "user functions": of_users,
    "user controller": user_controlled,
    "controller by joint": lambda _: by_joint(),
    "walking as told": lambda _: walk("steer"),
    "user forces": worn,
} | MODEL_KINDS
SMALL = ("torques", "motion", "user functions")  # those that a CPU tries besides


def scene_of(kind: str, folder: Path) -> Scene:
    """The scene of a kind; its gravity is its only free number."""
    scene = KINDS[kind](folder)
    scene = substitute(scene, start_values(scene))
    scene.duration, scene.gravity, scene.stages = DURATION, Free(9.8, 9.0, 10.6), []
    return scene
