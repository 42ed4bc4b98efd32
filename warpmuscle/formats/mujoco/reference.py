"""A compiled model in its reference pose, in our axes: all hinges and slides at 0, or where they are held."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.mujoco.compiled import mujoco_package
from warpmuscle.formats.osim.placement import vector

Z_UP = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # rows: our x, y and z in MuJoCo's axes
STILL = 1.0e-9  # of gravity, across its axis
FREE, BALL, SLIDE, HINGE = range(4)  # mjtJoint
WORLD = 0


@dataclass
class Moved:
    """Bodies that are welded to each other, and move as one."""

    name: str
    mass: float  # kg
    center: Floats  # (3,) m, of mass, our world
    inertia: Floats  # (3, 3) kg m^2, about it, our axes
    members: list[int] = field(default_factory=list)


class Reference:
    """The model, its data in the reference pose, names for a scene, and masses that move together."""

    def __init__(self, model: Any, path: Path, notes: Notes, held: dict[int, float]) -> None:
        """Pose the model.

        Args:
            held: values of joints, by number, that an equality holds where they are.

        Raises:
            SceneError: gravity points along none of MuJoCo's axes that are up.
        """
        mujoco = mujoco_package()
        self.model, self.path, self.notes, self.held = model, path, notes, held
        self.axes = _axes_of(model.opt.gravity, path)
        self.gravity = float(np.linalg.norm(model.opt.gravity))
        self.data = mujoco.MjData(model)
        self.data.qpos[:] = 0.0
        for joint in range(model.njnt):
            start = int(model.jnt_qposadr[joint])
            kind = int(model.jnt_type[joint])
            if kind in (FREE, BALL):
                self.data.qpos[start + (3 if kind == FREE else 0)] = 1.0
            self.data.qpos[start] += held.get(joint, 0.0)
        mujoco.mj_kinematics(model, self.data)
        kinds = (("body", model.nbody), ("joint", model.njnt), ("geom", model.ngeom), ("site", model.nsite))
        self._names = {kind: _names(kind, (getattr(model, kind)(k).name for k in range(n))) for kind, n in kinds}
        self.moved = self._groups()

    def name(self, kind: str, number: int) -> str:
        """The name of a body, joint, geom or site in a scene."""
        return self._names[kind][number]

    def lead(self, body: int) -> int:
        """The body that another one is welded to, or itself: 0 of what does not move, as a mocap body here."""
        own = int(self.model.body_weldid[body])
        return WORLD if self.model.body_mocapid[own] >= 0 else own

    def point(self, place: Floats) -> Floats:
        """A place of MuJoCo's world in ours, (3,) m."""
        return np.asarray(self.axes @ place)

    def on(self, body: int, place: Floats) -> tuple[str, tuple[float, float, float]]:
        """The body of the scene that a body belongs to, and a place of MuJoCo's world from its centre of mass, m."""
        moved = self.moved[self.lead(body)]
        return moved.name, vector(self.point(place) - moved.center)

    def lose(self, what: str, reason: str) -> None:
        """Note what is not kept."""
        self.notes.ignore(self.path, 0, what, reason)

    def _groups(self) -> dict[int, Moved]:
        found: dict[int, Moved] = {}
        for body in range(self.model.nbody):
            lead = self.lead(body)
            name = self.name("body", lead) if lead != WORLD else "ground"
            found.setdefault(lead, Moved(name, 0.0, np.zeros(3), np.zeros((3, 3)))).members.append(body)
        for lead, moved in found.items():
            if lead != WORLD:
                self._weigh(moved, lead)
        return found

    def _weigh(self, moved: Moved, lead: int) -> None:
        """Put in mass, centre and inertia of what is welded together."""
        model, data = self.model, self.data
        mass = model.body_mass[moved.members]
        centers = data.xipos[moved.members] @ self.axes.T
        moved.mass = float(mass.sum())
        moved.center = self.point(data.xpos[lead]) if moved.mass == 0.0 else np.asarray(mass @ centers) / moved.mass
        for body, own, center in zip(moved.members, mass, centers, strict=True):
            turn = self.axes @ data.ximat[body].reshape(3, 3)
            r = center - moved.center
            moved.inertia = moved.inertia + turn @ np.diag(model.body_inertia[body]) @ turn.T
            moved.inertia = moved.inertia + own * (r @ r * np.eye(3) - np.outer(r, r))


def _axes_of(gravity: Floats, path: Path) -> Floats:
    """Our axes in MuJoCo's: ours are y up, which MuJoCo's z or y may be."""
    size = float(np.linalg.norm(gravity))
    for axes in (Z_UP, np.eye(3)):
        if size == 0.0 or -float(axes[1] @ gravity) >= size * (1.0 - STILL):
            return axes
    listed = " ".join(f"{g:g}" for g in gravity)
    raise SceneError(f"gravity must point along -z, or along -y, not along {listed}; turn the model", file=path)


def _names(kind: str, given: Iterable[str]) -> list[str]:
    """Names that differ, and that paths in a scene may be made of."""
    found: list[str] = []
    taken = {"ground", "root", ""}
    for number, name in enumerate(given):
        plain = re.sub(r"[^\w\-]+", "_", name) or f"{kind}{number}"
        while plain in taken:
            plain += f"_{kind}" if not plain.endswith(f"_{kind}") else f"_{number}"
        taken.add(plain)
        found.append(plain)
    return found
