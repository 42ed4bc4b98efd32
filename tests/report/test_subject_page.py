"""The page of a subject: limits, cycles by plates, norms and EMG beside the curves; and names that are not trusted."""

import re

import numpy as np
import pytest

from small_leg import loads, motion, small_leg
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.output import Trial
from warpmuscle.inverse.steps import run_steps
from warpmuscle.inverse.trial import Coordinates
from warpmuscle.report.gait_cycles import Cycle, RecordedTrial, cycles_of, over_cycle, side_of
from warpmuscle.report.images import data_uri
from warpmuscle.report.subject_figures import Curve, Panel, activation_panels, angle_panels, draw_panels
from warpmuscle.report.subject_page import subject_html

pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


@pytest.fixture(scope="module")
def page(body) -> str:
    at = motion(30)
    emg = Emg(("gastrocnemius",), at.times, np.full((30, 1), 0.3))
    options = ActivationOptions(reserve=5.0)
    found = run_steps(
        body, ("id", "so", "jr"), ["walk <b>one</b>"], [at], [loads(at.times)], emg=[emg], options=options
    )
    return subject_html(body, found, [loads(at.times)], [emg], [("filter", "none")])


def test_residuals_stand_beside_their_limits(page):
    assert "residual force at the root" in page
    row = re.search(r"residual moment at the root</td><td class=\"n\">([\d.e+]+)</td><td class=\"n\">([\d.e+]+)", page)
    assert row is not None
    force = 250.0  # N, about the greatest of the plate; the centre of mass is less than 1.1 m high
    assert float(row[2]) < 0.01 * force * 1.1
    assert "beyond" in page  # a leg by itself does not carry the pelvis


def test_92_muscles_over_five_strides_stay_below_a_megabyte(body):
    strides, percent = 5, np.linspace(0.0, 1.0, 101)
    panels = [
        Panel(
            f"muscle {k}",
            "N",
            [Curve(0, "", percent, k * np.sin(9.0 * percent + stride)) for stride in range(strides)],
        )
        for k in range(92)
    ]
    figure = data_uri(draw_panels("Forces of muscles", panels, [walking(np.zeros(50), np.linspace(0.0, 1.0, 50))]))
    assert len(figure) < 300_000  # of three such figures


def test_names_are_text(page):
    assert "<b>one</b>" not in page
    assert "walk &lt;b&gt;one&lt;/b&gt;" in page


def test_there_is_a_figure_of_each_step(page):
    titles = re.findall(r'alt="([^"]+)"', page)
    assert titles == [
        "Angles",
        "Moments",
        "Activations by static optimisation",
        "Forces of muscles",
        "Forces in joints",
    ]


def walking(force: np.ndarray, times: np.ndarray) -> RecordedTrial:
    vertical = np.zeros((len(times), 1, 3))
    vertical[:, 0, 1] = force
    on = BodyLoads([3], vertical, 0.0 * vertical, 0.0 * vertical)
    values = np.stack([-0.5 + 0.0 * times, np.sin(times)], axis=1)
    found = Trial("walk", Coordinates(("knee_angle_r", "pelvis_tilt"), times, values))
    return RecordedTrial(found, times, on, ("right",), {"soleus_r": (times, 0.0 * times)})


def test_a_cycle_is_from_a_contact_to_the_next():
    times = np.arange(0.0, 3.0, 0.01)
    trial = walking(np.where(np.mod(times - 0.305, 1.1) < 0.7, 700.0, 0.0), times)
    cycles = cycles_of(trial)
    assert [cycle.side for cycle in cycles] == ["right"] * 2
    assert [cycle.begin for cycle in cycles] == pytest.approx([0.31, 1.41], abs=0.011)
    assert cycles[0].end == pytest.approx(cycles[1].begin)


def test_values_over_a_cycle_that_they_do_not_reach_over_are_none():
    times = np.linspace(0.0, 1.0, 11)
    assert over_cycle(times, times, Cycle("left", 0.2, 0.9)) == pytest.approx(np.linspace(0.2, 0.9, 101))
    assert over_cycle(times, times, Cycle("left", 0.2, 1.5)) is None


def test_a_knee_that_bends_backwards_is_drawn_as_flexion():
    times = np.arange(0.0, 3.0, 0.01)
    knee, tilt = angle_panels([walking(0.0 * times, times)])
    assert (knee.sign, knee.norm) == (-1.0, "Knee flexion")
    assert knee.curves[0].side == "right"
    assert knee.curves[0].values == pytest.approx(-28.648, abs=1e-3)
    assert (tilt.sign, tilt.norm, tilt.curves[0].side) == (1.0, "", "")
    assert activation_panels([walking(0.0 * times, times)]) == []


@pytest.mark.parametrize(
    ("name", "side"), [("calcn_r", "right"), ("l_foot", "left"), ("torso", ""), ("rightHeel", "right")]
)
def test_sides_are_known_by_names(name, side):
    assert side_of(name) == side
