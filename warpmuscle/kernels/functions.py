"""The decorator of functions of this package: Warp parses one when a kernel first needs it, not when it is imported.

Warp takes a millisecond for each, and a step needs a third of them. This relies on how Warp keeps functions: with
a version that nobody has tested, all are parsed at once, as Warp does it.
"""

from collections.abc import Callable
from functools import partial, update_wrapper
from threading import RLock
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.differences import DIFFERENCES

Python = Callable[..., Any]
_parsing = RLock()
TESTED = ("1.19.",)  # versions of Warp
LATE = str(wp.config.version).startswith(TESTED)
# On a CPU all of a kernel is one function, with fused products. Kernels that a command compiles have these flags in
# common, since a process compiles Warp's headers once for each choice of flags, for as long as a small kernel.
# What Clang's driver does without by itself, to save a fifth of the time: checks of its own work after each stage, and
# names of values within it. To tell types of memory apart helps no step of a body: it reads and writes floats.
CPU_FLAGS = (
    "-march=native -ffp-contract=fast -mllvm=-inline-threshold=100000 -mllvm=-inline-cold-callsite-threshold=100000"
    " -disable-llvm-verifier -discard-value-names -relaxed-aliasing"
)

# Warp's counters of loops are structures of 16 bytes, which a function returns in two registers of a processor of x86
# or ARM. Clang leaves two numbers in each of them, and then knows neither how often a loop runs nor where its data lie.
# These are constructed instead, so that each number has a register of its own.
COUNTERS = """
namespace wp {
struct counter_t {
    int i = 0, end = 0, step = 1;
    counter_t() { }
    counter_t(int end) : end(end) { }
    counter_t(int start, int end) : i(start), end(end) { }
    counter_t(int start, int end, int step) : i(start), end(end), step(step) { }
};
inline int iter_next(counter_t& c)
{
    int now = c.i;
    c.i += c.step;
    return now;
}
inline bool iter_cmp(const counter_t& c) { return c.step > 0 ? c.i < c.end : c.step < 0 && c.i > c.end; }
}
#define range_t counter_t
#define range counter_t
"""


def build_options() -> dict[str, Any]:
    """Module options of a kernel without gradients: loops that a CPU runs quickly, a GPU's differences decided."""
    if not LATE:  # Warp calls them experimental, so that another version may name things differently
        return {}
    options = wp.ModuleBuildOptions(extra_cpu_preamble=COUNTERS, extra_cuda_preamble=DIFFERENCES)
    return {"extra_build_options": options}


class LateFunction(wp.Function):
    """A Warp function that is parsed when somebody first asks for more than its name and its Python code."""

    def __init__(self, python: Python, inline: bool | None) -> None:
        update_wrapper(self, python)
        self.func, self.inline = python, inline

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("__") and "adj" not in self.__dict__:
            with _parsing:
                if "adj" not in self.__dict__ and "is_parsed_now" not in self.__dict__:
                    self._parse()
        try:
            return self.__dict__[name]
        except KeyError:
            raise AttributeError(f"{self.func.__name__} has no attribute {name!r}") from None

    def _parse(self) -> None:
        """Become the function that `wp.func` makes of the same code."""
        gradient = self.__dict__.get("gradient")
        self.__dict__["is_parsed_now"] = True  # so that nothing that looks for references parses it again
        try:
            made = wp.func(self.func, inline=self.inline)
            if made.func is not self.func:  # but one of the same name that it calls, as those of a factory do
                made = wp.func(self.func, inline=self.inline)
            self.__dict__ = made.__dict__
        finally:
            self.__dict__.pop("is_parsed_now", None)
        if gradient is not None:
            _put(gradient, self)


def func(python: Python | None = None, *, inline: bool | None = None) -> Any:
    """`wp.func` that parses late: for functions whose names stand for the same later on, those in `wp.static` too.

    Not for several functions of one name, nor in modules with kernels, which Warp would hash anew for each function
    that it learns of.
    """
    kind = LateFunction if LATE else wp.func
    return partial(kind, inline=inline) if python is None else kind(python, inline=inline)


def gradient_of(function: Any) -> Callable[[Python], Python]:
    """`wp.func_grad` of a function whose annotation says that it returns a float.

    Warp would translate the function, and all that it calls, to find that out.
    """
    if not LATE:
        at_once: Callable[[Python], Python] = wp.func_grad(function)
        return at_once

    def given(gradient: Python) -> Python:
        if isinstance(function, LateFunction) and "adj" not in function.__dict__:
            function.__dict__["gradient"] = gradient
        else:
            _put(gradient, function)
        return gradient

    return given


def known_gradient(function: Any) -> Python | None:
    """The Python code of the gradient that a function was given; it is not parsed for that. None if it has none."""
    if isinstance(function, LateFunction) and "adj" not in function.__dict__:
        late: Python | None = function.__dict__.get("gradient")
        return late
    given = function.custom_grad_func
    return None if given is None else given.func


def _put(gradient: Python, function: Any) -> None:
    """Give a function that is parsed its gradient."""
    if not hasattr(function.adj, "return_var"):
        function.adj.return_var = (_Returned(),)
    wp.func_grad(function)(gradient)


class _Returned:
    """What Warp asks of the value that a function returns; it is replaced where the function is translated."""

    label, type = "returned", wp.float32
