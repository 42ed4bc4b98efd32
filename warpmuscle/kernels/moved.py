"""Modules and names that are called otherwise since 0.3.0: old ones still work, with a warning.

Most are modules of `warpmuscle.kernels` before they lay in rooms.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

PACKAGE = "warpmuscle.kernels"
ROOMS = {  # names of modules that lay in the package itself until 0.3.0, by room
    "algebra": "angles random_numbers spatial spline",
    "memory": "compiler_hints register_rows restart scratch turns",
    "body": (
        "coordinate_joint dynamics followed follower hybrid inertia integration joint joint_motion "
        "joint_stages kinematics limits motion"
    ),
    "contact": "body_contact collision contact contact_laws gait_cycle hunt_crossley soft_constraint touching",
    "force": "actuation bushing devices extensions forces springs",
    "curve": "curve_sets curves custom_curves millard millard_tables shaped_curves",
    "muscle": "activation cables contraction effort metabolics muscle muscle_control muscle_stage muscles sharing",
    "path": (
        "path polynomial_path route route_bends route_points route_walk stretch wrap_cylinder wrap_ellipsoid "
        "wrap_sphere wrap_torus wrap_touch"
    ),
    "control": "control coordinate_control joint_values reflex simbicon",
    "objective": "accelerations causes conditions declaration desired_torques failure objective_terms term_functions",
    "learning": "decision episodes policy policy_actions rewards senses",
    "recording": "record recorded",
    "inverse": "inverse_dynamics marker_fit muscle_moments muscle_wrenches static_optimization",
}  # fmt: skip
RENAMED = {"warpmuscle.scene.sizes.together": "warpmuscle.scene.sizes.batch_scene"}
ROOM_OF = {name: room for room, names in ROOMS.items() for name in names.split()}


def _name_now(name: str) -> str:
    """What a module is called whose name this was; empty for all others."""
    package, _, last = name.rpartition(".")
    if package == PACKAGE and last in ROOM_OF:
        return f"{PACKAGE}.{ROOM_OF[last]}.{last}"
    return RENAMED.get(name, "")


class Former(MetaPathFinder, Loader):
    """Finds a module by the name that it had."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """The module that has another name now, if it is one."""
        return ModuleSpec(name, self) if _name_now(name) else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The module itself."""
        now = _name_now(spec.name)
        warnings.warn(f"{spec.name} is {now} now", DeprecationWarning, stacklevel=2)
        module = import_module(now)
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """It has run; it keeps what it knows of itself."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def of_former_module(room: str, name: str) -> Callable[[str], Any]:
    """What `kernels.muscle` answers for what `muscle` was, and so on: attributes of a module, by its room."""

    def found(attribute: str) -> Any:
        if attribute.startswith("__") or find_spec(f"{room}.{attribute}") is not None:
            raise AttributeError(f"module {room!r} has no attribute {attribute!r}")
        return getattr(import_module(f"{room}.{name}"), attribute)

    return found


def modules_that_have(name: str) -> list[str]:
    """Modules of the kernels that define a name, for whoever looks for it where it was."""
    folder = Path(__file__).parent
    defined = re.compile(rf"^(def|class) {re.escape(name)}\b|^{re.escape(name)}\b[^\n(]*=", re.MULTILINE)
    files = [file for file in sorted(folder.rglob("*.py")) if defined.search(file.read_text(encoding="utf-8"))]
    return [".".join((PACKAGE, *file.relative_to(folder).with_suffix("").parts)) for file in files]


def of_former_names(module: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """What a module answers for names that it had before, by those that they have now; with a warning."""

    def found(attribute: str) -> Any:
        if attribute not in names:
            raise AttributeError(f"module {module!r} has no attribute {attribute!r}")
        warnings.warn(f"{module}.{attribute} is called {names[attribute]} now", DeprecationWarning, stacklevel=2)
        return getattr(sys.modules[module], names[attribute])

    return found


sys.meta_path.append(Former())
