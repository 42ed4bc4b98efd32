"""Arguments of public functions, checked where they come in: what is wrong is said with the argument's name."""

from __future__ import annotations

import difflib
import functools
import inspect
import math
import numbers
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.errors import ArgumentError, Error

LONGEST = 40  # characters of a value that are repeated in an error
LONGEST_REASON = 90  # and of what Python says
Kind = TypeVar("Kind")
P = ParamSpec("P")
R = TypeVar("R")


def answering(instead: Mapping[str, str], otherwise: str = "") -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator of functions that say what to type in place of an argument which they do not have.

    Args:
        instead: what to type, by names of arguments that are often tried. otherwise: what to type for all others that
            are no slip of the pen.

    Raises:
        TypeError: of the decorated function, as Python's own, with what to type.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        parameters = inspect.signature(function).parameters
        name = function.__qualname__.removesuffix(".__init__")
        is_method = "." in name and next(iter(parameters), "") == "self"

        @functools.wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            for one in kwargs:
                if one not in parameters:
                    said = f"{type(args[0]).__name__}.{function.__name__}" if is_method and args else name
                    raise TypeError(f"{said} has no argument {one!r}{_hint(one, parameters, instead, otherwise)}")
            return function(*args, **kwargs)

        return called

    return decorated


def not_made_by_hand(kind: str, instead: str, error: TypeError) -> TypeError:
    """What is said where a class is called with other arguments than its own, such as the name of a file.

    Args:
        kind: the class. instead: what to type. error: Python's own, whose words follow where they are few.
    """
    why = str(error).partition("() ")[2] or str(error)
    more = f" ({why[0].lower()}{why[1:]})" if len(why) <= LONGEST_REASON else ""
    return TypeError(f"wm.{kind} takes the parts of one, not a name or a file: {instead}{more}")


def obtained_by(instead: str) -> Callable[[type[Kind]], type[Kind]]:
    """A decorator of classes that say what to type in place of a call without the arguments which they take.

    Args:
        instead: what to type.

    Raises:
        TypeError: of the decorated class.
    """

    def decorated(kind: type[Kind]) -> type[Kind]:
        begin = vars(kind)["__init__"]

        @functools.wraps(begin)
        def called(self: Kind, *args: Any, **kwargs: Any) -> None:
            try:
                begin(self, *args, **kwargs)
            except TypeError as error:
                if error.__traceback__ is not None and error.__traceback__.tb_next is not None:
                    raise  # from within
                raise not_made_by_hand(kind.__name__, instead, error) from None

        kind.__init__ = called  # type: ignore[method-assign, assignment]
        return kind

    return decorated


def _hint(name: str, known: Iterable[str], instead: Mapping[str, str], otherwise: str) -> str:
    """What to type in place of an argument, or the nearest that there is, as the end of a message."""
    if name in instead:
        return f"; {instead[name]}"
    found = difflib.get_close_matches(name, [one for one in known if one != "self"], n=1)
    if found:
        return f"; did you mean {found[0]!r}?"
    return f"; {otherwise}" if otherwise else ""


