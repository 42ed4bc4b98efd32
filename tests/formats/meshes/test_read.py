"""Triangles of a box are the same from every format; what is damaged or hostile is told in a line."""

import base64
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.formats.meshes.read import read_mesh

CORNERS = np.array([[x, y, z] for x in (0.0, 0.2) for y in (0.0, 0.3) for z in (0.0, 0.5)])
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = QUADS[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
VOLUME = 0.2 * 0.3 * 0.5


def vtp(form: str, compressed: bool = False, header: str = "UInt32", order: str = "LittleEndian") -> bytes:
    """The box as VTK writes it: arrays as `ascii`, `binary`, `appended raw` or `appended base64`."""
    sign, word = (">" if order == "BigEndian" else "<"), ("Q" if header == "UInt64" else "I")
    appended = b""

    def packed(values: np.ndarray) -> bytes | tuple[bytes, bytes]:
        data = values.astype(values.dtype.newbyteorder(sign)).tobytes()
        if not compressed:
            return struct.pack(sign + word, len(data)), data
        blocks = [data[:100], data[100:]] if len(data) > 100 else [data]
        small = [zlib.compress(block) for block in blocks]
        last = len(blocks[-1]) if len(blocks) > 1 else 0
        head = struct.pack(f"{sign}{3 + len(small)}{word}", len(small), len(blocks[0]), last, *map(len, small))
        return head, b"".join(small)

    def array(name: str, values: np.ndarray, more: str = "") -> bytes:
        nonlocal appended
        kind = {"f": "Float32", "i": "Int64"}[values.dtype.kind]
        start = f'<DataArray type="{kind}" Name="{name}" {more}'
        if form == "ascii":
            return f'{start} format="ascii">{" ".join(map(str, values.ravel()))}</DataArray>'.encode()
        head, data = packed(values)
        together = base64.b64encode(head) + base64.b64encode(data) if compressed else base64.b64encode(head + data)
        if form == "binary":
            return f'{start} format="binary">\n'.encode() + together + b"\n</DataArray>"
        offset = len(appended)
        appended += head + data if form == "appended raw" else together
        return f'{start} format="appended" offset="{offset}"/>'.encode()

    ends = 4 * np.arange(1, 7)
    body = b"<Points>" + array("Points", CORNERS.astype(np.float32), 'NumberOfComponents="3"') + b"</Points><Polys>"
    body += array("connectivity", QUADS.ravel()) + array("offsets", ends) + b"</Polys>"
    more = ' compressor="vtkZLibDataCompressor"' if compressed else ""
    head = f'<?xml version="1.0"?><VTKFile type="PolyData" byte_order="{order}" header_type="{header}"{more}>'
    piece = f'<PolyData><Piece NumberOfPoints="8" NumberOfPolys="6">{body.decode()}</Piece></PolyData>'
    tail = (
        f'<AppendedData encoding="{form.split()[-1]}">_'.encode() + appended + b"</AppendedData>" if appended else b""
    )
    return (head + piece).encode() + tail + b"</VTKFile>"


def binary_stl() -> bytes:
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *CORNERS[triangle].ravel().astype(np.float32), 0) for triangle in TRIANGLES
    )
    return b"solid as bytes".ljust(80) + struct.pack("<I", len(TRIANGLES)) + facets


def text_stl() -> bytes:
    facets = (
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[t]) + "endloop"
        for t in TRIANGLES
    )
    return ("solid box\n" + "\nendfacet\n".join(facets) + "\nendfacet\nendsolid\n").encode()


def obj() -> bytes:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    faces = "".join("f " + " ".join(f"{k + 1}//1" for k in quad) + "\n" for quad in QUADS[:5])
    last = "f " + " ".join(str(k - 8) for k in QUADS[5])  # from the last corner backwards
    return f"# a box\nmtllib none.mtl\n{corners}vn 0 0 1\n{faces}{last}\n".encode()


BOXES = {
    "ascii.vtp": vtp("ascii"), "binary.vtp": vtp("binary"), "compressed.vtp": vtp("binary", True),
    "appended.vtp": vtp("appended base64"), "raw.vtp": vtp("appended raw"),
    "raw_compressed.vtp": vtp("appended raw", True, "UInt64"), "appended_compressed.vtp": vtp("appended base64", True),
    "big.vtp": vtp("binary", False, "UInt64", "BigEndian"), "bytes.stl": binary_stl(), "text.STL": text_stl(),
    "box.obj": obj(),
}  # fmt: skip


