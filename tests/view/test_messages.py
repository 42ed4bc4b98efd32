"""What counts of the messages of a browser, without one."""

import math
import random
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from warpmuscle.view.messages import bounded, checked

CONTROLS = {
    "slider": SimpleNamespace(value=0.5, min=-1.0, max=2.0),
    "whole": SimpleNamespace(value=5, min=0, max=10),
    "box": SimpleNamespace(value=True),
    "menu": SimpleNamespace(value="a", options=("a", "b")),
    "off": SimpleNamespace(value=0.5, min=0.0, max=1.0, disabled=True),
}
CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1, 0, 0.5, 0], "position": [1, 2, 3], "fov": 0.7, "near": 0.01, "far": 1000,
    "image_height": 300, "image_width": 240, "look_at": [0, 0, 0], "up_direction": [0, 1, 0],
}  # fmt: skip


def sent(message: Any) -> Any:
    passed = checked(msgspec.msgpack.encode(message), CONTROLS.get)
    return None if passed is None else msgspec.msgpack.decode(passed)


def update(uuid: Any, value: Any, **more: Any) -> dict[str, Any]:
    return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value, **more}}


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        ("slider", 0.7, 0.7), ("slider", 1, 1.0), ("slider", 1e308, 2.0), ("slider", -7, -1.0), ("slider", 2**63, 2.0),
        ("slider", math.inf, None), ("slider", -math.inf, None), ("slider", math.nan, None), ("slider", "1", None),
        ("slider", True, None), ("slider", None, None), ("slider", [1.0], None), ("slider", {}, None),
        ("slider", b"1", None), ("whole", 7, 7), ("whole", 99, 10), ("box", False, False), ("box", 1, None),
        ("box", "yes", None), ("menu", "b", "b"), ("menu", "c", None), ("menu", 0, None), ("menu", "", None),
        ("off", 0.7, None), ("nothing", 0.7, None), ("", 1.0, None), (3, 1.0, None),
    ],
)  # fmt: skip
def test_a_control_takes_values_of_its_kind_within_its_bounds(name, value, taken):
    got = sent(update(name, value))
    assert got == (None if taken is None else update(name, taken))


def test_nothing_but_the_value_of_a_control_can_be_set():
    assert sent(update("slider", 1.0, removed=True)) is None
    assert sent({"type": "GuiUpdateMessage", "uuid": "slider", "updates": {"min": -1e9}}) is None
    assert sent({"type": "GuiUpdateMessage", "uuid": "slider", "updates": {}}) is None
    assert sent({**update("slider", 1.0), "excluded_self_client": 1}) is None
    for kind in (
        "ShareUrlRequest",
        "RunJavascriptMessage",
        "SceneNodeUpdateMessage",
        "FileTransferStartUpload",
        1,
        None,
    ):
        assert sent({**update("slider", 1.0), "type": kind}) is None


def test_the_camera_is_told_in_numbers():
    assert sent(CAMERA) == CAMERA
    for wrong in (
        {"fov": math.nan}, {"position": [1.0, math.inf, 0.0]}, {"position": [1.0, 2.0]}, {"far": 1e300}, {"near": "x"},
        {"wxyz": None}, {"more": 1},
    ):  # fmt: skip
        assert sent({**CAMERA, **wrong}) is None


def test_garbage_is_dropped_whatever_it_is():
    deep = b"\x91" * 60_000 + b"\xc0"
    maps = b"\x81\xa1a" * 20_000
    for raw in (
        b"",
        b"\xc1",
        "text",
        "\ud800\udfff",
        "{}",
        deep,
        maps,
        b"\xdf\xff\xff\xff\xff",
        b"\xc6\xff\xff\xff\xff",
    ):
        assert checked(raw, CONTROLS.get) is None
    chance = random.Random(3)
    whole = msgspec.msgpack.encode(update("slider", 0.7))
    for _ in range(3000):
        cut = bytearray(whole)
        for _ in range(chance.randrange(1, 5)):
            cut[chance.randrange(len(cut))] = chance.randrange(256)
        passed = checked(bytes(cut[: chance.randrange(len(cut) + 1)] if chance.random() < 0.3 else cut), CONTROLS.get)
        if passed is not None:
            value = msgspec.msgpack.decode(passed)["updates"]["value"]
            assert type(value) is type(bounded(CONTROLS[msgspec.msgpack.decode(passed)["uuid"]], value))
