"""Many result files that differ in their numbers only, each in a tenth of the time that HDF5 takes to lay one out.

A file without numbers is laid out once for all results of the same texts and shapes; of each result a copy of its bytes
gets the numbers. So the bytes depend on nothing but the result, and say what those of `result.image` do. What is
compressed in them, motions, is so on several threads: HDF5 would do it on one.
"""

from __future__ import annotations

import itertools
import zlib
from collections import OrderedDict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.machine import cores
from warpmuscle.results.motions import TEXTS
from warpmuscle.results.recorded_quantities import QUANTITIES, has_place
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import COLUMNS, Best, Evaluations, History, Result
from warpmuscle.results.result import image

KEPT = 32  # files without numbers, those used last
MOST_THREADS = 16  # that compress
MAY_BE_INFINITE = ("evaluations/terms", "history/sigma", "searches/")  # or no numbers
_PARAMETERS = ("min", "max", "step", "value")
_HISTORY = ("generation", "search", "best", "median", "spread", "sigma", "asks_crc32", "stage")


class _Blank(NamedTuple):
    """A file without numbers."""

    content: bytes
    places: dict[str, int]  # of datasets whose numbers lie in the file as they are: the byte of their first
    packed: dict[str, _Packing]  # how the chunks of others are packed


class _Packing(NamedTuple):
    """How a dataset is compressed: bytes of the same place in all numbers of a chunk together, then deflated."""

    chunk: tuple[int, ...]
    level: int

    def chunks(self, array: NDArray[Any]) -> list[tuple[tuple[int, ...], bytes]]:
        """The chunks of an array as they lie in the file, each with where it begins; beyond the array are zeros."""
        found = []
        for begin in itertools.product(*map(range, [0] * array.ndim, array.shape, self.chunk)):
            part = array[tuple(slice(at, at + size) for at, size in zip(begin, self.chunk, strict=True))]
            if part.shape != self.chunk:
                whole = np.zeros(self.chunk, array.dtype)
                whole[tuple(map(slice, part.shape))] = part
                part = whole
            shuffled = np.ascontiguousarray(part).view(np.uint8).reshape(-1, array.dtype.itemsize).T
            found.append((begin, zlib.compress(shuffled.tobytes(), self.level)))
        return found


class Stamps:
    """Makes result files, and keeps what those of one kind have in common."""

    def __init__(self) -> None:
        self._blanks: OrderedDict[Any, _Blank] = OrderedDict()
        self._threads = ThreadPoolExecutor(min(cores(), MOST_THREADS))

    def image(self, result: Result) -> bytes:
        """The bytes of a result file; raises ResultError as `result.write`."""
        if not _is_plain(result):
            return image(result)
        numbers = dict(_numbers(result))
        if any(not np.isfinite(array).all() for path, array in numbers.items() if not path.startswith(MAY_BE_INFINITE)):
            return image(result)  # which says what is wrong
        key = (_texts(result), tuple((path, array.shape, array.dtype.str) for path, array in numbers.items()))
        blank = self._blanks.pop(key, None)
        if blank is None:
            blank = _blank(image(_without_numbers(result)), numbers)
        self._blanks[key] = blank  # the last ones used come last
        while len(self._blanks) > KEPT:
            self._blanks.popitem(last=False)
        return self._stamped(blank, result, numbers)

    def _stamped(self, blank: _Blank, result: Result, numbers: dict[str, NDArray[Any]]) -> bytes:
        """A file without numbers with those of a result."""
        whole = h5py.h5s.ALL
        names = list(blank.packed)
        packed = self._threads.map(lambda name: blank.packed[name].chunks(numbers[name]), names)
        with _opened(blank.content) as file:
            for path, array in numbers.items():
                if array.size and path not in blank.places and path not in blank.packed:
                    h5py.h5d.open(file, path.encode()).write(whole, whole, np.ascontiguousarray(array))
            for path, chunks in zip(names, packed, strict=True):
                dataset = h5py.h5d.open(file, path.encode())
                for begin, raw in chunks:
                    dataset.write_direct_chunk(begin, raw)
            text = np.array(result.scene, dtype=h5py.string_dtype())
            h5py.h5d.open(file, b"scene").write(whole, whole, text, mtype=h5py.h5t.py_create(text.dtype))
            h5py.h5a.open(h5py.h5g.open(file, b"/"), b"seed").write(np.array(result.seed, dtype=np.int64))
            h5py.h5f.flush(file)
            content = bytearray(file.get_file_image())
        for path, place in blank.places.items():
            raw = numbers[path].tobytes()
            content[place : place + len(raw)] = raw
        return bytes(content)


