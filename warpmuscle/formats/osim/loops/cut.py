"""Loops that joints close, cut open as OpenSim does: half of a body hangs on the joint, welded to the other half."""

from __future__ import annotations

from dataclasses import replace

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.chain import name_beside
from warpmuscle.formats.osim.frames import GROUND, on_body, refused
from warpmuscle.formats.osim.records import Frame, Joint, Loop, Model


def cut_loops(model: Model, notes: Notes) -> None:
    """Let the joints of a model make a tree, with constraints in the place of what closed loops.

    Joints are gone through as `tree.branches` does; each that joins bodies which others have reached closes a loop.

    Raises:
        SceneError: a joint is from a body to itself.
    """
    reached, left = {GROUND}, list(model.joints)
    while left:
        ends = [{on_body(model, frame)[0] for frame in (joint.parent, joint.child)} for joint in left]
        joint, both = next((joint, both) for joint, both in zip(left, ends, strict=True) if both & reached)
        if len(both) < 2:
            raise refused(model, joint.line, f"joint {joint.name!r} is from a body to itself; leave it out")
        if both <= reached:
            _cut(model, joint, notes)
        reached |= both
        left.remove(joint)


def _cut(model: Model, joint: Joint, notes: Notes) -> None:
    """Give a joint half of the body that it carries."""
    end = "child" if on_body(model, joint.child)[0] != GROUND else "parent"
    path, rotation, translation = on_body(model, getattr(joint, end))
    number = next(k for k, body in enumerate(model.bodies) if body.path == path)
    body = model.bodies[number]
    name = name_beside(f"{body.name}_half", [one.name for one in model.bodies])
    other = replace(
        body, path=f"/bodyset/{name}", name=name, mass=0.5 * body.mass, inertia=0.5 * body.inertia, line=joint.line
    )
    model.bodies[number] = replace(body, mass=0.5 * body.mass, inertia=0.5 * body.inertia)
    model.bodies.append(other)
    own = replace(model.frames[path], path=other.path)
    held = Frame(f"{joint.path}/{name}_offset", joint.line, other.path, rotation, translation)
    model.frames.update({own.path: own, held.path: held})
    model.joints[model.joints.index(joint)] = (
        replace(joint, child=held.path) if end == "child" else replace(joint, parent=held.path)
    )
    still, along = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    model.loops.append(
        Loop("WeldConstraint", f"{joint.name}_loop", joint.line, own.path, still, path, still, along, 0.0)
    )
    reason = f"closes a loop of bodies: half of {body.name!r} hangs on it, welded to its other half, as in OpenSim"
    notes.ignore(model.file, joint.line, f"{joint.kind} {joint.name}", reason)
