"""Mutations of HDF5 files, of NumPy archives and of journals: their structure, and the values in them."""

from __future__ import annotations

import io
import json
import struct
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np

from fuzzing.texts import damaged, mutated
from fuzzing.values import NAMES, NUMBERS, WORDS
from warpmuscle.results.result import read, write

MAGIC = b"warpmuscle journal 1\n"
HEAD = struct.Struct("<QI")
HUGE = 2**40  # rows of a dataset that has them in its header only
LARGE = 10**7  # values, more of which are not read to be changed


def change_structure(path: Path, rng: Random, secret: Path) -> None:
    """Change what an HDF5 file consists of; `secret` is a file elsewhere that it may try to show."""
    if rng.random() < 0.15:
        path.write_bytes(damaged(path.read_bytes(), rng))
        return
    with h5py.File(path, "r+") as file:
        for _ in range(rng.choice([1, 1, 2, 3])):
            names = _names(file)
            if names:
                rng.choice(STRUCTURE)(file, rng.choice(names), rng, secret)


def change_values(path: Path, rng: Random) -> None:
    """Change numbers and texts in an HDF5 file, at the same places and of the same types."""
    with h5py.File(path, "r+") as file:
        for _ in range(rng.choice([1, 1, 2, 4])):
            names = [name for name in _names(file) if isinstance(file[name], h5py.Dataset)]
            name = rng.choice(names)
            if rng.random() < 0.2:
                _change_attribute(file[rng.choice([name, name.partition("/")[0], "/"])], rng)
            else:
                _change_dataset(file[name], rng)


def cut_motion(path: Path, frames: int) -> None:
    """Keep the first frames of the first motion of a result, as of one that diverged."""
    result = read(path)
    write(path, replace(result, replays=(result.replays[0].at(slice(frames)),)))


def change_task(path: Path, rng: Random) -> None:
    """Change the task of a policy: its text, or one of its values."""
    with h5py.File(path, "r+") as file:
        text = file["policy/task"].asstr()[()]
        if rng.random() < 0.3:
            changed = mutated(text, rng).decode(errors="replace").replace("\0", "")
        else:
            data = json.loads(text)
            for _ in range(rng.choice([1, 1, 2])):
                owner: Any = data
                name = rng.choice(list(owner))
                while isinstance(owner[name], dict) and owner[name] and rng.random() < 0.8:
                    owner = owner[name]
                    name = rng.choice(list(owner))
                owner[name] = rng.choice([*NUMBERS, *NAMES[:12], None, True, [], {}, [1e9, -1e9], [0, 0], 10**9, -1])
            changed = json.dumps(data)
        del file["policy/task"]
        file["policy/task"] = changed


def change_policy(path: Path, rng: Random, secret: Path) -> None:
    """Change the network, its names, or the scene beside it."""
    with h5py.File(path, "r+") as file:
        name = rng.choice([name for name in _names(file) if name.startswith("policy/")])
        match rng.randrange(4):
            case 0:
                key = next(key for key in ("scene", *file.attrs) if key in file or key in file.attrs)
                owner = file if key in file else file.attrs
                line = rng.choice([f"base = {str(secret)!r}", "base = '../../../etc/passwd'", "base = 'policy.h5'",
                                   "character = '/etc/passwd'"])  # fmt: skip
                text = f"{line}\nname = 'x'\n[muscle_model]\nactive_force_length = 'os:getcwd'\n"
                if key in file:
                    del file[key]
                owner[key] = text
            case _:
                rng.choice(STRUCTURE)(file, name, rng, secret)


def change_npz(path: Path, rng: Random) -> None:
    """Change a NumPy archive: arrays gone, of other shapes and types, with other values, or bytes damaged."""
    if rng.random() < 0.2:
        path.write_bytes(damaged(path.read_bytes(), rng))
        return
    with np.load(path) as content:
        arrays = {name: content[name] for name in content.files}
    change_arrays(arrays, rng)
    np.savez(path, **arrays)


def change_arrays(arrays: dict[str, Any], rng: Random) -> None:
    """Change arrays by name."""
    for _ in range(rng.choice([1, 1, 2, 3])):
        name = rng.choice(list(arrays))
        array = np.asarray(arrays[name])
        match rng.randrange(9):
            case 0:
                del arrays[name]
                if not arrays:
                    arrays["a"] = array
            case 1:
                arrays[rng.choice(["time", "phase", "x", "lHip", *arrays])] = arrays.pop(name)
            case 2:
                arrays[name] = _reshaped(array, rng)
            case 3:
                kinds = ["f4", "f2", "i4", "u1", "c8", "U8", "S3", "?", "M8[s]", "f8"]
                arrays[name] = np.resize(np.array([1]).astype(rng.choice(kinds)), array.shape)
            case _:
                arrays[name] = _with_others(array, rng)


