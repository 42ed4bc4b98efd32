"""Parts of a simulation that are the user's own: Warp functions that a scene names, found and checked.

They become part of the fused step, so their code is any that a `@wp.func` may have; see `kernels/term_functions.py`,
`kernels/custom_curves.py` and `kernels/control.py` for examples and for what the arguments are.
"""

from __future__ import annotations

import importlib
import sys
import traceback
import typing
from typing import Any, Literal, NamedTuple

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.custom_curves import OwnCurves
from warpmuscle.kernels.desired_torques import term_of_desired
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.kernels.term_functions import MuscleWork
from warpmuscle.scene import Character, Failure, MuscleModel, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.scene.trusted_code import CURVE_FIELDS, check_trusted, folders
from warpmuscle.scene.validation.checks import known, near

Kind = Literal["muscle", "body", "whole", "desired"]

TERM_ARGUMENTS: dict[Kind, tuple[Any, ...]] = {
    "muscle": (wp.int32, wp.int32, MuscleWork, Model),
    "body": (wp.int32, wp.int32, Model, State, Scratch),
    "whole": (wp.int32, Model, State, Scratch),
}
FLOATS = "wp.array[float]"  # stands for that type, whose instances differ


class Table(NamedTuple):
    """Stands for an array of structures."""

    struct: Any


PLAIN = {int: wp.int32, float: wp.float32, wp.bool: bool}
Reference = type(wp.ref[Model])
Struct = type(Model)


def custom_terms(scene: Scene) -> dict[str, tuple[Kind, Any]]:
    """The terms that an objective names: whether each is one of muscles, of bodies or of the whole, and its function.

    One that sees desired torques, a structure of them after what a term of the whole takes, is of the kind `desired`,
    and comes as a function that takes what a term of the whole does.

    Raises:
        SceneError: no such module, function or joint, or not of a term's signature.
    """
    found: dict[str, tuple[Kind, Any]] = {}
    for entry in scene.objective.custom:
        key = f"objective.custom.{entry}"
        function = function_named(entry, key)
        arguments = _arguments(function)
        kinds = [kind for kind, given in TERM_ARGUMENTS.items() if given == arguments]
        if arguments[:-1] == TERM_ARGUMENTS["whole"] and isinstance(arguments[-1], Struct):
            kinds = ["desired"]
        if not kinds:
            wanted = " or ".join(map(_signature, TERM_ARGUMENTS.values()))
            found_one = f"{_placed(function, entry)} takes {_signature(arguments)}"
            raise SceneError(f"a term takes {wanted}, but {found_one}", key=key)
        check_result(function, (wp.float32,), key, entry)
        if kinds == ["desired"]:
            function = _seeing_torques(function, scene.character, key)
        found[entry] = kinds[0], function
    return found


def _seeing_torques(function: Any, character: Character, key: str) -> Any:
    """A term that sees the desired torques of the joints that its structure names; raises SceneError for others."""
    struct = _arguments(function)[-1]
    for name, field in struct.vars.items():
        if field.type != wp.vec3:
            raise SceneError(f"{struct.key}.{name} must be wp.vec3, a torque; it is {_name(field.type)}", key=key)
        known(name, character.joints, "joint", key, f"for {struct.key}")
    names = topology(character)
    return term_of_desired(function, struct, tuple(names.body_of_joint(name) for name in struct.vars))


def custom_conditions(failure: Failure) -> dict[str, Any]:
    """The failing conditions that a scene names, by name; raises SceneError as `custom_terms`."""
    found = {}
    for entry in failure.custom:
        key = f"failure.custom.{entry}"
        found[entry] = function_named(entry, key)
        check_arguments(found[entry], TERM_ARGUMENTS["whole"], key, entry)
        check_result(found[entry], (bool,), key, entry)
    return found


def custom_curves(model: MuscleModel) -> OwnCurves | None:
    """The curves that a muscle model names; None if it names none. Raises SceneError as `custom_terms`."""
    functions = []
    for field in CURVE_FIELDS:
        entry, key = getattr(model, field), f"muscle_model.{field}"
        functions.append(function_named(entry, key) if entry else None)
        if entry:
            check_arguments(functions[-1], (wp.float32,), key, entry)
            results = (wp.float32, wp.vec2) if field == "force_velocity" else (wp.float32,)
            check_result(functions[-1], results, key, entry)
    if not any(functions):
        return None
    return OwnCurves(*functions, sloped=functions[2] is not None and _result(functions[2]) == wp.vec2)


def check_custom(scene: Scene) -> None:
    """SceneError if a scene names code that is not trusted, or terms or curves that cannot be used."""
    check_trusted(scene)
    custom_terms(scene)
    custom_conditions(scene.failure)
    custom_curves(scene.muscle_model)


