"""Small numbers behind viewers: primitives, meshes, colours, packing, lanes and the clock."""

import base64
import json
import zlib

import numpy as np
import pytest

from biped import biped
from warpmuscle.core.pose import rotate
from warpmuscle.view.colors import of_activation
from warpmuscle.view.lanes import lanes
from warpmuscle.view.meshes import box, sphere, tube
from warpmuscle.view.packing import Packer, packed_json, without_comments
from warpmuscle.view.parts import parts_of, turn_from_y
from warpmuscle.view.player import Player


def test_turn_leads_from_the_y_axis_to_any_direction():
    directions = np.concatenate([np.random.default_rng(1).normal(size=(20, 3)), [[0.0, 2.0, 0.0], [0.0, -3.0, 0.0]]])
    turned = rotate(turn_from_y(directions), np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(turned, directions / np.linalg.norm(directions, axis=1, keepdims=True), atol=1e-9)


def test_capsule_is_a_cylinder_between_two_spheres_and_bones_join_joints():
    bodies = list(biped().bodies)
    parts = parts_of(biped(), bodies)
    thigh = [part for part in parts if part.body == bodies.index("lUpperleg")]
    assert sorted((part.kind, part.bone) for part in thigh) == [
        ("cylinder", False), ("cylinder", True), ("sphere", False), ("sphere", False),
    ]  # fmt: skip
    cylinder = next(part for part in thigh if part.kind == "cylinder" and not part.bone)
    np.testing.assert_allclose(cylinder.size, (0.05, 0.38, 0.05))
    assert cylinder.side == "left"
    assert next(part for part in parts if part.body == bodies.index("rFoot")).kind == "box"


@pytest.mark.parametrize(("mesh", "volume"), [(sphere(40, 60), 4.0 / 3.0 * np.pi), (box(), 1.0)])
def test_faces_look_outwards(mesh, volume: float):
    corners, faces = mesh
    a, b, c = (corners[faces[:, k].astype(int)] for k in range(3))
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(volume, rel=0.01)
    tall, lateral = tube(60)
    a, b, c = (tall[lateral[:, k].astype(int)] for k in range(3))
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(np.pi * 2.0 / 3.0, rel=0.01)  # without its lids


def test_activation_goes_from_dark_blue_to_yellow():
    blue, yellow = of_activation(np.array([0.0, 1.0]))
    assert blue[2] > 100 > blue[0]
    assert min(yellow[:2]) > 200 > yellow[2]


@pytest.mark.parametrize("bits", [8, 16])
def test_packed_arrays_come_back_within_half_a_step(bits: int):
    values = np.cumsum(np.random.default_rng(2).normal(size=(50, 3, 2)), axis=0)
    values[:, 1, 1] = 7.0
    packer = Packer()
    assert packer.add(values, bits) == 0
    entry, raw = packer.table()[0], zlib.decompress(base64.b64decode(packer.text()))
    planes = np.frombuffer(raw, dtype=np.uint8).reshape(bits // 8, 6, 50).astype(int)
    whole = np.cumsum(sum(plane << (8 * k) for k, plane in enumerate(planes)), axis=1) % 2**bits
    back = np.array(entry["low"]) + np.array(entry["width"]) * whole.T / (2**bits - 1)
    assert np.abs(back.reshape(50, 3, 2) - values).max() <= 0.51 * max(entry["width"]) / (2**bits - 1) + 1e-5


def test_json_within_a_page_cannot_end_its_element():
    text = packed_json({"title": "</script><b>"})
    assert "<" not in text
    assert json.loads(zlib.decompress(base64.b64decode(text))) == {"title": "</script><b>"}


def test_scripts_lose_their_comments_and_nothing_else():
    assert without_comments("// why\n\n  let a = 'b // c';\n    // d\n  a = 1;\n") == "let a = 'b // c';\na = 1;"


def test_bipeds_are_apart_and_about_the_middle():
    places = lanes(5)
    assert np.ptp(places[:, 0]) == pytest.approx(4 * 1.3)
    assert abs(places[:, 0].mean()) < 1e-9
    many = lanes(64)
    assert len(np.unique(many, axis=0)) == 64
    assert np.ptp(many[:, 0]) < 10.0


def test_clock_plays_loops_seeks_and_steps():
    player = Player(end=2.0, interval=0.02)
    player.advance(0.5)
    player.speed = 0.5
    player.advance(1.0)
    assert player.time == pytest.approx(1.0)
    player.step(-3)
    assert (player.time, player.playing) == (pytest.approx(0.94), False)
    player.advance(5.0)
    assert player.time == pytest.approx(0.94)
    player.seek(9.0)
    assert player.time == 2.0
    player.play(True)
    assert player.time == 0.0
    player.advance(5.0)
    assert player.time == pytest.approx(0.5)