def change_journal(content: bytes, rng: Random) -> bytes:
    """A journal with damaged bytes, or with records that are whole but hold something else."""
    if rng.random() < 0.25:
        return damaged(content, rng)
    records, end = [], len(MAGIC)
    while len(content) >= end + HEAD.size:
        length, _ = HEAD.unpack_from(content, end)
        with np.load(io.BytesIO(content[end + HEAD.size : end + HEAD.size + length])) as arrays:
            records.append(dict(arrays))
        end += HEAD.size + length
    match rng.randrange(6):
        case 0:
            rng.shuffle(records)
        case 1:
            records.append(rng.choice(records))
        case 2:
            del records[rng.randrange(len(records))]
        case _:
            change_arrays(records[-1] if rng.random() < 0.8 else rng.choice(records), rng)
    return MAGIC + b"".join(map(_record, records))


def _record(arrays: dict[str, Any]) -> bytes:
    payload = io.BytesIO()
    np.savez(payload, **arrays)
    return HEAD.pack(payload.tell(), zlib.crc32(payload.getvalue())) + payload.getvalue()


def _names(file: Any) -> list[str]:
    names: list[str] = []
    file.visit(names.append)
    return names


def _reshaped(array: Any, rng: Random) -> Any:
    shapes = [(), (0,), (1,), (array.size + 1,), (0, *array.shape[1:]), (*array.shape, 1), array.shape[::-1], (2, 2, 2)]
    shape = rng.choice([*shapes, (max(len(array) - 1, 0), *array.shape[1:]) if array.ndim else (3,)])
    if array.size == 0:
        return np.zeros(shape)
    return np.resize(array, shape)


def _with_others(array: Any, rng: Random) -> Any:
    """The array with one, some or all values replaced by extreme ones."""
    changed = array.copy()
    if array.dtype.kind in "US" or array.dtype.kind == "O":
        text = rng.choice([*NAMES, *WORDS])
        changed = array.astype(object) if array.dtype.kind == "O" else array.astype("U400")
        if changed.ndim == 0:
            return np.array(text)
        if changed.size:
            changed.flat[rng.randrange(changed.size)] = text.replace("\0", "")
        return changed
    if not changed.size:
        return changed
    which = rng.choice([1, 1, 3, changed.size])
    with np.errstate(all="ignore"):
        numbers = np.array(NUMBERS, dtype=np.float64)
        if array.dtype.kind in "iu":
            info = np.iinfo(array.dtype)
            chosen = rng.choice([0, -1, 1, 2, 1000, -1000000, info.max, info.min])
            replacement: Any = np.clip(chosen, info.min, info.max)
        elif array.dtype.kind == "f":
            replacement = numbers[rng.randrange(len(numbers))].astype(array.dtype)
        else:
            return changed
    for at in rng.sample(range(changed.size), min(which, changed.size)):
        changed.flat[at] = replacement
    return changed


def _put(file: Any, name: str, array: Any) -> None:
    """Replace a dataset, its attributes kept."""
    attributes = dict(file[name].attrs)
    del file[name]
    array = np.asarray(array)
    if array.dtype.kind in "UO":
        file.create_dataset(name, data=array.astype(object), dtype=h5py.string_dtype())
    else:
        file.create_dataset(name, data=array)
    for key, value in attributes.items():
        file[name].attrs[key] = value


def _change_dataset(dataset: Any, rng: Random) -> None:
    file, name = dataset.file, dataset.name
    array = dataset[()]
    if isinstance(array, bytes):  # a text, such as the scene
        text = mutated(array.decode(), rng).decode("utf-8", "replace").replace("\0", "")
        _put(file, name, np.array(text, dtype=object))
        return
    if np.asarray(array).dtype.kind == "O":
        array = dataset.asstr()[()]
    _put(file, name, _with_others(np.asarray(array), rng))


def _change_attribute(item: Any, rng: Random) -> None:
    names = list(item.attrs)
    if names:
        name = rng.choice(names)
        wrong = [*NUMBERS, *NAMES[:20], 10**6, np.zeros(3), np.zeros(0), True, h5py.Empty("f")]
        item.attrs[name] = rng.choice(wrong)


