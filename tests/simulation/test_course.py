"""Commands that change in the course of a run: what the controller is told, what the body does, and what is refused."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene import Command
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

COURSE = [(0.1, 0.0), (0.4, 0.3)]  # s, rad


def turning(over=COURSE):
    """The walk that is told to turn."""
    scene = msgspec.structs.replace(load("fwalk"), time_step=0.001, duration=0.6, implicit_pd=True)
    scene.controller.desired_heading = Free(0.0, per={"heading": 1.0})
    scene.commands = {"heading": Command(reference=0.0, min=-1.0, max=1.0, over=over)}
    check_scene(scene)
    return scene


def test_a_command_is_straight_between_its_knots():
    one = Command(reference=0.0, min=-1.0, max=1.0, over=COURSE)
    np.testing.assert_allclose([one.at(t) for t in (0.0, 0.1, 0.25, 0.4, 9.0)], [0.0, 0.0, 0.15, 0.3, 0.3])
    assert one.asked == 0.0
    assert Command(reference=0.2, min=-1.0, max=1.0).at(3.0) == 0.2


def test_a_run_follows_its_course_and_so_does_the_next_one():
    rollout, told = Rollout(turning(), 1, "cpu", threads=1), []
    for end in (0.05, 0.25, 0.6):
        rollout.run(end - rollout.steps_done * 0.001)
        told.append(float(rollout.numeric.controller.desired_heading))
    assert told[0] == 0.0
    assert told[1] == pytest.approx(0.15, abs=0.021)  # told every 0.02 s
    assert told[2] == pytest.approx(0.3)
    turned = rollout.state.coordinates.numpy().copy()
    rollout.reset()
    assert float(rollout.numeric.controller.desired_heading) == 0.0
    rollout.run()
    np.testing.assert_array_equal(rollout.state.coordinates.numpy(), turned)
    straight = Rollout(turning([]), 1, "cpu", threads=1)
    straight.run()
    q, p = (one.numpy()[0] for one in (rollout.state.coordinates, straight.state.coordinates))
    assert 2.0 * np.arctan2(q[4], q[6]) > 2.0 * np.arctan2(p[4], p[6]) + 0.05


def test_who_commands_it_leaves_its_course():
    rollout = Rollout(turning(), 1, "cpu", threads=1)
    rollout.set_commands({"heading": -0.2})
    rollout.run()
    assert float(rollout.numeric.controller.desired_heading) == -0.2


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ([(0.0, 0.0), (0.0, 0.1)], "times must increase"),
        ([(-1.0, 0.0)], "times must increase"),
        ([(0.0, 2.0)], "2 is outside -1 to 1"),
        ([(0.0, float("nan"))], "outside"),
    ],
)
def test_a_course_is_in_order_and_within_its_range(over, words):
    with pytest.raises(SceneError, match=words):
        turning(over)


def test_a_value_and_a_course_do_not_go_together():
    scene = turning()
    scene.commands["heading"].value = 0.1
    with pytest.raises(SceneError, match="either `value` or `over`"):
        check_scene(scene)