def _blank(content: bytes, numbers: dict[str, NDArray[Any]]) -> _Blank:
    places: dict[str, int] = {}
    packed: dict[str, _Packing] = {}
    with _opened(content) as file:
        for path, array in numbers.items():
            dataset = h5py.h5d.open(file, path.encode())
            if not array.size or dataset.dtype != array.dtype:
                continue
            layout = dataset.get_create_plist()
            if layout.get_layout() == h5py.h5d.CONTIGUOUS:
                places[path] = dataset.get_offset()
                continue
            filters = [layout.get_filter(number) for number in range(layout.get_nfilters())]
            if [one[0] for one in filters] == [h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE]:
                packed[path] = _Packing(layout.get_chunk(), filters[1][2][0])
    return _Blank(content, places, packed)


@contextmanager
def _opened(content: bytes) -> Iterator[Any]:
    """A file in memory that begins as a copy of these bytes."""
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_fapl_core(backing_store=False)
    access.set_file_image(content)
    file = h5py.h5f.open(b"image", h5py.h5f.ACC_RDWR, access)
    try:
        yield file
    finally:
        file.close()


def _is_plain(result: Result) -> bool:
    """Whether a result is that of a search without stages, with one motion."""
    return (
        result.evaluations is not None and result.best is not None and result.searched is not None
        and not result.searched.stages and len(result.replays) == 1
        and result.learned is None and result.fit is None
    )  # fmt: skip


def _texts(result: Result) -> Any:
    """All that is not a number, and what the layout depends on besides."""
    assert result.searched is not None
    assert result.evaluations is not None
    parameters, recording = result.parameters, result.replays[0]
    return (
        result.device, result.command, tuple(sorted(result.versions.items())), tuple(sorted(result.machine.items())),
        parameters.name, parameters.unit, parameters.scale, result.evaluations.term_names, result.searched.options,
        result.searched.ended, result.searched.elsewhere, result.searched.evaluated, result.replay_names,
        tuple(getattr(recording, name) for name in TEXTS), recording.missing,
        tuple((term, tuple(own)) for term, own in result.parts.items()),
    )  # fmt: skip


def _numbers(result: Result) -> Iterator[tuple[str, NDArray[Any]]]:
    """All arrays of a file by their places."""
    evaluations, best, searched = result.evaluations, result.best, result.searched
    assert evaluations is not None
    assert best is not None
    assert searched is not None
    for name in _PARAMETERS:
        yield f"parameters/{name}", np.asarray(getattr(result.parameters, name))
    for name in COLUMNS:
        yield f"evaluations/{name}", np.asarray(getattr(evaluations, name))
    if evaluations.term_names:
        yield "evaluations/terms", np.asarray(evaluations.terms)
    yield "best/params", np.asarray(best.params)
    yield "best/cost", np.asarray(best.cost, dtype=np.float64)
    yield "best/index", np.asarray(best.index, dtype=np.int64)
    for term, parts in result.parts.items():
        yield f"best/parts/{term}/value", np.array(list(parts.values()))
    for name in _HISTORY:
        yield f"history/{name}", np.asarray(getattr(searched.history, name))
    for number, state in enumerate(searched.states):
        for name in sorted(state):
            if not np.isinf(state[name]).any():  # such are left out
                yield f"searches/{number}/{name}", np.asarray(state[name])
    for name in _quantities(result.replays[0]):
        yield f"replay/0/{name}", np.asarray(result.replays[0][name])


def _quantities(recording: Recording) -> list[str]:
    texts, gone = {name: getattr(recording, name) for name in TEXTS}, recording.missing
    return [name for name in QUANTITIES if name not in gone and has_place(name, texts)]


def _without_numbers(result: Result) -> Result:
    """The same with zeros in place of all numbers, and without its scene."""
    evaluations, best, searched = result.evaluations, result.best, result.searched
    assert evaluations is not None
    assert best is not None
    assert searched is not None

    def empty(arrays: dict[str, Any]) -> dict[str, Any]:
        return {name: np.zeros_like(array) for name, array in arrays.items()}

    parameters = replace(
        result.parameters, **empty({name: np.asarray(getattr(result.parameters, name)) for name in _PARAMETERS})
    )
    columns = empty({name: getattr(evaluations, name) for name in (*COLUMNS, "terms")})
    states = tuple(
        {name: array if np.isinf(array).any() else np.zeros_like(array) for name, array in state.items()}
        for state in searched.states
    )
    history = History(**empty({name: getattr(searched.history, name) for name in _HISTORY}))
    recording = result.replays[0]
    motion = replace(recording, **empty({name: recording[name] for name in _quantities(recording)}))
    return replace(
        result, scene="", seed=0, parameters=parameters,
        evaluations=Evaluations(**columns, term_names=evaluations.term_names),
        best=Best(np.zeros_like(best.params), 0.0, 0), replays=(motion,),
        searched=replace(searched, history=history, states=states),
        parts={term: dict.fromkeys(own, 0.0) for term, own in result.parts.items()},
    )  # fmt: skip
