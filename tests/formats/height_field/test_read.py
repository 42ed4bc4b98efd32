"""Height fields from files: pictures, tables of numbers, MuJoCo models; and what is wrong with damaged ones."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.formats.height_field.grey_png import SIGNATURE, grey_values
from warpmuscle.formats.height_field.read import read_heights
from warpmuscle.scene import Scene
from warpmuscle.scene.terrain.surface import surface

RNG = np.random.default_rng(0)
SCENE = """
name = "ball"

[character]
root = "ball"

[character.bodies.ball]
mass = 1.0
inertia = [0.01, 0.01, 0.01]
shapes = [{ type = "sphere", center = [0, 0, 0], radius = 0.1 }]

[initial_state]
root_position = [0, 0.1, 0]

[failure]
com_height = 0.0

[[ground.terrain.tiles]]
type = "height_field"
file = "NAME"
size = [2.0, 4.0]
height = 0.5
"""


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def filtered(raw: np.ndarray, width: int, kinds: list[int]) -> bytes:
    """Lines of bytes after the five filters of PNG, written down from the standard one byte at a time."""
    lines, before = [], [0] * raw.shape[1]
    for row, line in enumerate(raw.tolist()):
        kind, out = kinds[row % len(kinds)], []
        for k, value in enumerate(line):
            a = line[k - width] if k >= width else 0
            b, c = before[k], before[k - width] if k >= width else 0
            p = a + b - c
            near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            out.append((value - (0, a, b, (a + b) // 2, near)[kind]) % 256)
        lines.append(bytes([kind, *out]))
        before = line
    return b"".join(lines)


def png(values: np.ndarray, bits: int = 8, colour: int = 0, kinds=(0, 1, 2, 3, 4)) -> bytes:
    """A picture of integers (rows, columns, channels)."""
    rows, columns, channels = values.shape
    raw = values.astype(">u2" if bits == 16 else np.uint8).reshape(rows, -1).view(np.uint8)
    header = struct.pack(">IIBBBBB", columns, rows, bits, colour, 0, 0, 0)
    data = zlib.compress(filtered(raw, channels * bits // 8, list(kinds)))
    return SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def packed_bits(values: np.ndarray, bits: int) -> np.ndarray:
    """Rows of integers as bytes, the first one in the highest bits, written down one at a time."""
    rows = []
    for row in values.tolist():
        text = "".join(f"{value:0{bits}b}" for value in row)
        text += "0" * (-len(text) % 8)
        rows.append([int(text[k : k + 8], 2) for k in range(0, len(text), 8)])
    return np.array(rows, np.uint8)


@pytest.mark.parametrize("interlaced", [0, 1])
@pytest.mark.parametrize(
    ("bits", "colour", "shape"),
    [(1, 0, (9, 13)), (2, 0, (3, 2)), (4, 0, (8, 8)), (8, 0, (5, 1)), (4, 3, (7, 6)), (8, 3, (2, 9))],
)
def test_few_bits_palettes_and_pictures_that_become_finer_are_read(bits: int, colour: int, shape, interlaced: int):
    """The seven passes are written from the standard's picture of 8 x 8 points, in which each has its number."""
    values, colours = RNG.integers(0, 2**bits, shape), RNG.integers(0, 256, (2**bits, 3))
    order = np.array([
        [1, 6, 4, 6, 2, 6, 4, 6], [7] * 8, [5, 6, 5, 6, 5, 6, 5, 6], [7] * 8,
        [3, 6, 4, 6, 3, 6, 4, 6], [7] * 8, [5, 6, 5, 6, 5, 6, 5, 6], [7] * 8,
    ])[np.arange(shape[0])[:, None] % 8, np.arange(shape[1]) % 8]  # fmt: skip
    data = b""
    for number in range(1, 8) if interlaced else [0]:
        chosen = order == number if interlaced else np.ones(shape, bool)
        if chosen.any():
            part = np.array([row[mask] for row, mask in zip(values, chosen, strict=True) if mask.any()])
            data += filtered(packed_bits(part, bits), 1, [0, 1, 2, 3, 4])
    header = struct.pack(">IIBBBBB", shape[1], shape[0], bits, colour, 0, 0, interlaced)
    palette = chunk(b"PLTE", colours.astype(np.uint8).tobytes()) if colour == 3 else b""
    picture = SIGNATURE + chunk(b"IHDR", header) + palette + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")
    expected = colours[values].mean(axis=2) / 255.0 if colour == 3 else values / (2**bits - 1)
    np.testing.assert_allclose(grey_values(picture, 1000), expected, atol=1e-12)


@pytest.mark.parametrize(("bits", "colour", "channels"), [(8, 0, 1), (16, 0, 1), (8, 4, 2), (8, 2, 3), (16, 6, 4)])
def test_pictures_of_all_filters_are_read_to_the_last_bit(bits: int, colour: int, channels: int):
    values = RNG.integers(0, 2**bits, (11, 7, channels))
    found = grey_values(png(values, bits, colour), 1000)
    expected = values[..., : 3 if colour & 2 else 1].mean(axis=2) / (2**bits - 1)
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_a_picture_of_another_program_is_read(tmp_path: Path):
    image = pytest.importorskip("PIL.Image")
    values = RNG.integers(0, 65536, (20, 30)).astype(np.uint16)
    image.fromarray(values).save(tmp_path / "a.png")
    np.testing.assert_allclose(grey_values((tmp_path / "a.png").read_bytes(), 1000), values / 65535.0)


