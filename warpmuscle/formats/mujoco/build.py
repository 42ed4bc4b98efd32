"""A scene from a file of MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import readable
from warpmuscle.core.pose import rotate
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.mujoco.actuators import driven_joint, put_drives
from warpmuscle.formats.mujoco.compiled import URDF, compiled
from warpmuscle.formats.mujoco.contact import build_contact
from warpmuscle.formats.mujoco.loops import loops_on_world, put_loops
from warpmuscle.formats.mujoco.muscles import build_muscles
from warpmuscle.formats.mujoco.reference import BALL, FREE, HINGE, SLIDE, Reference
from warpmuscle.formats.mujoco.skeleton import Follower, build_character, followers, free_root, held_joints
from warpmuscle.formats.mujoco.tendons import Tendons
from warpmuscle.formats.mujoco.unsupported import tell_lost
from warpmuscle.formats.osim.placement import vector
from warpmuscle.scene import Actuation, Failure, InitialState, JointState, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.validation.paths import usual_drive
from warpmuscle.scene.validation.scene import check_scene


def load_mujoco(path: Path, notes: Notes) -> Scene:
    """A checked scene from a model of MuJoCo, or from a URDF as MuJoCo reads it.

    Args:
        notes: gets what is not kept.

    Raises:
        SceneError: it cannot be read or represented, or the package `mujoco` is not installed.
    """
    try:
        scene = _build(path, notes)
        check_scene(scene)
    except SceneError as error:
        placed = notes.placed(error)
        raise (placed if placed.file is not None else placed.at(path, 0)) from None
    return scene


def _build(path: Path, notes: Notes) -> Scene:
    model = compiled(path)
    reference = Reference(model, path, notes, held_joints(model))
    follows = followers(model, lambda joint: reference.name("joint", joint))
    tendons = Tendons(reference)
    root = free_root(reference, tendons.on_world() or loops_on_world(reference))
    character = build_character(reference, root, follows)
    character.wrapping = "mujoco"
    moving = {name for name, joint in character.joints.items() if joint.type in ("hinge", "slide")}
    drives = {actuator for actuator in range(model.nu) if driven_joint(reference, character, actuator) is not None}
    common, character.muscles = build_muscles(reference, tendons, moving, drives)
    character.surfaces = tendons.surfaces
    scene = Scene(name=readable(path.stem), character=character, muscle_model=common, gravity=reference.gravity)
    scene.description = f"{'URDF' if path.suffix.lower() == URDF else 'MuJoCo model'} {path.name}"
    scene.time_step = float(model.opt.timestep)
    scene.ground = build_contact(reference, character)
    scene.initial_state = _start(reference, root, follows)
    _drives(reference, follows, scene)
    put_drives(reference, scene)
    put_loops(reference, scene)
    if character.root_joint == "fixed":
        scene.failure = Failure(com_height=0.0, heading=0.0)
    tell_lost(reference)
    return scene


def _start(reference: Reference, root: int | None, follows: dict[int, Follower]) -> InitialState:
    """The first keyframe of the model, or its own initial pose."""
    model, axes = reference.model, reference.axes
    q = model.key_qpos[0] if model.nkey else model.qpos0
    v = model.key_qvel[0] if model.nkey else np.zeros(model.nv)
    start = InitialState()
    for joint in range(model.njnt):
        kind, at, dof = int(model.jnt_type[joint]), int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        name = reference.name("joint", joint)
        if kind in (HINGE, SLIDE) and joint not in follows and joint not in reference.held:
            if q[at] != 0.0 or v[dof] != 0.0:
                start.joints[name] = _hinge_or_slide(reference, joint, float(q[at]), float(v[dof]))
        elif kind == FREE and int(model.jnt_bodyid[joint]) == root:
            turn = np.concatenate([axes @ q[at + 4 : at + 7], q[at + 3 : at + 4]])
            lever = rotate(turn, reference.moved[root].center)
            spin = rotate(turn, axes @ v[dof + 3 : dof + 6])
            start.root_position = vector(axes @ q[at : at + 3] + lever)
            x, y, z, w = (float(number) for number in turn)
            start.root_orientation = (x, y, z, w)
            start.root_angular_velocity = vector(spin)
            start.root_velocity = vector(axes @ v[dof : dof + 3] + np.cross(spin, lever))
        elif kind in (FREE, BALL):
            skipped = 3 if kind == FREE else 0
            for k in range(skipped):
                start.joints[f"{name}_{'xyz'[k]}"] = JointState(coordinate=float(q[at + k]), speed=float(v[dof + k]))
            start.joints[name] = _ball(reference, joint, q[at + skipped : at + skipped + 4], v[dof + skipped :][:3])
    return start


def _hinge_or_slide(reference: Reference, joint: int, value: float, speed: float) -> JointState:
    if reference.model.jnt_type[joint] == SLIDE:
        return JointState(coordinate=value, speed=speed)
    axis = reference.axes @ reference.data.xaxis[joint]
    x, y, z = (float(number) for number in axis * np.sin(0.5 * value))
    return JointState((x, y, z, float(np.cos(0.5 * value))), vector(axis * speed))


def _ball(reference: Reference, joint: int, turn: Floats, spin: Floats) -> JointState:
    """A ball's turn (w, x, y, z) and angular velocity in the axes of the body that it carries, as ours."""
    axes = reference.axes @ reference.data.xmat[reference.model.jnt_bodyid[joint]].reshape(3, 3)
    x, y, z, w = (float(number) for number in (*(axes @ turn[1:]), turn[0]))
    return JointState((x, y, z, w), vector(rotate(np.array([x, y, z, w]), axes @ spin)))


def _drives(reference: Reference, follows: dict[int, Follower], scene: Scene) -> None:
    """Joints that no muscle crosses are passive; springs of joints are those of the model."""
    model = reference.model
    for name, joint in scene.character.joints.items():
        if joint_type(joint).moves and usual_drive(name, scene.character) == "torque":
            scene.actuation[name] = Actuation("passive")
    for number in range(model.njnt):
        stiffness, name = float(model.jnt_stiffness[number]), reference.name("joint", number)
        if stiffness == 0.0 or number in reference.held:
            continue
        if model.jnt_type[number] not in (HINGE, SLIDE) or number in follows:
            reference.lose(f"joint {name}", "its spring is left out")
            continue
        rest = float(model.qpos_spring[model.jnt_qposadr[number]])
        axis = np.array(scene.character.joints[name].axes[0], dtype=float)
        drive = scene.actuation.get(name, Actuation("muscle")).drive
        scene.actuation[name] = Actuation(drive, stiffness=stiffness, rest=vector(axis * rest))