def _delete(file: Any, name: str, rng: Random, secret: Path) -> None:
    del file[name]


def _rename(file: Any, name: str, rng: Random, secret: Path) -> None:
    other = f"{name.rpartition('/')[0]}/{rng.choice(['7', 'x', 'cost', '-1', '1.5', ' ', chr(27)])}"
    if other not in file:
        file.move(name, other)


def _shape(file: Any, name: str, rng: Random, secret: Path) -> None:
    if isinstance(file[name], h5py.Dataset) and file[name].size < LARGE:  # an earlier change may have made it more
        _put(file, name, _reshaped(np.asarray(file[name][()]), rng))


def _type(file: Any, name: str, rng: Random, secret: Path) -> None:
    shape = file[name].shape if isinstance(file[name], h5py.Dataset) else (3,)
    kind = rng.choice(["S5", "f4", "i1", "c16", "?", "O", "V4", "u8"])
    del file[name]
    if kind == "O":
        file.create_dataset(name, shape, dtype=h5py.string_dtype())
    else:
        file.create_dataset(name, shape, dtype=kind)


def _group(file: Any, name: str, rng: Random, secret: Path) -> None:
    """A group in place of a dataset, or the other way round."""
    was_group = isinstance(file[name], h5py.Group)
    del file[name]
    if was_group:
        file[name] = 1.0
    else:
        file.create_group(name)


def _link(file: Any, name: str, rng: Random, secret: Path) -> None:
    """A link to nothing, to itself, to its parent, or into another file."""
    del file[name]
    parent = name.rpartition("/")[0] or "/"
    links: list[Any] = [
        h5py.SoftLink("/nowhere"), h5py.SoftLink(f"/{name}"), h5py.SoftLink("/"), file[parent],
        h5py.ExternalLink(secret.name, "/secret"), h5py.ExternalLink(str(secret), "/secret"),
        h5py.ExternalLink("../../nowhere.h5", "/x"),
    ]  # fmt: skip
    file[name] = rng.choice(links)


def _storage(file: Any, name: str, rng: Random, secret: Path) -> None:
    """A dataset whose values lie in another file."""
    if not isinstance(file[name], h5py.Dataset):
        return
    shape = file[name].shape
    del file[name]
    if rng.random() < 0.5:
        where = rng.choice([str(secret), secret.name, "/dev/zero", "/etc/hostname"])
        file.create_dataset(name, shape or (1,), "f8", external=[(where, 0, h5py.h5f.UNLIMITED)])
    else:
        layout = h5py.VirtualLayout((10,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "secret", (10,))
        file.create_virtual_dataset(name, layout)


def _huge(file: Any, name: str, rng: Random, secret: Path) -> None:
    """A dataset of no bytes in the file that would need all memory."""
    if not isinstance(file[name], h5py.Dataset):
        return
    inner = file[name].shape[1:]
    text = file[name].dtype.kind == "O"
    del file[name]
    rows = rng.choice([HUGE, 10**9, 3 * 10**7])
    dtype = h5py.string_dtype() if text else "f8"
    file.create_dataset(name, (rows, *inner), dtype, chunks=(1024, *inner), maxshape=(None, *inner))


def _empty(file: Any, name: str, rng: Random, secret: Path) -> None:
    del file[name]
    file[name] = h5py.Empty("f8")


def _more(file: Any, name: str, rng: Random, secret: Path) -> None:
    """Another member in a group."""
    owner = file[name] if isinstance(file[name], h5py.Group) else file[name].parent
    extra = rng.choice(["1", "2", "-1", "x", "1000000", "\x1b[31m"])
    if extra not in owner:
        owner[extra] = rng.choice([1.0, np.zeros(3), "text"])


def _attributes(file: Any, name: str, rng: Random, secret: Path) -> None:
    item = rng.choice([file, file[name], file[name.partition("/")[0]]])
    if len(item.attrs) and rng.random() < 0.4:
        del item.attrs[rng.choice(list(item.attrs))]
    else:
        _change_attribute(item, rng)


STRUCTURE: list[Callable[[Any, str, Random, Path], None]] = [
    _delete, _delete, _rename, _shape, _shape, _shape, _type, _type, _group, _link, _link, _storage, _huge, _empty,
    _more, _attributes, _attributes,
]  # fmt: skip
