"""Warp as tests of kernels have it: quiet, without derivatives that nothing takes, each module compiled once.

Workers share Warp's folder of compiled kernels. The first that needs a module compiles it, and others wait for it.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

import kernel_text

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

# Kernels for kinds of scenes that are launched once where they are asked for, and not at every step.
SELDOM = (
    "model_forces_of", "muscle_paths_of", "muscle_moments_of", "muscle_wrenches_of", "muscle_torques",
    "forward_dynamics_of", "contact_forces_of", "controller_torques",
)  # fmt: skip
# Modules that are launched between steps, for a few instances.
BETWEEN = frozenset(
    f"warpmuscle.kernels.{module}"
    for module in (
        *("inverse.inverse_dynamics", "learning.episodes", "learning.rewards", "learning.senses"),
        *("program.frames", "program.gather", "stages", "contact.terrain_starts"),
    )
)
# What Clang's driver does without by itself: checks of what each stage makes, and names of values within it.
UNCHECKED = "-disable-llvm-verifier", "-discard-value-names"
# And templates of Warp's headers as these compile, once, not with each module: 0.04 s of each.
QUICK = *UNCHECKED, "-fpch-instantiate-templates"
_loads = [0]  # how often a launch has asked for a module
_without: list[set[Any]] = []  # modules that are compiled without optimisation, of who wants that
_headers: list[Path] = []  # where workers share the headers of Warp that one of them has compiled, if they do


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
    compile_with_less_work()
    leave_out_unused_adjoints()
    remember_overloads()
    walk_structures_once()
    translate_functions_once()
    if compile_ is not None:  # it is Warp's own affair; without it, workers compile what they have in common each
        wp.Module._compile = once


def share_headers(folder: Path) -> None:
    """Let this process take, and leave, Warp's compiled headers in a folder that other workers have, too."""
    if fcntl is not None:  # else two could write one at a time
        _headers[:] = [folder]


def compile_with_less_work() -> None:
    """Have each module compiled without checks of the compiler's own work, and Warp's headers once for all workers.

    The machine code is the same. Headers take a second for each level of optimisation and choice of flags.
    """
    from warp._src import build

    compile_ = getattr(build, "build_cpu", None)
    if compile_ is not None:  # else it is another Warp
        build.build_cpu = with_less_work(compile_)


def with_less_work(compile_: Callable[..., None]) -> Callable[..., None]:
    """Warp's function that compiles a file for a processor, with `QUICK` and shared headers."""

    @wraps(compile_)
    def compiled(obj_path: str, cpp_path: str, *arguments: Any, **options: Any) -> None:
        flags = options.get("extra_flags", "").split()
        options["extra_flags"] = " ".join((*flags, *(flag for flag in QUICK if flag not in flags)))
        if not _headers or not options.get("pch_dir"):
            return compile_(obj_path, cpp_path, *arguments, **options)
        options["pch_dir"] = str(_headers[0])
        kind = hashlib.sha256(repr((arguments, sorted(options.items()))).encode()).hexdigest()[:16]
        made = _headers[0] / f"{kind}.made"
        if not made.exists():
            with alone(made.with_suffix(".making")):
                if not made.exists():  # the first module brings the headers with it
                    compile_(obj_path, cpp_path, *arguments, **options)
                    made.touch()
                    return None
        return compile_(obj_path, cpp_path, *arguments, **options)

    return compiled


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
        text = made(self, device, **options)
        quick = device == "cpu" and self.options.get("optimization_level") == 0
        return kernel_text.without_hints(text) if quick else text

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


