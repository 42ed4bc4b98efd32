"""A scene, a motion and a result whose names are made to run code in a page, or to break it."""

from __future__ import annotations

import dataclasses
from typing import Any

from biped import random_recording
from muscle_arm import muscle
from warpmuscle.formats import toml
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.scene import Body, Character, Failure, InitialState, Joint, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters

NAMES = (
    "<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "l<svg/onload=alert(1)>",
    "r<svg/onload=alert(1)>", "__proto__", "constructor", "\"' onmouseover='alert(1)' \\", "one\ntwo\r\n\u2028\u2029",
    "\u202egnp.exe", "x" * 10_000, "<!--<script>${alert(1)}{{7*7}}$x$", "[a](javascript:alert(1)) <b>b</b>",
    "\x1b[2J\x07\x01", "a.0.b\u2029",
)  # fmt: skip


def scene(muscles: bool = True) -> Scene:
    """A chain of bodies; each name is a body, a joint, and a muscle over it."""
    hinge = [(1.0, 0.0, 0.0)]
    bodies = {name: Body(Free(1.0, 0.5, 2.0), (0.01, 0.01, 0.01)) for name in ("base", *NAMES)}
    joints = {
        name: Joint("hinge", parent, name, (0.0, -0.1, 0.0), (0.0, 0.1, 0.0), hinge)
        for parent, name in zip(("base", *NAMES), NAMES, strict=False)
    }
    over = {name: muscle((joint.parent, (0.0, 0.0, 0.03)), (name, (0.0, 0.0, 0.03))) for name, joint in joints.items()}
    character = Character("base", bodies, joints, "fixed", over if muscles else {})
    return Scene(NAMES[0], character, initial_state=InitialState((0.0, 3.0, 0.0)), failure=Failure(0.0, 0.0))


def motion() -> Recording:
    """A motion of the scene, of no meaning."""
    rows = random_recording(20, len(NAMES), muscles=len(NAMES))
    return dataclasses.replace(rows, joint_names=NAMES, body_names=("base", *NAMES), muscle_names=NAMES)


def result() -> Result:
    """What is written of it."""
    made = scene()
    return Result(
        toml.dumps(made), NAMES[0], NAMES[1], 0, parameter_table(free_parameters(made)), replays=(motion(),) * 2,
        replay_names=NAMES[:2], versions=dict.fromkeys(NAMES, NAMES[2]),
    )  # fmt: skip


def watched(page: Any) -> list[str]:
    """A list to which is added what goes wrong in a page, or runs that should not."""
    found: list[str] = []
    page.on("pageerror", lambda error: found.append(str(error)))
    page.on("dialog", lambda dialog: (found.append(dialog.message), dialog.dismiss()))
    page.on("console", lambda said: found.append(said.text) if said.type == "error" else None)
    page.on("request", lambda asked: found.append(asked.url[:300]) if asked.url.rstrip("/").endswith("/x") else None)
    return found