def written(folder: Path, name: str, data: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def scene(folder: Path, name: str, text: str = SCENE) -> Scene:
    return toml.read(written(folder, "ball.toml", text.replace("NAME", name)))


def test_the_top_of_a_picture_is_forward_and_its_left_side_to_the_left(tmp_path: Path):
    values = np.zeros((3, 3, 1), dtype=int)
    values[0, 0] = 255  # top left
    written(tmp_path, "hill.png", png(values))
    ground = surface(scene(tmp_path, "hill.png").ground)
    assert ground.height_at(1.0, 2.0) == pytest.approx(0.5)
    assert ground.height_at(-1.0, -2.0) == ground.height_at(-1.0, 2.0) == 0.0


def test_numbers_of_tables_are_metres_times_the_height(tmp_path: Path):
    table = np.round(RNG.normal(size=(4, 5)), 3)
    np.save(tmp_path / "a.npy", table)
    written(tmp_path, "a.csv", "# m\n" + "\n".join(", ".join(map(str, row)) for row in table))
    for name in ("a.npy", "a.csv"):
        lie = surface(scene(tmp_path, name).ground).lie
        assert lie is not None
        np.testing.assert_allclose(lie.grid.heights, 0.5 * table, atol=1e-6)


def test_a_scene_keeps_its_heights_without_the_file(tmp_path: Path):
    np.save(tmp_path / "a.npy", np.eye(4))
    found = scene(tmp_path, "a.npy")
    (tmp_path / "a.npy").unlink()
    again = toml.loads(toml.dumps(found))
    assert again.ground == found.ground
    assert surface(again.ground).height_at(0.0, 0.0) == surface(found.ground).height_at(0.0, 0.0) > 0.0


HFIELD = """<mujoco><asset><hfield name="h" nrow="3" ncol="4" size="2 1.5 0.6 0.1" elevation="{}"/></asset>
<worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>"""


def test_a_height_field_of_mujoco_lies_as_mujoco_has_it(tmp_path: Path):
    mujoco = pytest.importorskip("mujoco")
    text = HFIELD.format(" ".join(map(str, RNG.uniform(1.0, 5.0, 12).round(3))))
    written(tmp_path, "h.xml", text)
    ground = surface(scene(tmp_path, "h.xml", SCENE.replace("size = [2.0, 4.0]\nheight = 0.5\n", "")).ground)
    model = mujoco.MjModel.from_xml_string(text)
    data = model.hfield_data.reshape(3, 4)
    for row in range(3):
        for column in range(4):
            forward, left = -2.0 + 4.0 * column / 3.0, -1.5 + 3.0 * row / 2.0
            assert ground.height_at(left, forward) == pytest.approx(0.6 * data[row, column], abs=1e-6)


def test_files_of_height_fields_of_mujoco_are_found_and_read_as_mujoco_does(tmp_path: Path):
    """Its own kind of file is not turned over, as pictures are; without a file or elevation it is level."""
    mujoco = pytest.importorskip("mujoco")
    text = '<mujoco><compiler {}/><asset><hfield name="h" size="2 1.5 0.6 0.1" {}/></asset></mujoco>'
    numbers = RNG.uniform(1.0, 5.0, 12).astype("<f4")
    (tmp_path / "sub").mkdir()
    written(tmp_path / "sub", "h.bin", struct.pack("<ii", 3, 4) + numbers.tobytes())
    written(tmp_path / "sub", "h.png", GOOD)
    named = ('meshdir="sub" assetdir="no"', 'file="h.bin"'), ('assetdir="sub"', 'file="h.png"')
    for folder, which in (*named, ("", 'nrow="3" ncol="4"')):
        written(tmp_path, "h.xml", text.format(folder, which))
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "h.xml"))
        found = read_heights(tmp_path / "h.xml")
        assert found.size == (3.0, 4.0)
        expected = model.hfield_data.reshape(model.hfield_nrow[0], model.hfield_ncol[0])
        np.testing.assert_allclose(found.heights.T, 0.6 * expected, atol=1e-6)


def test_of_several_fields_of_a_model_that_of_a_geom_is_taken(tmp_path: Path):
    fields = "".join(
        f'<hfield {name} nrow="2" ncol="2" size="{size} 1 0.5 0.1" elevation="0 0 0 1"/>'
        for name, size in (('name="bare"', 3), ('name="hills"', 7))
    )
    body = '<worldbody><geom type="hfield" hfield="{}"/></worldbody>'
    for named, forward in (("hills", 14.0), ("bare", 6.0), ("none", 6.0)):
        written(tmp_path, "m.xml", f"<mujoco><asset>{fields}</asset>{body.format(named)}</mujoco>")
        assert read_heights(tmp_path / "m.xml").size == (2.0, forward)
    written(tmp_path, "hills.png", GOOD)
    by_file = '<hfield name="first" nrow="2" ncol="2" size="3 1 1 1"/><hfield file="hills.png" size="7 1 1 1"/>'
    written(tmp_path, "m.xml", f"<mujoco><asset>{by_file}</asset>{body.format('hills')}</mujoco>")
    assert read_heights(tmp_path / "m.xml").size == (2.0, 14.0)


