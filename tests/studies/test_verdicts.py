"""Bars of gaits, typed here once more; docs/explanation/gaits.md has them with their sources. Verdicts by them."""

from pathlib import Path

import pytest

from warpmuscle.studies.verdicts import FURTHER_RUN, FURTHER_WALK, RUN, WALK, Bar, Verdict, ends

End = float | None
Bars = dict[str, tuple[tuple[End, End], tuple[End, End]]]  # by name: what must be, and what should

WALK_BARS: Bars = {
    "bodies inside each other": ((None, 1.0), (None, 0.3)),
    "angles outside the norms": ((None, 0.25), (None, 0.12)),
    "hip moment from people": ((None, 1.5), (None, 0.9)),
    "knee moment from people": ((None, 1.2), (None, 0.6)),
    "ankle moment from people": ((None, 0.6), (None, 0.3)),
    "hip power from people": ((None, 1.6), (None, 1)),
    "knee power from people": ((None, 1.5), (None, 0.9)),
    "ankle power from people": ((None, 1.2), (None, 0.6)),
    "knee moment in loading": ((0.15, 0.6), (0.3, 0.45)),
    "force at peaks and valley": ((None, 1.0), (None, 0.6)),
    "maximum vertical force": ((None, 1.2), (None, 1.15)),
    "ground force from that at this speed": ((None, 0.1), (None, 0.06)),
    "maximum braking force": ((0.1, 0.26), (0.14, 0.22)),
    "maximum driving force": ((0.13, 0.28), (0.17, 0.24)),
    "travel of the centre of pressure": ((65, 95), (75, 90)),
    "stance": ((59, 65), (61, 63)),
    "double support": ((18, 25), (20, 24)),
    "step width": ((0.03, 0.16), (0.05, 0.13)),
    "cadence from that at this speed": ((-10, 10), (-5, 5)),
    "sway from people": ((None, 2.0), (None, 1.0)),
    "pelvis tilt, range": ((None, 8), (None, 5)),
    "pelvis obliquity from people": ((None, 1.5), (None, 0.8)),
    "pelvis rotation from people": ((None, 1.5), (None, 0.8)),
    "trunk tilt, range": ((0.4, 7.6), (2.2, 5.8)),
    "trunk obliquity, range": ((0.5, 6.1), (1.9, 4.7)),
    "trunk rotation, range": ((1.1, 12.7), (4.0, 9.8)),
    "timing of the muscles": ((40, None), (70, None)),
    "cost of transport, Bhargava net": ((0.0, 3.6), (0.0, 3.3)),
    "cost of transport, Bhargava strict": ((0.0, 4.2), (0.0, 3.5)),
    "cost of transport, Wang": ((0.0, 5.0), (0.0, 4.5)),
    "muscle mass": ((None, 40), (None, 40)),
    "upright, disturbed": ((19, None), (20, None)),
    "impulse that half survive": ((60, None), (80, None)),
    "most economical speed": ((1.1, 1.5), (1.2, 1.4)),
    "5 degrees up against level": ((2.4, 4.0), (2.8, 3.6)),
    "loads, farthest from proportional": ((-10, 10), (-5, 5)),
}

RUN_BARS: Bars = {
    "bodies inside each other": ((None, 1.0), (None, 0.3)),
    "toe-off": ((36, 44), (39, 41)),
    "angles outside the norms": ((None, 1.5), (None, 1.0)),
    "maximum vertical force": ((None, 2.9), (None, 2.6)),
    "flight": ((1, None), (10, None)),
    "upright, disturbed": ((19, None), (20, None)),
    "impulse that half survive": ((60, None), (80, None)),
}


TRIALS: Bars = {
    "upright, all at once": ((19, None), (20, None)),
    "upright after 80 N s from the side": ((16, None), (19, None)),
    "commands met": ((19, None), (20, None)),
    "flight at 3.5 m/s": ((20, None), (30, None)),
    "maximum vertical force at 3.5 m/s": ((2.0, 2.9), (2.2, 2.6)),
    "knee in swing at 3.5 m/s": ((80, None), (95, None)),
}
FURTHER_WALK_BARS: Bars = {
    "windows in which muscles are active": ((0.75, None), (0.9, None)),
    "mean activation": ((None, None), (None, None)),
    "sway of the centre of mass": ((2.5, 5.5), (3, 5)),
    "likeness of the knee moment": ((0.8, None), (0.95, None)),
    "knee moment before push-off": ((None, 0.15), (None, 0.11)),
    "ankle moment, maximum": ((1.1, 1.6), (1.1, 1.6)),
    "ankle power, maximum": ((2.0, 3.5), (2.4, 3.0)),
    "variability of the step length": ((5, 30), (5, 30)),
    "clearance in mid-swing": ((None, None), (None, None)),
    "pelvis obliquity, range": ((None, None), (None, None)),
    "pelvis rotation, range": ((None, None), (None, None)),
    "arm swing, range": ((None, None), (None, None)),
    "gastrocnemius in swing, of stance": ((None, None), (None, None)),
    **TRIALS,
}
FURTHER_RUN_BARS: Bars = {"mean activation": ((None, None), (None, None)), **TRIALS}


@pytest.mark.parametrize(
    ("bars", "typed"),
    [(WALK, WALK_BARS), (RUN, RUN_BARS), (FURTHER_WALK, FURTHER_WALK_BARS), (FURTHER_RUN, FURTHER_RUN_BARS)],
    ids=["walk", "run", "further walk", "further run"],
)
def test_bars_are_those_of_people(bars: tuple[Bar, ...], typed: Bars):
    assert {bar.name: (bar.must, bar.goal) for bar in bars} == typed


@pytest.mark.parametrize(
    ("interval", "words"),
    [((1.0, 2.5), "1 to 2.5"), ((None, 3.0), "up to 3"), ((4.0, None), "4 or more"), ((None, None), "")],
)
def test_ends_of_ranges_in_words(interval: tuple[End, End], words: str):
    assert ends(interval) == words


def test_the_page_on_gaits_has_the_bars_of_walks():
    page = (Path(__file__).parents[2] / "docs/explanation/gaits.md").read_text()
    cells = [[cell.strip() for cell in line.split("|")] for line in page.splitlines() if line.startswith("| ")]
    rows = {row[1]: row[3:5] for row in cells if len(row) > 5}
    both = [bar for bar in WALK if bar.name in rows]
    assert len(both) > 20
    for bar in both:
        assert rows[bar.name] == [ends(bar.must), ends(bar.goal)], bar.name


@pytest.mark.parametrize(
    ("value", "reached"), [(0.5, "missed"), (1.0, "must"), (2.0, "goal"), (3.0, "goal"), (4.0, "must"), (4.1, "missed")]
)
def test_ends_of_ranges_belong_to_them(value: float, reached: str):
    assert Bar("x", "m", (1.0, 4.0), (2.0, 3.0)).reached(value) == reached


def test_what_is_impossible_does_not_count_and_what_failed_is_missed():
    bar = Bar("x", "m", (1.0, None), (2.0, None))
    assert Verdict(bar, 2.0, void=True).reached == Verdict(bar, 1.0, void=True).reached == "does not count"
    assert Verdict(bar, 0.0, void=True).reached == Verdict(bar, None, failed=True).reached == "missed"
    assert Verdict(bar, None).reached == "not measured"


def test_a_value_has_three_digits_and_rounding_is_none():
    bar = WALK[0]
    assert [Verdict(bar, value).shown for value in (None, 1.2345, -0.0, 3.9e-18, -3.9e-18, 1e-8)] == [
        "", "1.23", "0", "0", "0", "1e-08"
    ]  # fmt: skip
