"""NumPy archives from anyone: no Python objects, and no more than fits."""

import io
import pickle
import zipfile

import numpy as np
import pytest

from warpmuscle.core.archive import DamagedArchive, array_places, read_arrays
from warpmuscle.core.limits import LIMITS

HEADER = "{'descr': %r, 'fortran_order': False, 'shape': %r, }"


def packed(**members: bytes) -> io.BytesIO:
    """A compressed archive of these bytes."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in members.items():
            made.writestr(f"{name}.npy", content)
    file.seek(0)
    return file


def npy(kind: str, shape: tuple[int, ...], content: bytes) -> bytes:
    """A `.npy` file that says to hold an array of a kind and shape."""
    header = (HEADER % (kind, shape)).encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + content


@pytest.mark.parametrize(
    "array",
    [np.arange(12.0).reshape(3, 4), np.asfortranarray(np.arange(12).reshape(3, 4)), np.float32(3), np.zeros((0, 3)),
     np.array(["a", "größe"]), np.array([b"x"]), np.array([True]), np.arange(3, dtype=">i2")],
)  # fmt: skip
def test_arrays_come_back_as_they_were_saved(array):
    file = io.BytesIO()
    np.savez(file, a=array)
    file.seek(0)
    found = read_arrays(file)["a"]
    assert (found.dtype, found.shape) == (np.asarray(array).dtype, np.shape(array))
    np.testing.assert_array_equal(found, array)
    assert found.flags.writeable


class Harmful:
    def __reduce__(self):
        return print, ("ran",)


@pytest.mark.parametrize(
    "content",
    [
        npy("|O", (1,), pickle.dumps(Harmful())),
        npy("<f8", (10**12,), bytes(80)),
        npy("<f8", (-5,), bytes(80)),
        npy("<f8", (10**30, 10**30), b""),
        npy("<U0", (10**12,), b""),
        npy("<f8", (3,), bytes(80)),
        npy("<f8", (11,), bytes(80)),
        npy("nonsense", (1,), bytes(8)),
        npy("<f8", "((" * 2000, bytes(8)),  # type: ignore[arg-type]
        b"\x93NUMPY\x01\x00\xff\xff",
        b"\x93NUMPY\x09\x09",
        b"",
        b"text",
    ],
)
def test_array_that_is_no_numbers_is_refused(content, capsys):
    with pytest.raises(DamagedArchive, match="array 'a' cannot be read"):
        read_arrays(packed(a=content))
    assert capsys.readouterr().out == ""


def test_little_that_unpacks_to_much_is_refused_before_it_is_unpacked(monkeypatch):
    file = packed(a=npy("<f8", (10**6,), bytes(8 * 10**6)))
    assert len(file.getvalue()) < 10**5
    assert len(read_arrays(file)["a"]) == 10**6
    monkeypatch.setitem(LIMITS, "archive", LIMITS["archive"]._replace(most=10**6))
    with pytest.raises(DamagedArchive, match="bytes are more than 1000000, the limit `archive`"):
        read_arrays(file)


def test_arrays_that_are_not_wanted_are_not_read():
    good = npy("<f8", (1,), bytes(8))
    assert list(read_arrays(packed(a=good, b=b"garbage"), ["a"])) == ["a"]


@pytest.mark.parametrize(
    "content",
    [b"", b"text", b"PK\x03\x04", packed(a=b"x").getvalue()[:-10]],
    ids=["empty", "text", "signature", "cut"],  # bytes of an archive name the second it was made in
)
def test_what_is_no_archive_is_refused(content):
    with pytest.raises(DamagedArchive, match=r"not an \.npz file"):
        read_arrays(io.BytesIO(content))


def test_rows_are_where_the_places_of_arrays_say():
    arrays = {
        "cost": np.linspace(0.0, 1.0, 7),
        "params": np.arange(21.0).reshape(7, 3),
        "stage": np.arange(7, dtype="i4"),
    }
    file = io.BytesIO()
    np.savez(file, **arrays)
    content = file.getvalue()
    places = array_places(content)
    assert set(places) == set(arrays)
    for name, array in arrays.items():
        there = places[name]
        assert (there.kind, there.shape) == (array.dtype, array.shape)
        found = np.frombuffer(content, there.kind, array.size, there.offset).reshape(there.shape)
        np.testing.assert_array_equal(found, array)


@pytest.mark.parametrize("way", ["compressed", "cut", "columns first", "objects"])
def test_places_are_told_of_plain_arrays_alone(way: str):
    file = io.BytesIO()
    values = np.asfortranarray(np.ones((3, 2))) if way == "columns first" else np.ones((3, 2))
    save = np.savez_compressed if way == "compressed" else np.savez
    save(file, values=np.array([{}], dtype=object) if way == "objects" else values)
    content = file.getvalue()
    with pytest.raises(DamagedArchive, match="compressed, or damaged"):
        array_places(content[: len(content) // 2] if way == "cut" else content)
