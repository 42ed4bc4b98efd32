"""Small numbers behind viewers: packing and lanes."""

import base64
import json
import zlib

import numpy as np
import pytest

from small_result import march, walk_scene
from warpmuscle.formats.overrides import Override, overridden
from warpmuscle.view.lanes import lanes
from warpmuscle.view.packing import Packer, as_small, packed_json, without_comments
from warpmuscle.view.page import replay_html


def unpacked(packer: Packer) -> np.ndarray:
    """The only array of a packer, as `assets/unpack.js` has it."""
    entry, raw = packer.table()[0], zlib.decompress(base64.b64decode(packer.text()))
    bits, (frames, *rest) = entry["bits"], entry["shape"]
    planes = np.frombuffer(raw, dtype=np.uint8).reshape(1 if bits <= 8 else 2, -1, frames).astype(int)
    whole = np.cumsum(sum(plane << (8 * k) for k, plane in enumerate(planes)), axis=1) % 2 ** (8 * len(planes))
    back = np.array(entry["low"]) + np.array(entry["width"]) * whole.T / (2**bits - 1)
    return np.asarray(back.reshape(frames, *rest))


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_packed_arrays_come_back_within_half_a_step(bits: int):
    values = np.cumsum(np.random.default_rng(2).normal(size=(50, 3, 2)), axis=0)
    values[:, 1, 1] = 7.0
    packer = Packer()
    assert packer.add(values, bits) == 0
    width = max(packer.table()[0]["width"])
    assert np.abs(unpacked(packer) - values).max() <= 0.51 * width / (2**bits - 1) + 1e-5


@pytest.mark.parametrize(("range_", "bits", "step"), [(0.01, 8, 1e-3), (5.0, 13, 1e-3), (200.0, 16, 200.0 / 65535)])
def test_columns_of_one_step_come_back_within_half_of_it(range_: float, bits: int, step: float):
    values = np.random.default_rng(2).normal(size=(50, 3))
    values *= range_ / np.ptp(values, axis=0) * [1.0, 0.1, 0.0]
    packer = Packer()
    packer.add(values, 1e-3)
    assert packer.table()[0]["bits"] == bits
    assert np.abs(unpacked(packer) - values).max() <= 0.51 * step + 1e-6 * range_
    still = Packer()
    still.add(np.full((5000, 30), 0.3), 1e-3)
    assert len(still.text()) < 500


def test_equal_arrays_are_packed_once():
    values = np.random.default_rng(3).normal(size=(50, 3))
    packer = Packer()
    assert [packer.add(values, 12), packer.add(values.copy(), 12), packer.add(values + 1.0, 12)] == [0, 0, 1]
    assert packer.add(values, 16) == 2  # stored more finely
    assert packer.add(values.reshape(50, 1, 3), 12) == 3
    size = len(packer.text())
    packer.add(values, 12)
    assert len(packer.text()) == size


def test_bodies_that_differ_in_a_muscle_alone_have_their_bones_in_common():
    scene = walk_scene()
    muscle = f"character.muscles.{next(iter(scene.character.muscles))}"
    weak, long = (overridden(scene, [Override(f"{muscle}.{name}", {"factor": 1.2})]) for name in ("f_max", "l_opt"))
    scenes = [scene, weak, long]
    motion = march(scene.character, 1.1, frames=5, muscles=len(scene.character.muscles))
    alone = len(replay_html(motion, scene))
    assert len(replay_html([motion] * 3, scenes)) < 1.2 * alone


def test_json_within_a_page_cannot_end_its_element():
    text = packed_json({"title": "</script><b>"})
    assert "<" not in text
    assert json.loads(zlib.decompress(base64.b64decode(text))) == {"title": "</script><b>"}


def test_scripts_lose_their_comments_and_nothing_else():
    assert without_comments("// why\n\n  let a = 'b // c';\n    // d\n  a = 1;\n") == "let a = 'b // c';\na = 1;"


@pytest.mark.parametrize(
    ("largest", "frames"), [(10_000, 3000), (6_000, 1500), (1_500, 187), (1_000, 31), (10, 3000 // 128)]
)
def test_a_page_has_as_few_frames_as_it_takes_to_be_small(largest: int, frames: int):
    made = []

    def make(rate: float) -> str:
        made.append(rate)
        return "x" * (900 + int(3.0 * 60.0 * rate))  # of 60 s

    found = as_small(make, 50.0, largest)
    assert (len(found) - 900) // 3 == pytest.approx(frames, abs=1)
    assert len(made) < 11  # those that cannot be small enough are not made


def test_bipeds_are_apart_and_about_the_middle():
    places = lanes(5)
    assert np.ptp(places[:, 0]) == pytest.approx(4 * 1.3)
    assert abs(places[:, 0].mean()) < 1e-9
    many = lanes(64)
    assert len(np.unique(many, axis=0)) == 64
    assert np.ptp(many[:, 0]) < 10.0
