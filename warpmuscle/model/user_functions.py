"""Warp functions of users' modules that a scene names: found, and checked for what they take and return.

They become part of the fused step, so their code is any that a `@wp.func` may have. Muscle curves are functions by
themselves; see `parts.py` for parts that declare more.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
import textwrap
import traceback
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.curve.custom_curves import CustomCurves
from warpmuscle.kernels.memory.scratch import APART, LIVES, PHASES
from warpmuscle.kernels.moved import modules_that_have
from warpmuscle.kernels.structs import Model, Scratch
from warpmuscle.scene import MuscleModel
from warpmuscle.scene.trusted_code import CURVE_FIELDS, folders
from warpmuscle.scene.validation.checks import near

FLOATS = "wp.array[float]"  # stands for that type, whose instances differ


class Table(NamedTuple):
    """Stands for an array of structures."""

    struct: Any


PLAIN = {int: wp.int32, float: wp.float32, wp.bool: bool}
Reference = type(wp.ref[Model])
Struct = type(Model)


def custom_curves(model: MuscleModel) -> CustomCurves | None:
    """The curves that a muscle model names; None if it names none. Raises SceneError as `declared`."""
    functions = []
    for field in CURVE_FIELDS:
        entry, key = getattr(model, field), f"muscle_model.{field}"
        functions.append(declared(entry, key) if entry else None)
        if entry:
            check_arguments(functions[-1], (wp.float32,), key, entry)
            results = (wp.float32, wp.vec2) if field == "force_velocity" else (wp.float32,)
            check_result(functions[-1], results, key, entry)
    if not any(functions):
        return None
    return CustomCurves(*functions, sloped=functions[2] is not None and _result(functions[2]) == wp.vec2)


def declared(entry: str, key: str, *kinds: type) -> Any:
    """The Warp function of a name such as `module:function`, or what is of one of these classes; imports the module.

    Raises:
        SceneError: no such module or function, it is no Warp function, or its module fails.
    """
    module_name, _, name = entry.partition(":")
    module = _module(module_name, key)
    if not hasattr(module, name):
        own = [known for known, one in vars(module).items() if known[0] != "_" and not inspect.ismodule(one)]
        hint = near(name, own)
        raise SceneError(f"module {module_name!r} has no function {name!r}{hint}", key=key)
    function = getattr(module, name)
    if isinstance(function, kinds):
        return function
    return checked_function(function, entry, key, kinds)


def named_object(entry: str) -> Any:
    """What a name such as `module:function` stands for, whose module has been imported."""
    module, _, name = entry.partition(":")
    return getattr(sys.modules.get(module), name, None)


def checked_function(function: Any, entry: str, key: str, kinds: tuple[type, ...] = ()) -> Any:
    """What is to be a Warp function; raises SceneError if it is none, which names the classes it may be of instead."""
    if isinstance(function, wp.Function) and function.func is not None:
        return function
    if inspect.isfunction(function):
        name = entry if function.__name__ in entry else f"{entry}: {function.__name__}"
        raise SceneError(f"{name!r} is not a Warp function: put @wp.func before it", key=key)
    wanted = " or ".join(("Warp function", *(kind.__name__ for kind in kinds)))
    what = "a class" if isinstance(function, type) else f"of the type {type(function).__name__}"
    raise SceneError(f"{entry!r} must be a {wanted}; it is {what}", key=key)


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
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        others = "<frozen", __file__, str(Path(wp.__file__).parent), str(Path(typing.__file__).parent)
        last = next((frame for frame in reversed(frames) if not frame.filename.startswith(others)), frames[-1])
        said = f"{type(error).__name__}: {error}{_moved_to(error)}{_no_struct(error)}"
        raise SceneError(f"module {name!r} fails: {last.filename}:{last.lineno}: {said}", key=key) from error
    finally:
        sys.path[:] = before


def _moved_to(error: BaseException) -> str:
    """Where a name of the kernels is that an import did not find, if another module of theirs has it."""
    name = re.match(r"cannot import name '(\w+)' from 'warpmuscle\.kernels\b", str(error))
    places = modules_that_have(name[1]) if isinstance(error, ImportError) and name else []
    return f"; {' and '.join(places)} {'has' if len(places) == 1 else 'have'} one of this name" if places else ""


def _no_struct(error: BaseException) -> str:
    """What is forgotten where Warp does not know the class of an argument."""
    name = re.search(r"Unrecognized type '<class '[\w.]+\.(\w+)'>'", str(error))
    return f"; put @wp.struct before the class {name[1]}" if name else ""


def arguments_of(function: Any) -> tuple[Any, ...]:
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
    if said is type(None):
        return None
    return PLAIN.get(said, said) if isinstance(said, type) else said


def check_arguments(
    function: Any, wanted: tuple[Any, ...], key: str, entry: str, optional: tuple[Any, ...] = ()
) -> None:
    """SceneError unless a Warp function takes these arguments, and of the optional ones any, in their order."""
    taken = arguments_of(function)
    rest = [kind for kind in optional if kind in taken[len(wanted) :]]
    if taken != (*wanted, *rest):
        more = "".join(f" [, {name_of(kind)}]" for kind in optional)
        found = f"{placed(function, entry)} takes {signature(taken)}{undeclared(taken[len(wanted) :], optional)}"
        raise SceneError(f"it takes {signature(wanted)[:-1]}{more}), but {found}", key=key)


def undeclared(taken: tuple[Any, ...], known: tuple[Any, ...]) -> str:
    """What is said of parameters that a function takes and nothing declares."""
    structs = [kind for kind in taken if isinstance(kind, Struct) and kind not in known]
    names = [name_of(kind) for kind in structs if not kind.cls.__module__.startswith("warpmuscle.")]
    return f"; declare {' and '.join(names)} as its parameters" if names else ""


def source_tree(function: Any) -> ast.FunctionDef | None:
    """The syntax tree of a Warp function; None of one that a program has made."""
    try:
        first = ast.parse(textwrap.dedent(inspect.getsource(function.func))).body[0]
    except (OSError, SyntaxError):
        return None
    return first if isinstance(first, ast.FunctionDef) else None


def always_returns(body: list[ast.stmt]) -> bool:
    """Whether statements end by `return`, whichever branches are taken."""
    for statement in body:
        if isinstance(statement, ast.Return):
            return True
        if isinstance(statement, ast.If) and always_returns(statement.body) and always_returns(statement.orelse):
            return True
    return False


def check_memory(function: Any, floats: int, key: str, entry: str) -> None:
    """SceneError if a Warp function names a place of its memory that it does not have.

    Warp does not check places of arrays, and such a one would belong to another part. Places that are computed are
    not seen here.
    """
    arrays = [name for name, kind in function.input_types.items() if _is_floats(kind)]
    tree = source_tree(function)
    if tree is None:
        return
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in arrays):
            continue
        place = _constant(node.slice)
        if place is not None and not 0 <= place < floats:
            line = function.func.__code__.co_firstlineno + node.lineno - 1
            where = f"{entry!r} ({function.func.__code__.co_filename}:{line})"
            remedy = "declare more" if place >= 0 else "places are counted from 0 on"
            raise SceneError(f"{where}: {node.value.id}[{place}] is not in a memory of {floats}: {remedy}", key=key)


def _constant(node: ast.expr) -> int | None:
    """The whole number that is written there; None if it is computed."""
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return None
    return value if isinstance(value, int) else None


def check_known(function: Any, phase: str, key: str, entry: str, at: str, later: str = "") -> None:
    """SceneError if a Warp function, or what it calls, uses what the working set does not hold in a phase of a step.

    In its place is what was there a step before, what another instance left, or what has taken the place since.

    Args:
        at: when that is, in words. later: what to do where it would be known later.
    """
    now, solved = PHASES.index(phase), PHASES.index("forward")
    for name in _used(function, set()):
        if name not in LIVES:
            raise SceneError(f"in {placed(function, entry)} there is no work.{name}{near(name, LIVES)}", key=key)
        first, last = (PHASES.index(one) for one in LIVES[name][:2])
        early = first > now
        if early or (now >= solved > last and name not in APART):
            when = f"yet {at}{later}" if early else f"any more {at}"
            raise SceneError(f"in {placed(function, entry)} work.{name} is not known {when}", key=key)


def _used(function: Any, seen: set[Any]) -> Iterator[str]:
    """Parts of the working set that a Warp function and all that it calls use, but what lives longer of the root."""
    tree = source_tree(function)
    if tree is None or function.func in seen:
        return
    seen.add(function.func)
    works = {name for name, kind in zip(function.input_types, arguments_of(function), strict=True) if kind is Scratch}
    inside = {**function.func.__globals__, **inspect.getclosurevars(function.func).nonlocals}
    nodes = list(ast.walk(tree))
    of_root = {
        id(node.value) for node in nodes
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and node.slice.value == 0
    }  # fmt: skip
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in works:
            if not (node.attr in LIVES and LIVES[node.attr].root and id(node) in of_root):
                yield node.attr
        elif isinstance(node, ast.Call) and works & {one.id for one in node.args if isinstance(one, ast.Name)}:
            called = inside.get(node.func.id) if isinstance(node.func, ast.Name) else None
            if isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
                called = getattr(inside.get(node.func.value.id), node.func.attr, None)
            if isinstance(called, wp.Function) and called.func is not None:
                yield from _used(called, seen)


def check_result(function: Any, wanted: tuple[Any, ...], key: str, entry: str) -> Any:
    """The type that a Warp function says that it returns; SceneError unless it is one of these."""
    said = _result(function)
    if said not in wanted:
        names = " or ".join(name_of(kind) for kind in wanted)
        raise SceneError(
            f"{placed(function, entry)} must say that it returns {names}, and says {name_of(said)}", key=key
        )
    tree = source_tree(function) if said is not None else None
    if tree is not None and not always_returns(tree.body):  # what it returned otherwise would be any number
        raise SceneError(
            f"on some branches {placed(function, entry)} has no return: end it with one of {name_of(said)}", key=key
        )
    return said


def placed(function: Any, entry: str) -> str:
    """A function's name with its file and line."""
    code = function.func.__code__
    return f"{entry!r} ({code.co_filename}:{code.co_firstlineno})"


def signature(arguments: tuple[Any, ...]) -> str:
    return f"({', '.join(map(name_of, arguments))})"


def name_of(kind: Any) -> str:
    plain = {
        None: "nothing",
        wp.int32: "int",
        wp.float32: "float",
        wp.vec2: "wp.vec2",
        wp.vec3: "wp.vec3",
        FLOATS: FLOATS,
    }
    if isinstance(kind, Table):
        return f"wp.array[{name_of(kind.struct)}]"
    if kind in plain:
        return plain[kind]
    if getattr(kind, "ndim", 0):
        return f"wp.array{f'{kind.ndim}d' if kind.ndim > 1 else ''}[{name_of(kind.dtype)}]"
    return str(getattr(kind, "key", None) or getattr(kind, "__name__", kind)).rpartition(".")[2]
