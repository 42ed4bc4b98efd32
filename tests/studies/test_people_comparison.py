"""Which rows judge beside people of another speed: those within 0.15 m/s of 1.26 m/s, as the page on gaits says."""

import pytest

from warpmuscle.gait.quality import TIMING, Measures
from warpmuscle.scene.norms import FORCE, NORMS
from warpmuscle.studies.people_comparison import of_force, of_norms
from warpmuscle.studies.verdicts import HUMPS, Finding


@pytest.mark.parametrize(("speed", "judges"), [(1.10, False), (1.12, True), (1.40, True), (1.42, False)])
def test_people_of_1_26_m_per_s_judge_who_walks_nearly_as_fast(speed: float, judges: bool):
    measures: Measures = {"speed": speed, "stance": 60.0, "angles outside the norms": 0.2}
    assert (of_norms(measures) == {}) == judges


@pytest.mark.parametrize(
    ("speed", "said"),
    [
        (-0.004, "and this body stays in its place, as on a treadmill"),
        (-0.2, "not at -0.20 m/s"),
        (0.7, "not at 0.70 m/s"),
    ],
)
def test_a_body_that_goes_nowhere_is_told_so(speed: float, said: str):
    note = of_norms({"speed": speed, "stance": 60.0, "angles outside the norms": 0.2})
    assert note["stance"].note == f"of people at their own speed, {said}"
    assert "-0.00" not in note["angles outside the norms"].note


def test_the_humps_of_the_force_are_as_far_off_as_they_are_in_half_widths():
    norm = NORMS[FORCE]
    names = ("first hump of the force", "valley of the force", "second hump of the force")
    off = dict(zip(names, (0.5, -1.0, 3.0), strict=True))
    measures: dict[str, float | None] = {
        name: norm.points[k][1] + off[name] * norm.half_width for k, name in enumerate(names, 1)
    }
    assert of_force(measures)[HUMPS] == pytest.approx(1.5)
    assert of_force(measures | {names[1]: None})[HUMPS] is None


def test_the_timing_of_muscles_names_the_three_that_are_least_like_people_of_those_that_are_known():
    timings: dict[str, float | None] = {
        "timing of vasti": 30.0, "timing of soleus": -44.0, "timing of hip flexors": None, "timing of hamstrings": 5.0,
        "timing of hip abductors": 80.0,
    }  # fmt: skip
    measures: Measures = {"stance": -90.0, TIMING: 20.0, **timings}
    assert of_norms(measures)[TIMING] == Finding(20.0, "least: soleus -44, hamstrings 5, vasti 30")