def translate_functions_once() -> None:
    """Have Warp translate a function once for all modules that call it, while its hash and their options are the same.

    Most of a step are functions that every kind of scene has: two hundred modules would each have them anew.
    """
    from warp._src import codegen, context

    builder, adjoint = getattr(context, "ModuleBuilder", None), codegen.Adjoint
    write = getattr(codegen, "codegen_func", None)
    if not hasattr(builder, "build_function") or not hasattr(builder, "build_struct_recursive") or write is None:
        return  # another Warp
    build_function, build_structure, build = builder.build_function, builder.build_struct_recursive, adjoint.build

    def forgotten(self: Any, *arguments: Any, **options: Any) -> None:
        self.translation = None  # what was known is of the state that this call replaces
        build(self, *arguments, **options)

    def noted_structure(self: Any, structure: Any) -> None:
        functions = _functions(self)
        for asked in functions.asked[-1:]:
            asked.append((build_structure, structure))
        build_structure(self, structure)

    def once(self: Any, function: Any) -> None:
        functions = _functions(self)
        if function in functions:
            return
        key, known = _translation_key(self, function), getattr(function.adj, "translation", None)
        functions.asked.append([])
        try:
            if key is None or known is None or known.key != key:
                before = _linked(self)
                build_function(self, function)
                if key is not None and _linked(self) == before:
                    others = [(ask, what) for ask, what in functions.asked[-1] if what is not function]
                    function.adj.translation = _Translation(key, others, {})
                return
            for ask, what in known.asked:  # what it calls comes before it, in the same order
                ask(self, what)
            for variable in (*function.adj.args, *function.adj.variables):
                self._collect_native_types(variable.type)
            functions[function] = None
        finally:
            functions.asked.pop()

    def written(adj: Any, c_func_name: str, device: str = "cpu", **options: Any) -> str:
        known = getattr(adj, "translation", None)
        derivatives = adj.used_by_backward_kernel or adj.force_adjoint_codegen
        if known is None or device != "cpu" or derivatives or options["options"]["enable_backward"]:
            return write(adj, c_func_name, device, **options)
        if options["reverse_only"]:
            return ""  # an empty function that only derivatives would call
        quick = options["options"].get("optimization_level") == 0
        key = c_func_name, options["forward_only"], options["inline_hint"], quick
        if key not in known.texts:
            text = write(adj, c_func_name, device, **options)
            known.texts[key] = kernel_text.shortened(text) if quick else text
        return known.texts[key]

    builder.build_function, builder.build_struct_recursive, adjoint.build = once, noted_structure, forgotten
    codegen.codegen_func = written


class _Functions(dict[Any, None]):
    """Functions of a module, and what was asked for while each of those that are being translated was so far."""

    def __init__(self, known: dict[Any, None], ask: Any) -> None:
        super().__init__(known)
        self.asked: list[list[tuple[Any, Any]]] = []
        self.ask = ask

    def __contains__(self, function: Any) -> bool:
        for asked in self.asked[-1:]:
            asked.append((self.ask, function))
        return super().__contains__(function)


def _functions(builder: Any) -> _Functions:
    if not isinstance(builder.functions, _Functions):
        builder.functions = _Functions(builder.functions, type(builder).build_function)
    return builder.functions


class _Translation(NamedTuple):
    """What Warp has found out about a function that is as it is with one hash and one set of options."""

    key: tuple[bytes, str]
    asked: list[tuple[Any, Any]]  # methods of a builder and what each was called with, in order
    texts: dict[Any, str]


def _translation_key(builder: Any, function: Any) -> tuple[bytes, str] | None:
    """What the translation of a function depends on; None if that is not known."""
    hasher = builder.module.hashers.get(builder.options["block_dim"])
    if hasher is None:
        return None
    hashes = hasher.__dict__.get("hashes_of_overloads")
    if hashes is None:
        of_functions = hasher.function_hashes.items()
        hashes = {overload: found for named, found in of_functions for overload in named.user_overloads.values()}
        hasher.hashes_of_overloads = hashes
    found = hashes.get(function) or hasher.function_hashes.get(function)
    options = sorted((name, str(value)) for name, value in builder.options.items() if name != "optimization_level")
    return (found, f"{builder.target} {options}") if found else None


def _linked(builder: Any) -> tuple[int, ...]:
    """How much of other kinds than functions and structures a module has, for which a translation is not enough."""
    kinds = builder.deferred_functions, builder.fatbins, builder.ltoirs, builder.ltoirs_decl
    return (*map(len, kinds), len(builder.shared_memory_bytes))


def _is_of_a_kind_or_test(module: Any) -> bool:
    """Whether a module was made for a kind of scene, or has kernels of a file of tests alone."""
    return "__locals__" in module.name or module.name.startswith(("tests.", "map_"))


def _is_launched_seldom(module: Any) -> bool:
    """Whether a module is compiled for longer than it runs in any test."""
    of_a_kind = "__locals__" in module.name and module.name.rpartition(".")[2].startswith(SELDOM)
    return of_a_kind or module.name in BETWEEN


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
