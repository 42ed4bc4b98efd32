"""What Warp called a kernel when an earlier process made it, so that nobody has to parse it to find that out.

Warp finds compiled code by a hash of all functions that a kernel calls. To parse 218 of them for a step and to hash
them takes longer than to load what was compiled. What they are follows from the files of this package and from what
asks for the kernel, both of which are quickly looked through; so the hashes are kept beside Warp's compiled code,
under a digest of these. Functions are then parsed only if the kernel has to be compiled after all.

That holds as long as nobody but the files says what the functions are. So it is for programs of this package to begin
with it (`remember`), and for those that let other code run to end it (`forget`). It relies on how Warp hashes: with a
version that nobody has tested it is never done.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import warp as wp

from warpmuscle.kernels.functions import LATE

FOLDER = Path(__file__).parent
BYTES = 32  # of a hash

_remembering = False


class _Unknown(Exception):
    """Something that asks for a kernel may be other than it looks."""


def remember() -> None:
    """From now on take hashes over from earlier processes, and leave them to later ones."""
    global _remembering
    _remembering = LATE


def forget() -> None:
    """Do so no longer, since code that is not of this package may change what functions are."""
    global _remembering
    _remembering = False


class Postponed(wp.Function):
    """A Warp function that is made when somebody first asks for more than its name, and that nobody else has."""

    def __init__(self, name: str, make: Callable[[], Any]) -> None:
        self.__name__, self._make = name, make

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or "_make" not in self.__dict__:
            raise AttributeError(f"no attribute {name!r}")
        made = self.__dict__.pop("_make")()
        made.adj  # noqa: B018, parses it
        self.__dict__ |= made.__dict__
        return getattr(made, name)


def known_kernel(*asked: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """`wp.kernel` of a module of its own, with the hashes that it had in an earlier process, if that is known.

    Args:
        asked: all that the kernel is made of, besides the files of this package and its options.
        options: of `wp.kernel`.
    """

    def made(function: Callable[..., Any]) -> Any:
        with _hashed_by(function.__name__, asked) if _remembering else contextlib.nullcontext():
            return wp.kernel(function, module="unique", **options)

    return made


@contextlib.contextmanager
def _hashed_by(key: str, asked: tuple[Any, ...]) -> Iterator[None]:
    """Have Warp ask here for the hashes of the one kernel that is made within."""
    from warp._src import codegen, context

    hasher, scan = context.ModuleHasher, context.Module._find_references
    skipped = False

    def hashes(kernels: Any, options: dict[str, Any]) -> Any:
        nonlocal skipped
        (kernel,) = kernels
        chosen = [f"{name}: {value}" for kept in (options, kernel.options) for name, value in sorted(kept.items())]
        file = _file(key, *asked, chosen)
        before = None if file is None else _read(file)
        if before is not None:
            skipped = True
            return _Known(kernel, before, options)
        found = hasher(kernels, options)
        if file is not None and _file(key, *asked, chosen) == file:  # nobody has changed a source meanwhile
            _write(file, Hashes(found.get_hash(), kernel.hash, kernel.adj.kernel_dim))
        return found

    def scanned(module: Any, parsed: Any) -> None:
        if not skipped:  # which functions a module calls matters to those who define these anew, and nobody does
            scan(module, parsed)

    with codegen._codegen_lock:  # under which Warp hashes
        context.ModuleHasher, context.Module._find_references = hashes, scanned
        try:
            yield
        finally:
            context.ModuleHasher, context.Module._find_references = hasher, scan


class Hashes(NamedTuple):
    """What is kept of a kernel."""

    module: bytes
    kernel: bytes
    dimensions: int  # of a launch


class _Known:
    """What Warp asks of a `ModuleHasher`, which also leaves with a kernel what its launches need."""

    def __init__(self, kernel: Any, hashes: Hashes, options: dict[str, Any]) -> None:
        from warp._src import codegen

        self._hash, kernel.hash = hashes.module, hashes.kernel
        kernel.grid_stride = codegen.resolve_grid_stride(kernel.options, options.get("default_grid_stride", False))
        kernel.adj.kernel_dim, kernel.adj.tid_extent_limit_candidate = hashes.dimensions, codegen._TID_MAX_EXTENT
        self.kernel_hashes = WeakKeyDictionary({kernel: kernel.hash})
        self.unique_kernels = {kernel.hash: kernel}

    def get_hash(self) -> bytes:
        return self._hash

    def get_unique_kernels(self) -> Any:
        return self.unique_kernels.values()


def _file(key: str, *asked: Any) -> Path | None:
    """Where the hashes of a kernel are kept; None if it is not known what it is made of."""
    digest = hashlib.sha256(f"{key} {wp.config.version} {FOLDER}\n".encode())
    try:
        for part in asked:
            digest.update(f"{_in_words(part)}\n".encode())
        for name in sorted(_sources(FOLDER)):
            data = Path(name).read_bytes()
            digest.update(f"{name} {len(data)}\n".encode() + data)
    except (_Unknown, OSError):
        return None
    return Path(wp.config.kernel_cache_dir) / f"warpmuscle_{key}_{digest.hexdigest()[:32]}.json"


def _sources(folder: Path) -> Iterator[str]:
    for place, _, names in os.walk(folder):
        yield from (os.path.join(place, name) for name in names if name.endswith(".py"))


def _in_words(value: Any) -> str:
    """A value such that equal words mean equal code; raises _Unknown if that cannot be said."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return repr(value)
    if isinstance(value, (tuple, list)):
        return f"{_name(type(value))}({', '.join(map(_in_words, value))})"
    if isinstance(value, _struct()):
        return f"{value.key} {value.hash.hex()}"
    if isinstance(value, type):
        return _name(value)
    if isinstance(value, wp.Function):
        value = value.__dict__.get("func")  # which parses nothing
    value = getattr(value, "__wrapped__", value)
    if isinstance(value, FunctionType):
        cells = [_of_cell(cell) for cell in value.__closure__ or ()]
        return f"{_name(value)}[{', '.join(cells)}]"
    raise _Unknown


def _struct() -> Any:
    from warp._src.codegen import Struct

    return Struct


def _of_cell(cell: Any) -> str:
    try:
        return _in_words(cell.cell_contents)
    except ValueError:  # empty
        return "nothing"


def _name(value: Any) -> str:
    """The whole name of a function or a class of this package, of Python, or of Warp."""
    if value.__module__.partition(".")[0] not in ("builtins", "warp") and not value.__module__.startswith(__package__):
        raise _Unknown
    return f"{value.__module__}.{value.__qualname__}"


def _read(file: Path) -> Hashes | None:
    """What is kept of a kernel; None if there is nothing, or nothing that can be used."""
    try:
        kept = json.loads(file.read_bytes())
        found = Hashes(bytes.fromhex(kept["module"]), bytes.fromhex(kept["kernel"]), int(kept["dimensions"]))
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return found if len(found.module) == len(found.kernel) == BYTES and 1 <= found.dimensions <= 4 else None


def _write(file: Path, hashes: Hashes) -> None:
    """Keep hashes for later processes, if the folder takes them."""
    beside = file.with_suffix(f".{os.getpid()}")
    words = {"module": hashes.module.hex(), "kernel": hashes.kernel.hex(), "dimensions": hashes.dimensions}
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        beside.write_text(json.dumps(words))
        beside.replace(file)
