"""What figures show of the same thing is alike: signs of angles, and scales of muscles."""

import numpy as np
import pytest

from small_result import walk_result, with_arrays
from warpmuscle.formats import load, toml
from warpmuscle.gait.cycles import flexion_signs, leg_angles
from warpmuscle.plots import plot
from warpmuscle.plots.joints import joint_curves
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view.curves import panels_of

RESULT = walk_result()
JOINTS = {"Hip flexion": "lHip", "Knee flexion": "lKnee", "Ankle dorsiflexion": "lAnkle"}


def numeric(name: str):
    scene = load(name)
    return substitute(scene, start_values(scene))


@pytest.mark.parametrize(("title", "joint"), JOINTS.items())
def test_an_angle_has_the_same_sign_beside_norms_over_time_and_in_the_browser(title: str, joint: str):
    scene, motion = toml.loads(RESULT.scene), RESULT.replays[0]
    scene = substitute(scene, start_values(scene))
    half = 0.2 * np.sin(np.linspace(0.0, 6.0, motion.frames)) + 0.1
    turned = motion.joint_orientation.copy()
    index = motion.joint_names.index(joint)
    turned[:, index] = np.stack([np.sin(half), 0.0 * half, 0.0 * half, np.cos(half)], axis=1)
    motion = with_arrays(motion, joint_orientation=turned)
    beside_norms = leg_angles(motion, scene)[title]["left"]
    over_time = joint_curves(motion, scene, joint)[0][1]
    np.testing.assert_allclose(over_time, beside_norms, atol=1e-6)
    panels = [panel for panel in panels_of(motion, scene) if panel.group == "angles"]
    lines = [line for panel in panels for line in panel.lines if line.name.startswith(joint)]
    assert any(np.allclose(line.values, beside_norms, atol=1e-6) for line in lines)


@pytest.mark.parametrize("name", ["fwalk", "walk56", "wang2012", "jog56"])
def test_every_leg_has_signs_of_flexion(name: str):
    assert sorted(flexion_signs(numeric(name)).values()) == [-1.0] * 4 + [1.0] * 2


def test_knees_of_opensim_bend_at_negative_angles():
    signs = flexion_signs(numeric("gait2392_walk"))
    assert {joint: sign for joint, sign in signs.items() if "knee" in joint} == {
        "knee_angle_r": -1.0,
        "knee_angle_l": -1.0,
    }


def test_an_arm_has_none():
    assert flexion_signs(numeric("throw")) == {}


def test_muscles_of_a_joint_share_their_scale():
    figure = plot(RESULT, "control")
    limits = {axes.get_ylim() for axes in figure.axes[2:]}
    assert len(figure.axes) > 3
    assert len(limits) == 1


def test_moment_arms_of_an_ankle_are_positive_for_what_lifts_the_foot():
    figure = plot(RESULT, "moment_arms", joints=["lAnkle"], muscles=["lTA", "lSOL"])
    angle = next(axes for axes in figure.axes if axes.get_title(loc="left") == "lAnkle, angle 1")
    shin, calf = (next(line for line in angle.get_lines() if line.get_color() == text.get_color()).get_ydata().mean()
                  for name in ("lTA", "lSOL") for text in angle.texts if text.get_text() == name)  # fmt: skip
    assert shin > 0.0 > calf