def written(folder: Path, name: str, data: bytes) -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", BOXES)
def test_a_box_is_the_same_from_every_format(tmp_path, name: str):
    corners, faces = read_mesh(written(tmp_path, name, BOXES[name]))
    assert (corners.shape, faces.shape) == ((8, 3), (12, 3))
    assert sorted(map(tuple, corners.round(5))) == sorted(map(tuple, CORNERS.round(5)))
    a, b, c = (corners[faces[:, k]] for k in range(3))
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(VOLUME, rel=1e-5)  # closed, and outside is outside


@pytest.mark.parametrize("name", BOXES)
def test_any_part_of_a_file_and_any_changed_byte_gives_triangles_or_a_line(tmp_path, name: str):
    data, random = BOXES[name], np.random.default_rng(0)
    cuts = [data[: int(k)] for k in random.integers(0, len(data), 40)]
    changed = []
    for place in random.integers(0, len(data), 160):
        one = bytearray(data)
        one[place] = int(random.integers(256))
        changed.append(bytes(one))
    for number, damaged in enumerate([*cuts, *changed]):
        try:
            corners, faces = read_mesh(written(tmp_path, f"{number}{Path(name).suffix}", damaged))
        except Error as error:
            lines = str(error).splitlines()
        else:
            lines = ["sound" if np.isfinite(corners).all() and faces.max() < len(corners) else "not sound"]
        assert len(lines) == 1, damaged
        assert lines[0] != "not sound"


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.vtp", b"", "not sound XML"),
        ("a.vtp", b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "document type"),
        ("a.vtp", b"<a>" * 100, "nested too deeply"),
        ("a.vtp", b'<VTKFile type="UnstructuredGrid"/>', "type PolyData"),
        ("a.vtp", b'<VTKFile type="PolyData"/>', "no triangles"),
        ("a.vtp", vtp("ascii").replace(b"0.2", b"nan"), "no finite place"),
        ("a.vtp", vtp("ascii").replace(b"0.2", b"x"), "not a number"),
        ("a.vtp", vtp("binary").replace(b'header_type="UInt32"', b'header_type="UInt64"'), "ends before its numbers"),
        ("a.vtp", vtp("ascii").replace(b">0 1 3 2", b">9 1 3 2"), "names a corner that does not exist"),
        ("a.vtp", vtp("binary", True).replace(b"vtkZLib", b"vtkLZMA"), "vtkZLibDataCompressor is known"),
        ("a.stl", b"GIF89a" + bytes(100), "no triangles in it"),
        ("a.stl", b"GIF89a" + bytes(74) + b"\xff\xff\xff\xff" + bytes(100), "ends before its 4294967295 triangles"),
        ("a.stl", b"solid\nvertex 0 0 0\nvertex 1 0 0\n", "not have three corners"),
        ("a.obj", b"v 0 0\n", "line 1: a corner has three numbers"),
        ("a.obj", b"v 0 0 0\nf 1 2 x\n", "line 2: a face names its corners"),
        ("a.obj", b"v 0 0 0\nf 1 1 99999999999999999999\n", "line 2"),
        ("a.ply", b"ply\n", ".vtp, .stl, .obj"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path, name: str, data: bytes, message: str):
    with pytest.raises(Error, match=r"a\.\w+: ") as caught:
        read_mesh(written(tmp_path, name, data))
    assert message in str(caught.value)


def test_a_bomb_of_zlib_is_not_unpacked(tmp_path):
    bomb = zlib.compress(bytes(1 << 24))
    head = struct.pack("<12I", 9, 1 << 24, 0, *[len(bomb)] * 9)
    text = base64.b64encode(head) + base64.b64encode(bomb * 9)
    data = vtp("binary", True)
    begin = data.index(b'format="binary">') + len(b'format="binary">')
    with pytest.raises(Error, match="limit `mesh`"):
        read_mesh(written(tmp_path, "bomb.vtp", data[:begin] + text + data[data.index(b"</DataArray>") :]))


def test_a_pipe_and_a_folder_are_no_meshes(tmp_path):
    (tmp_path / "a.vtp").mkdir()
    with pytest.raises(Error, match=r"a\.vtp"):
        read_mesh(tmp_path / "a.vtp")
    with pytest.raises(Error, match=r"b\.vtp"):
        read_mesh(tmp_path / "b.vtp")
