"""What counts of the messages of a page, and what controls take of it, without a browser."""

import json
import math
import random
from typing import Any

import pytest

from warpmuscle.core.errors import ArgumentError
from warpmuscle.view.controls import Button, Choice, Control, Slider, Toggle, for_page, use
from warpmuscle.view.messages import LARGEST, read_message, read_push


def controls(got: list[Any]) -> dict[str, Control]:
    return {
        "slider": Slider("gain", -1.0, 2.0, 0.5, got.append, unit="N m"),
        "box": Toggle("on", True, got.append),
        "menu": Choice("way", ["a", "b"], "a", got.append),
        "button": Button("Push", got.append),
    }


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        ("slider", 0.7, 0.7), ("slider", 1, 1.0), ("slider", 1e308, 2.0), ("slider", -7, -1.0), ("slider", 2**63, 2.0),
        ("slider", math.inf, 2.0), ("slider", -math.inf, -1.0), ("slider", math.nan, None), ("slider", "1", None),
        ("slider", True, None), ("slider", None, None), ("slider", [1.0], None), ("slider", {}, None),
        ("box", False, False), ("box", 1, None), ("box", "yes", None), ("menu", "b", "b"), ("menu", "c", None),
        ("menu", 0, None), ("menu", "", None), ("button", True, True), ("button", False, None), ("button", 1.0, None),
    ],
)  # fmt: skip
def test_a_control_takes_values_of_its_kind_within_its_bounds(name, value, taken):
    got: list[Any] = []
    control = controls(got)[name]
    before = control.value
    assert use(control, value) == taken
    assert got == ([] if taken is None else [taken])
    assert control.value == (before if taken is None or name == "button" else taken)


def test_sliders_need_bounds_and_begin_within_them():
    assert Slider("a", 0.0, 1.0, 7.0).value == 1.0
    for low, high in ((1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (0.0, math.inf)):
        with pytest.raises(ArgumentError, match="two bounds"):
            Slider("a", low, high, 0.0)


def test_the_page_is_told_of_controls_in_json_whatever_their_names_hold():
    names = controls([])
    found = json.loads(json.dumps(for_page([*names.values(), Slider("\ud800", 0.0, 1.0, 0.0)])))
    assert [one["kind"] for one in found] == ["slider", "toggle", "choice", "button", "slider"]
    assert (found[0]["min"], found[0]["max"], found[0]["value"], found[0]["unit"]) == (-1.0, 2.0, 0.5, "N m")
    assert found[2]["options"] == ["a", "b"]
    assert found[4]["name"] == "?"


def test_messages_name_a_control_that_there_is_and_one_plain_value():
    assert read_message('{"control": 1, "value": 0.5}', 2).value == 0.5
    for raw in (
        '{"control": 2, "value": 0.5}', '{"control": -1, "value": 0.5}', '{"control": 0.5, "value": 1}',
        '{"control": 0}',
        '{"control": 0, "value": null}', '{"control": 0, "value": [1]}', '{"control": 0, "value": {"a": 1}}',
        '{"control": 0, "value": 1, "more": 2}', '{"control": "0", "value": 1}', '{"value": 1}', "[]", "0", "", "text",
        '{"control": 0, "value": NaN}', '{"control": 0, "value": Infinity}', '{"control": 0, "value": 1e999}',
        json.dumps({"control": 0, "value": "x" * 2000}), "\ud800", b"\xff\xfe", b"\x00" * 50,
        "[" * (LARGEST - 1), '{"a":' * 600,
    ):  # fmt: skip
        assert read_message(raw, 2) is None, raw


def test_garbage_is_dropped_whatever_it_is():
    chance = random.Random(3)
    whole = b'{"control": 1, "value": 0.7}'
    for _ in range(3000):
        cut = bytearray(whole)
        for _ in range(chance.randrange(1, 5)):
            cut[chance.randrange(len(cut))] = chance.randrange(256)
        message = read_message(bytes(cut[: chance.randrange(len(cut) + 1)] if chance.random() < 0.3 else cut), 2)
        assert message is None or (message.control in (0, 1) and isinstance(message.value, bool | int | float | str))


def test_a_push_is_three_numbers_and_nothing_else():
    assert read_push('{"push": [1, -2.5, 0]}').push == (1.0, -2.5, 0.0)
    for raw in (
        '{"push": [1, 2]}', '{"push": [1, 2, 3, 4]}', '{"push": [1, 2, NaN]}', '{"push": [1, 2, 1e999]}',
        '{"push": [1e300, 0, 0]}', '{"push": "1"}', '{"push": [1, 2, 3], "control": 0}', "[" * 4000, b"\xff", "",
    ):  # fmt: skip
        assert read_push(raw) is None, raw
