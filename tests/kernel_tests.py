"""Warp as tests of kernels have it: quiet, without derivatives that nothing takes, each module compiled once.

Workers share Warp's folder of compiled kernels. The first that needs a module compiles it, and others wait for it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

# Kernels for kinds of scenes that are launched once where they are asked for, and not at every step.
SELDOM = (
    "muscle_paths_of", "muscle_moments_of", "muscle_wrenches_of", "muscle_torques",
    "forward_dynamics_of", "contact_forces_of", "controller_torques",
)  # fmt: skip
_loads = [0]  # how often a launch has asked for a module
_without: list[set[Any]] = []  # modules that are compiled without optimisation, of who wants that


def start() -> None:
    """Start Warp for tests; the next calls do nothing."""
    import warp as wp

    if hasattr(wp.Module, "of_tests"):
        return
    wp.Module.of_tests = True
    wp.config.log_level, wp.config.enable_backward = wp.LOG_WARNING, False
    wp.init()
    load, compile_ = wp.Module.load, getattr(wp.Module, "_compile", None)

    def counted(module: Any, device: Any, *arguments: Any, **options: Any) -> Any:
        _loads[0] += 1
        if not wp.get_device(device).is_cpu:
            return load(module, device, *arguments, **options)
        if _is_launched_seldom(module):
            if module.options["optimization_level"] is None:
                not_optimized(module)
        elif _without and _is_of_a_kind_or_test(module) and module not in _without[-1]:
            not_optimized(module)
            _without[-1].add(module)
        return load(module, device, *arguments, **options)

    def not_optimized(module: Any) -> None:
        module.unload()  # what was loaded before with optimisation rounds differently
        module.options["optimization_level"] = 0
        module.mark_modified()

    def once(module: Any, device: Any, output_dir: str | None = None, *arguments: Any, **options: Any) -> Any:
        name = Path(output_dir or module.get_module_identifier()).name
        with alone(Path(wp.config.kernel_cache_dir) / "compiling" / name):
            return compile_(module, device, output_dir, *arguments, **options)

    wp.Module.load = counted
    leave_out_unused_adjoints()
    remember_overloads()
    walk_structures_once()
    if compile_ is not None:  # it is Warp's own affair; without it, workers compile what they have in common each
        wp.Module._compile = once


def leave_out_unused_adjoints() -> None:
    """Leave functions of structures that only derivatives call out of modules without derivatives.

    They are a fifth of the text of a step, and compiled with it for nothing. Other functions are as they were.
    """
    from warp._src import codegen, context

    template = getattr(codegen, "struct_template", "")
    begin, end = template.find("static CUDA_CALLABLE void adj_{name}("), template.find("{tile_helper_body}")
    builder = getattr(context, "ModuleBuilder", None)
    if not 0 < begin < end or builder is None:  # another Warp
        return
    short, made = template[:begin] + template[end:], builder.codegen

    def with_what_is_used(self: Any, device: str = "cpu", **options: Any) -> str:
        codegen.struct_template = short if device == "cpu" and not self.options["enable_backward"] else template
        return made(self, device, **options)

    builder.codegen = with_what_is_used


def remember_overloads() -> None:
    """Have Warp look once for the built-in function that suits arguments of certain types, not at every call.

    A step has thousands of calls, and each is compared with up to a hundred functions: a third of its translation.
    """
    from warp._src import codegen

    find, found = getattr(codegen.Adjoint, "resolve_func", None), {}
    if find is None:  # another Warp
        return

    def remembered(self: Any, func: Any, arg_types: Any, kwarg_types: Any, *others: Any) -> Any:
        if not func.is_builtin():  # functions of ours may be made anew for these types
            return find(self, func, arg_types, kwarg_types, *others)
        asked = func, arg_types, tuple(kwarg_types.items()), others
        try:
            return found[asked]
        except KeyError:
            return found.setdefault(asked, find(self, func, arg_types, kwarg_types, *others))
        except TypeError:  # a type that is no key
            return find(self, func, arg_types, kwarg_types, *others)

    codegen.Adjoint.resolve_func = remembered


def walk_structures_once() -> None:
    """Have Warp look once for the types of a structure's fields in a module, not for each variable of the structure."""
    from warp._src import codegen, context

    collect = getattr(context.ModuleBuilder, "_collect_native_types", None)
    if collect is None:  # another Warp
        return

    def once(self: Any, var_type: Any) -> None:
        kind = codegen.strip_reference(var_type)
        if isinstance(kind, codegen.Struct):
            walked = self.__dict__.setdefault("structures_walked", set())
            if kind in walked:
                return
            walked.add(kind)
        collect(self, kind)

    context.ModuleBuilder._collect_native_types = once


def _is_of_a_kind_or_test(module: Any) -> bool:
    """Whether a module was made for a kind of scene, or has kernels of a file of tests alone."""
    return "__locals__" in module.name or module.name.startswith(("tests.", "map_"))


def _is_launched_seldom(module: Any) -> bool:
    """Whether a module was made for a kind of scene, and is compiled for longer than it runs in any test."""
    return "__locals__" in module.name and module.name.rpartition(".")[2].startswith(SELDOM)


def loads() -> int:
    """How often this process has launched kernels, or loaded modules of them."""
    return _loads[0]


@contextmanager
def unoptimized() -> Iterator[None]:
    """Have kernels that are made for a kind of scene compiled without optimisation; they are gone afterwards."""
    start()
    _without.append(set())
    try:
        yield
    finally:
        for module in _without.pop():
            module.options["optimization_level"] = None
            module.unload()


@contextmanager
def optimized() -> Iterator[None]:
    """Have kernels compiled as those of users for a while within `unoptimized`."""
    depth = len(_without)
    while _without:
        for module in _without.pop():
            module.options["optimization_level"] = None
            module.unload()
    try:
        yield
    finally:
        _without.extend(set() for _ in range(depth))


@contextmanager
def alone(file: Path) -> Iterator[None]:
    """Wait until no other process, or thread, is within for this file, which is made."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w") as opened:
        if fcntl is not None:
            fcntl.flock(opened, fcntl.LOCK_EX)  # until it is closed
        yield