def function_named(entry: str, key: str) -> Any:
    """The Warp function of a name such as `module:function`, whose module is imported.

    Raises:
        SceneError: no such module or function, it is no Warp function, or its module fails.
    """
    return declared(entry, key)


def declared(entry: str, key: str, *kinds: type) -> Any:
    """The same, or what is of one of these classes."""
    module_name, _, name = entry.partition(":")
    module = _module(module_name, key)
    if not hasattr(module, name):
        hint = near(name, [known for known in vars(module) if not known.startswith("_")])
        raise SceneError(f"module {module_name!r} has no function {name!r}{hint}", key=key)
    function = getattr(module, name)
    if isinstance(function, kinds):
        return function
    return checked_function(function, entry, key)


def named_object(entry: str) -> Any:
    """What a name such as `module:function` stands for, whose module has been imported."""
    module, _, name = entry.partition(":")
    return getattr(sys.modules.get(module), name, None)


def checked_function(function: Any, entry: str, key: str) -> Any:
    """What is to be a Warp function; raises SceneError if it is none."""
    if not isinstance(function, wp.Function) or function.func is None:
        name = entry if not callable(function) or function.__name__ in entry else f"{entry}: {function.__name__}"
        raise SceneError(f"{name!r} is not a Warp function: put @wp.func before it", key=key)
    return function


def _module(name: str, key: str) -> Any:
    if name in sys.modules:
        return sys.modules[name]
    before = list(sys.path)
    sys.path += [str(folder) for folder in folders()]
    try:
        return importlib.import_module(name)
    except SyntaxError as error:
        raise SceneError(f"module {name!r} fails: {error.filename}:{error.lineno}: {error.msg}", key=key) from error
    except ModuleNotFoundError as error:
        missing = error.name or name
        of = "" if missing == name else f", which {name!r} imports"
        raise SceneError(f"there is no module {missing!r}{of} here", key=key) from error
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{last.filename}:{last.lineno}"
        raise SceneError(f"module {name!r} fails: {where}: {type(error).__name__}: {error}", key=key) from error
    finally:
        sys.path[:] = before


def _arguments(function: Any) -> tuple[Any, ...]:
    """Types of a function's arguments, be they values or references."""
    values = [kind.value_type if isinstance(kind, Reference) else kind for kind in function.input_types.values()]
    return tuple(map(_plain_type, values))


def _plain_type(kind: Any) -> Any:
    """A type of an argument, so that equal ones are equal."""
    if _is_floats(kind):
        return FLOATS
    if getattr(kind, "ndim", 0) == 1 and isinstance(kind.dtype, Struct):
        return Table(kind.dtype)
    return PLAIN.get(kind, kind)


def _is_floats(kind: Any) -> bool:
    """Whether a type is that of an array of numbers."""
    return getattr(kind, "ndim", 0) == 1 and getattr(kind, "dtype", None) in (float, wp.float32)


def _result(function: Any) -> Any:
    """The type that a function says it returns; None if it does not say."""
    try:
        said = typing.get_type_hints(function.func).get("return")
    except (NameError, TypeError):
        said = None
    return PLAIN.get(said, said) if isinstance(said, type) else said


def check_arguments(
    function: Any, wanted: tuple[Any, ...], key: str, entry: str, optional: tuple[Any, ...] = ()
) -> None:
    """SceneError unless a Warp function takes these arguments, and of the optional ones any, in their order."""
    taken = _arguments(function)
    rest = [kind for kind in optional if kind in taken[len(wanted) :]]
    if taken != (*wanted, *rest):
        more = "".join(f" [, {_name(kind)}]" for kind in optional)
        found = f"{_placed(function, entry)} takes {_signature(taken)}"
        raise SceneError(f"it takes {_signature(wanted)[:-1]}{more}), but {found}", key=key)


def check_result(function: Any, wanted: tuple[Any, ...], key: str, entry: str) -> None:
    """SceneError unless a Warp function says that it returns one of these types."""
    said = _result(function)
    if said not in wanted:
        names = " or ".join(_name(kind) for kind in wanted)
        says = "nothing" if said is None else _name(said)
        raise SceneError(f"{_placed(function, entry)} must say that it returns {names}, and says {says}", key=key)


def _placed(function: Any, entry: str) -> str:
    """A function's name with its file and line."""
    code = function.func.__code__
    return f"{entry!r} ({code.co_filename}:{code.co_firstlineno})"


def _signature(arguments: tuple[Any, ...]) -> str:
    return f"({', '.join(map(_name, arguments))})"


def _name(kind: Any) -> str:
    plain = {wp.int32: "int", wp.float32: "float", wp.vec2: "wp.vec2", wp.vec3: "wp.vec3", FLOATS: FLOATS}
    if isinstance(kind, Table):
        return f"wp.array[{_name(kind.struct)}]"
    if kind in plain:
        return plain[kind]
    return str(getattr(kind, "key", None) or getattr(kind, "__name__", kind)).rpartition(".")[2]
