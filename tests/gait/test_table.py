"""Tables of gaits: what people have as it is published, and as many decimals as a unit is worth."""

import pytest

from warpmuscle.gait.table import human, shown_rows

NORM = "norm curves in SCONE Studio"
# Means and half-widths of the bands, and where in the cycle (%) the means are, as read off SCONE Studio's curves.
KEY_POINTS = {
    "hip, minimum": ("-8.3 ± 8.4", "52"),
    "hip, maximum": ("33.7 ± 8.4", "87"),
    "knee, maximum in stance": ("19.4 ± 5.3", "12"),
    "knee, maximum in swing": ("63.4 ± 5.3", "72"),
    "knee, minimum": ("3.8 ± 5.3", "97"),
    "ankle, maximum in stance": ("12.5 ± 3.9", "43"),
    "ankle, minimum at push-off": ("-19.9 ± 3.9", "64"),
    "first hump of the force": ("1.05 ± 0.06", "15"),
    "valley of the force": ("0.8 ± 0.06", "31"),
    "second hump of the force": ("1.14 ± 0.06", "49"),
    "maximum vertical force": ("1.14 ± 0.06", "49"),
}


@pytest.mark.parametrize("name", KEY_POINTS)
def test_key_points_are_those_of_the_norms(name: str):
    value, percent = KEY_POINTS[name]
    assert human(name) == (value, NORM)
    assert human(f"{name} at") == (percent, NORM)


def test_values_have_as_many_decimals_as_their_unit_is_worth():
    shown = {
        "speed": (1.23456, "1.23"), "cadence": (112.345, "112"), "stance": (62.345, "62.3"),
        "maximum vertical force": (1.23456, "1.23"), "hip moment in loading": (0.56789, "0.57"),
        "hip power, maximum": (1.23456, "1.2"), "bodies inside each other": (0.345, "0.3"),
        "time inside each other": (23.45, "23"), "likeness of the hip moment": (0.98765, "0.99"),
        "deviation of the hip": (0.12345, "0.12"), "hip, minimum": (-8.345, "-8.3"),
        "cost of transport": (3.456, "3.5"), "mean activation": (0.01234, "0.012"), "muscle mass": (12.345, "12.3"),
        "cadence from that at this speed": (1.23, "1"), "angles from Fukuchi 2018": (0.987, "0.99"),
        "travel of the centre of pressure": (78.9, "79"), "timing of soleus": (54.32, "54"),
        "slide of the stance foot": (0.345, "0.3"), "depth of the feet": (5.67, "5.7"),
    }  # fmt: skip
    rows = {row[0]: row[-1] for row in shown_rows([{name: value for name, (value, _) in shown.items()}])}
    for name in rows:
        assert rows[name] == shown[name][1], name
    assert len(rows) == len(shown)


def test_nothing_is_shown_as_less_than_nothing():
    assert shown_rows([{"step width": -0.001}])[0][-1] == "0.00"