GOOD = png(RNG.integers(0, 255, (4, 4, 1)))
BAD_HEADER = struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.png", b"", "not a PNG"),
        ("a.png", GOOD[:-30], "damaged"),
        ("a.png", GOOD[:45] + b"x" + GOOD[46:], "damaged"),
        ("a.png", SIGNATURE + chunk(b"IHDR", BAD_HEADER) + chunk(b"IDAT", b"x"), "60000 x 60000 has more points"),
        ("a.png", GOOD.replace(b"IEND", b"IEND")[:8] + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 3, 0, 0, 0))
         + chunk(b"IDAT", zlib.compress(bytes(20))), "more colours than its palette"),
        ("a.png", SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 4, 2, 0, 0, 0)) + chunk(b"IDAT", b"x"),
         "no kind that PNG has"),
        ("a.png", SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 0, 0, 0, 0))
         + chunk(b"IDAT", zlib.compress(b"\0" * 10**6)), "more or fewer points"),
        ("a.npy", b"\x93NUMPY\x01\x00", "not a table of numbers"),
        ("a.npy", b"\x93NUMPY\x01\x00\x10\x00{'descr': '<f8',\n", "not a table of numbers"),
        ("a.csv", "1, 2\n3", "line 2 has 1 number"),
        ("a.csv", "1, 2\n3, x", "line 2 is not of numbers"),
        ("a.csv", "1, 2\n3, nan", "row 2, column 2 is not a finite number"),
        ("a.csv", "1, 2", "2 rows and 2 columns"),
        ("a.xml", "<mujoco>", "not valid XML"),
        ("a.xml", "<mujoco/>", "no hfield"),
        ("a.xml", '<mujoco><include file="b.xml"/></mujoco>', r"no hfield; name the file that it includes: b\.xml"),
        ("a.xml", HFIELD.format("1 2 3"), "3 elevations for a grid of 3 x 4"),
        ("a.xml", '<!DOCTYPE m [<!ENTITY a "b">]><mujoco/>', "entities"),
        ("a.xml", HFIELD.format("").replace('"3"', '"300000"'), "0 elevations for a grid of 300000 x 4"),
        ("a.xml", HFIELD.format("1").replace("elevation", "file"), "1: there is no such file"),
        ("a.jpg", b"x", "heights are read from .png"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_file_is_said_in_one_line_with_its_place(tmp_path: Path, name: str, data, words: str):
    written(tmp_path, name, data)
    with pytest.raises(SceneError, match=words) as error:
        scene(tmp_path, name)
    assert "ball.toml:20: ground.terrain.tiles.0.file: " in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path):
    with pytest.raises(SceneError, match=r"none\.png"):
        scene(tmp_path, "none.png")


def test_heights_beyond_all_mountains_are_told_of_the_file(tmp_path: Path):
    written(tmp_path, "a.csv", "0, 1e9\n0, 0")
    with pytest.raises(SceneError, match=r"tiles\.0\.file: heights must be finite, and at most 10000 m"):
        scene(tmp_path, "a.csv")


def test_what_is_no_height_field_of_mujoco_is_refused(tmp_path: Path):
    written(tmp_path, "h.xml", HFIELD.format("h.bin").replace("elevation", "file"))
    for data in (b"", b"x" * 7, struct.pack("<ii3f", 2, 3, 0, 1, 2), struct.pack("<ii", -1, -1) + bytes(4)):
        written(tmp_path, "h.bin", data)
        with pytest.raises(SceneError, match="neither a PNG picture nor MuJoCo's own"):
            scene(tmp_path, "h.xml")
    written(tmp_path, "h.bin", struct.pack("<ii4f", 2, 2, 0, 1, 2, np.inf))
    with pytest.raises(SceneError, match="not a finite number"):
        scene(tmp_path, "h.xml")


def test_complex_numbers_are_no_heights(tmp_path: Path):
    np.save(tmp_path / "a.npy", np.ones((3, 3), dtype=complex))
    with pytest.raises(SceneError, match="not a table of numbers"):
        scene(tmp_path, "a.npy")


@pytest.mark.parametrize("kind", ["object", "huge"])
def test_numpy_files_run_nothing_and_are_bounded(tmp_path: Path, kind: str):
    np.save(tmp_path / "a.npy", np.array([[print, 1]], dtype=object) if kind == "object" else np.zeros((1100, 1100)))
    with pytest.raises(SceneError, match=r"not a table|the limit `heights`"):
        scene(tmp_path, "a.npy")
    with pytest.raises(ValueError, match=r"not a table|the limit"):
        read_heights(tmp_path / "a.npy")
