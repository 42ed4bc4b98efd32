"""What all parts of a scene are made of."""

from __future__ import annotations

import difflib
from enum import Enum
from typing import TYPE_CHECKING, Any, Literal, NoReturn, TypeVar

import msgspec

from warpmuscle.core.errors import lacking

Side = Literal["left", "right"]
Kind = TypeVar("Kind")
FEW = 4  # names that a message lists
SHORT = 3  # letters that abbreviations of muscles have
INSTEAD = {  # by kinds of parts: what to type in place of what is often tried
    "Muscle": {
        **dict.fromkeys(
            ("max_isometric_force", "F_max", "Fmax", "strength", "force"), "f_max is the greatest force, N"
        ),
        **dict.fromkeys(("optimal_fiber_length", "optimal_fibre_length", "lopt", "lm_opt"), "l_opt is it, m"),
        **dict.fromkeys(("tendon_slack_length", "slack_length", "lts", "ltendon"), "l_slack is it, m"),
        **dict.fromkeys(("pennation_angle", "pennation_angle_at_optimal"), "pennation is the angle, rad"),
        **dict.fromkeys(("max_contraction_velocity", "vmax"), "v_max is it, optimal fibre lengths a second"),
        **dict.fromkeys(("points", "path_points", "geometry_path"), "path has its points"),
        "activation": "run['rSOL'] is a muscle's activation over time",
        "length": "run.recording.muscle_path_length has lengths over time",
    },
    "Scene": {
        "simulate": "wm.simulate(scene) runs it",
        "run": "wm.simulate(scene) runs it",
        "show": "wm.show(scene) shows it",
        "view": "wm.show(scene) shows it",
        "plot": "wm.simulate(scene).plot(...) draws its motion",
        "save": "wm.save(scene, 'scene.toml') writes it",
        "write": "wm.save(scene, 'scene.toml') writes it",
        "to_toml": "wm.save(scene, 'scene.toml') writes it",
        "to_dict": "wm.save(scene, 'scene.toml') writes it as a file of tables",
        "optimize": "wm.optimize(scene) searches",
        "parameters": "wm.Rollout(scene).parameters are its free ones",
        "set": "wm.load(scene, set={...}) changes numbers",
        "with_parameters": "wm.load(scene, set={...}) changes numbers",
        "set_parameters": "wm.load(scene, set={...}) changes numbers, wm.Rollout(scene).set_parameters free ones",
        "muscle_names": "list(scene.character.muscles) has them",
        "body_names": "list(scene.character.bodies) has them",
        "joint_names": "list(scene.character.joints) has them",
        **dict.fromkeys(("free_parameters", "free"), "wm.Rollout(scene).parameters are its free ones"),
        **dict.fromkeys(("n_muscles", "nu", "num_muscles"), "len(scene.character.muscles) are as many"),
        **dict.fromkeys(("replace", "update", "modify"), "wm.load(scene, set={'duration': 3}) is another one"),
        "dt": "scene.time_step is the time step, s",
        "copy": "copy.deepcopy(scene) is one, wm.load(scene, set={...}) another one with other numbers",
        "units": "`warpmuscle info SCENE` and the reference of scenes say them; they are SI and radians",
        "mass": "`warpmuscle info SCENE` says it",
        **dict.fromkeys(
            ("to_xml", "to_mjcf", "to_osim", "export"), "wm.convert(scene, 'scene.xml') writes it for MuJoCo"
        ),
        **dict.fromkeys(("nq", "nv", "njnt"), "len(wm.Rollout(scene).coordinate_names) are as many"),
        **dict.fromkeys(("nbody", "n_bodies", "num_bodies"), "len(scene.character.bodies) are as many"),
        "info": "`warpmuscle info SCENE` says what it contains",
        "summary": "print(scene) and `warpmuscle info SCENE` say what it contains",
        "learn": "wm.learn(scene) trains a policy",
        "sweep": "wm.sweep(scene, grid={...}) runs a search for each combination of numbers",
    },
    "Character": {
        **dict.fromkeys(("mass", "total_mass"), "sum(body.mass for body in character.bodies.values()) is its mass"),
        **dict.fromkeys(("muscle_names", "nu"), "list(character.muscles) has the names"),
        "body_names": "list(character.bodies) has the names",
        "joint_names": "list(character.joints) has the names",
    },
    "Body": dict.fromkeys(("position", "pos", "com"), "run.recording.body_position has it over time"),
    "Joint": dict.fromkeys(("angle", "q", "position"), "run['rKnee'] is an angle over time, by the joint's name"),
}
NAMED = "parts have no names of their own: they are the keys of character.muscles, bodies and joints"


class Range(Enum):
    """Where every number of a field lies, as its annotation declares: `mass: Annotated[Number, "kg", ABOVE_0]`."""

    ABOVE_0 = "greater than 0"
    FROM_0 = "not negative"
    FRACTION = "from 0 to 1"


ABOVE_0, FROM_0, FRACTION = Range.ABOVE_0, Range.FROM_0, Range.FRACTION


class Part(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Base of everything in a scene: unknown keys are errors, defaults are not written."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            kind = type(self).__name__
            article = "an" if kind[0] in "AEIOU" else "a"
            raise lacking(f"{article} {kind}", name, dir(type(self)), {"name": NAMED} | INSTEAD.get(kind, {}))


class NoSuchPart(KeyError):
    """A character has no part of this name; the text says which there are."""

    def __str__(self) -> str:
        return str(self.args[0])


class Named(dict[str, Kind]):
    """Parts of a character by their names, which says what there is where a name is none of them."""

    what = "part"

    def __missing__(self, name: object) -> NoReturn:
        known = list(self)
        if isinstance(name, int | slice):
            raise NoSuchPart(f"a {self.what} is asked for by its name, such as {known[:1]}; list(...)[0] is the first")
        asked = str(name).lower().replace(" ", "_")
        found = [one for one in known if one.lower() == asked]
        for part in (asked, asked[:SHORT]) if len(asked) >= SHORT else ():  # SOL of both sides, soleus as sol
            found = found or [one for one in known if part in one.lower()]
        found = found or difflib.get_close_matches(str(name), known, n=2)
        listed = " or ".join(map(repr, found[:FEW]))
        some = ", ".join(known[:FEW]) + (", ..." if len(known) > FEW else "")
        hint = f"did you mean {listed}?" if found else f"there are {some}" if known else "there is none at all"
        raise NoSuchPart(f"no {self.what} is called {name!r}; {hint}")


class Muscles(Named[Kind]):
    """Muscles of a character."""

    what = "muscle"


class Bodies(Named[Kind]):
    """Bodies of a character."""

    what = "body"


class Joints(Named[Kind]):
    """Joints of a character."""

    what = "joint"
