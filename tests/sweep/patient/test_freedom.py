"""What a search for a patient's walk may change: curves of excitation for each leg's muscles, and nearer ends."""

from pathlib import Path

import pytest

import small_scone
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.formats.overrides import Override, overridden
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.sweep.patient.freedom import STANDS, feed_forward, within_reach

STRIDE = 1.2


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    folder: Path = tmp_path_factory.mktemp("scone")
    return load(small_scone.write(folder), ignored=[])


def changed(scene: Scene, changes: dict) -> Scene:
    return overridden(scene, [Override(key, value) for key, value in changes.items()])


def test_each_muscle_of_a_leg_gets_a_curve_over_stance_and_one_over_swing(scene: Scene):
    found = changed(scene, feed_forward(scene, 0.4, STRIDE))
    assert found.gait_states is not None
    patterns = found.gait_states.patterns
    assert {(one.muscle, one.side) for one in patterns.values()} == {
        ("calf_l", "left"), ("seat_l", "left"), ("calf_r", "right"), ("seat_r", "right"),
    }  # fmt: skip
    stance, swing = patterns["calf_l_stance"], patterns["calf_l_swing"]
    assert sum(stance.intervals) == pytest.approx(STANDS * STRIDE, abs=1e-3)
    assert sum(stance.intervals) + sum(swing.intervals) == pytest.approx(STRIDE, abs=1e-3)
    assert set(stance.during) | set(swing.during) == {"early_stance", "late_stance", "liftoff", "swing", "landing"}
    more = [one for one in free_parameters(found) if one.name not in {own.name for own in free_parameters(scene)}]
    assert len(more) == 4 * (6 + 4)
    assert {(one.value, one.min, one.max) for one in more} == {(0.0, -0.4, 0.4)}
    assert feed_forward(found, 0.4, STRIDE) == {}  # a walk that has been matched before keeps its curves


def test_curves_are_of_controllers_by_states_of_gait():
    with pytest.raises(Error, match=r"\[gait_states\]"):
        feed_forward(load("fwalk"), 0.4, STRIDE)


def test_ends_come_nearer_but_nothing_is_fixed(scene: Scene):
    own = {one.name: one for one in free_parameters(scene)}
    near = {one.name: one for one in free_parameters(changed(scene, within_reach(scene, 0.5)))}
    assert list(near) == list(own)
    gain = next(name for name, one in own.items() if one.value == pytest.approx(1.2) and one.max == 10.0)
    assert (near[gain].min, near[gain].max) == pytest.approx((0.2, 2.2))  # a twentieth of the interval is more than 0.6
    wide = {one.name: one for one in free_parameters(changed(scene, within_reach(scene, 3.0)))}
    assert (wide[gain].min, wide[gain].max) == pytest.approx((-2.4, 4.8))
    for name, one in near.items():
        assert own[name].min <= one.min < one.max <= own[name].max
        assert one.min <= one.value == own[name].value <= one.max
