"""The laws of muscles, by the name that a scene has for them: those of `law_names`, each from its file."""

import ast
import inspect
import textwrap
from importlib import import_module
from pathlib import Path
from typing import Any

import warp as wp

from warpmuscle.kernels.muscle.law_names import NAMES
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind, MuscleLaw
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStep
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import Model, MuscleRow, State

IN_A_STEP = (wp.int32, wp.int32, MuscleStep, Model, State)
ARGUMENTS = {  # of the functions of a law, by its fields: as one writes them, and their types
    "activate": ("(instance, m, muscle, model, state)", IN_A_STEP),
    "contract": ("(instance, m, muscle, model, state)", IN_A_STEP),
    "strength": (
        "(instance, m, stretch, row, model, state) -> wp.vec3",
        (wp.int32, wp.int32, PathState, MuscleRow, Model, State),
    ),
}
WRITES = {"activate": "activation", "contract": "fibre"}  # what of the `MuscleStep` a function is there to write


def law_of_file(name: str) -> MuscleLaw:
    """The law in the file of its name.

    Raises:
        TypeError: there is no such file, or what it has is no law; it names both.
    """
    file, constant = f"{name}_law.py", name.upper()
    module = f"{__package__}.{name}_law"
    try:
        law = getattr(import_module(module), constant, None)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise TypeError(f"law of muscles {name!r} has no file {file} with its {constant}") from None
    if not isinstance(law, MuscleLaw):
        raise TypeError(f"law of muscles {name!r}: {file} has no {constant}, a `muscle_kind.MuscleLaw`")
    for field in ARGUMENTS:
        needs = f"{constant} in {file} needs a function of the `MuscleKind` that makes a Warp function"
        if isinstance(getattr(law, field), wp.Function):
            raise TypeError(f"law of muscles {name!r}: {field!r} is a Warp function: {needs}, as `lambda kind: ...`")
        if not callable(getattr(law, field)):
            raise TypeError(f"law of muscles {name!r} has no {field!r}: {needs}")
    return law


def function_of(kind: MuscleKind, field: str) -> Any:
    """The Warp function that a kind's law makes of it.

    Args:
        field: activate, contract or strength.

    Raises:
        TypeError: it makes none, one that takes or returns something else, or one that does not write its result.
    """
    function = getattr(kind.law, field)(kind)
    name = next((name for name, law in LAWS.items() if law == kind.law), "of a kind")
    what, (written, wanted) = f"law of muscles {name!r}: its {field!r}", ARGUMENTS[field]
    if not isinstance(function, wp.Function):
        raise TypeError(f"{what} makes no Warp function {written}, but something of type {type(function).__name__}")
    code = function.func.__code__
    where = f"{function.func.__name__} ({code.co_filename}:{code.co_firstlineno})"
    taken = tuple(getattr(taken, "value_type", taken) for taken in function.input_types.values())
    if tuple({int: wp.int32, float: wp.float32}.get(one, one) for one in taken) != wanted:
        raise TypeError(f"{what} must make a Warp function {written}: {where} takes other arguments")
    if field == "strength" and function.func.__annotations__.get("return") is not wp.vec3:
        raise TypeError(f"{what} must make a Warp function {written}: {where} does not return that")
    if field in WRITES and not is_written(function.func, WRITES[field]):
        raise TypeError(f"{what} must write `muscle.{WRITES[field]}`: {where} does not")
    return function


def is_written(python: Any, field: str) -> bool:
    """Whether a function writes this field of its third argument, or gives that whole to another function."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(python)))
    muscle = list(inspect.signature(python).parameters)[2]
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and node.attr == field:
            return True
        if isinstance(node, ast.Call) and any(isinstance(a, ast.Name) and a.id == muscle for a in node.args):
            return True
    return False


def laws_of(folder: Path) -> dict[str, MuscleLaw]:
    """All laws, in the order of their names.

    Args:
        folder: where the files of laws lie.

    Raises:
        TypeError: a name has no law, or a file has no name, which no scene could then choose.
    """
    for file in sorted(folder.glob("*_law.py")):
        name = file.stem.removesuffix("_law")
        if name not in NAMES:
            raise TypeError(f"law of muscles {name!r} in {file.name} has no name: add it to `Law` in law_names.py")
    return {name: law_of_file(name) for name in NAMES}


LAWS: dict[str, MuscleLaw] = laws_of(Path(__file__).parent)
HILL, LEGACY, IDEAL = LAWS["hill"], LAWS["legacy"], LAWS["ideal"]