def in_words(value: object) -> str:
    """What a value is, in few words and one line."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of shape {value.shape}"
    if value is None or isinstance(value, str | bytes | bool | numbers.Number | np.generic | os.PathLike):
        plain = value.item() if isinstance(value, np.generic) else value
        try:
            shown = " ".join(repr(os.fspath(plain) if isinstance(plain, os.PathLike) else plain).split())
        except ValueError:  # a whole number of too many digits
            return "a whole number of thousands of digits"
        return shown if len(shown) <= LONGEST else f"{shown[:LONGEST]}..."
    name = type(value).__name__
    return f"{'an' if name[:1].lower() in 'aeiou' else 'a'} {name}"


def as_number(
    value: Any,
    name: str,
    *,
    least: float = -math.inf,
    above: float = -math.inf,
    most: float = math.inf,
    infinite: bool = False,
    error: type[Error] = ArgumentError,
) -> float:
    """A number, finite unless it may be infinite, no less than one bound, greater than another, not over a third."""
    plain = _plain(value)
    wanted = "a number" if infinite else "a finite number"
    if above > -math.inf:
        wanted += f" greater than {above:g}"
    elif least > -math.inf:
        wanted += f", {least:g} or greater" if most == math.inf else f" from {least:g} to {most:g}"
    if isinstance(plain, numbers.Real) and not isinstance(plain, bool):
        try:
            found = float(plain)
        except OverflowError:
            found = math.inf
        allowed = not math.isnan(found) if infinite else math.isfinite(found)
        if allowed and least <= found <= most and (found > above or above == -math.inf):
            return found
    raise error(f"{name} must be {wanted}, not {in_words(value)}")


def as_integer(
    value: Any, name: str, least: int = 1, most: int | None = None, *, error: type[Error] = ArgumentError
) -> int:
    """A whole number within bounds; 2.0 is one, True is none."""
    plain = _plain(value)
    wanted = {0: "a whole number, 0 or greater", 1: "a positive whole number"}.get(least, "a whole number")
    if most is not None:
        wanted = f"a whole number from {least} to {most}"
    is_whole = isinstance(plain, int) or (isinstance(plain, float) and plain.is_integer())
    if is_whole and not isinstance(plain, bool) and least <= plain and (most is None or plain <= most):
        return int(plain)
    raise error(f"{name} must be {wanted}, not {in_words(value)}")


def as_truth(value: Any, name: str, *, error: type[Error] = ArgumentError) -> bool:
    """True or False."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise error(f"{name} must be True or False, not {in_words(value)}")


def as_text(value: Any, name: str, *, error: type[Error] = ArgumentError) -> str:
    """A text."""
    if isinstance(value, str):
        return value
    raise error(f"{name} must be text, not {in_words(value)}")


def as_texts(value: Any, name: str, *, error: type[Error] = ArgumentError) -> tuple[str, ...]:
    """Several texts, or one."""
    if isinstance(value, str):
        return (value,)
    if isinstance(value, Iterable) and not isinstance(value, bytes | dict):
        found = tuple(value)
        for one in found:
            if not isinstance(one, str):
                raise error(f"{name} must be a list of texts; {in_words(one)} is none")
        return found
    raise error(f"{name} must be a list of texts, not {in_words(value)}")


def as_path(value: Any, name: str, *, error: type[Error] = ArgumentError) -> Path:
    """The path of a file."""
    if isinstance(value, str | os.PathLike):
        plain = os.fspath(value)
        if isinstance(plain, str) and plain and "\0" not in plain:
            return Path(plain)
    raise error(f"{name} must be the path of a file, not {in_words(value)}")


def as_kind(kind: type[Kind], value: Any, name: str, *, error: type[Error] = ArgumentError) -> Kind:
    """A value of a class."""
    if isinstance(value, kind):
        return value
    within = next((part for part, own in getattr(value, "__dict__", {}).items() if isinstance(own, kind)), "")
    hint = f"; it has one: its .{within}" if within and not within.startswith("_") else ""
    raise error(f"{name} must be a {kind.__name__}, not {in_words(value)}{hint}")


def check_function(value: Any, name: str, *, error: type[Error] = ArgumentError) -> None:
    """A function, or None."""
    if value is not None and not callable(value):
        raise error(f"{name} must be a function, not {in_words(value)}")


def as_array(values: Any, name: str, *, error: type[Error] = ArgumentError) -> NDArray[Any]:
    """An array of numbers, float32 as it is and others as float64; they may be infinite, or not numbers."""
    try:
        found = np.asarray(values)
    except (TypeError, ValueError, RuntimeError):  # lists of different lengths, arrays of a device
        raise error(f"{name} must be an array of numbers, and {in_words(values)} makes none") from None
    if found.dtype.kind in "iuf" or found.size == 0:
        return found if found.dtype == np.float32 else found.astype(np.float64)
    raise error(f"{name} must be an array of numbers, not {in_words(values)}")


def _plain(value: Any) -> Any:
    """A number of Python in place of one of NumPy, or of an array that holds one alone without dimensions."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return value.item()
    return value
