"""Shipped gaits walk at the speed of the original program.

Speeds and cadences of the original: the table that comes with its recordings, 5 to 20 s.
"""

import pytest

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gait.measures import measure
from warpmuscle.simulation.rollout import Rollout

# m/s, its tolerance, and steps/min
TABLE = {
    "fwalk": (0.954, 0.05 * 0.954, 105.3),
    "bwalk": (-0.605, 0.05 * 0.605, 129.2),
    "iwalk": (0.012, 0.03, 120.0),
    "fjog": (1.494, 0.05 * 1.494, 149.8),
    "bigbird_walk": (0.942, 0.08 * 0.942, 151.2),
}
BIPED = [name for name in TABLE if name != "bigbird_walk"]


def assert_walks(name: str, **changes) -> None:
    """Ten seconds without a fall, and the speed and cadence of the last five near those of the table."""
    scene = load(name)
    scene.duration = 10.0
    for field, value in changes.items():
        setattr(scene, field, value)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    assert rollout.status()[0] == Status.COMPLETED
    gait = measure(rollout.recording(), *scene.controller.feet, start=5.0)
    speed, tolerance, cadence = TABLE[name]
    assert gait.speed_forward == pytest.approx(speed, abs=tolerance)
    assert gait.cadence == pytest.approx(cadence, rel=0.02)
    assert abs(gait.heading_drift) < 0.4  # between two phases of a step


@pytest.mark.parametrize("name", TABLE)
def test_gait_has_the_speed_and_cadence_of_the_original(name: str):
    assert_walks(name)


@pytest.mark.parametrize("name", BIPED)
def test_gait_keeps_its_speed_in_four_times_longer_steps(name: str):
    assert_walks(name, time_step=1.0 / 500.0, implicit_pd=True)


@pytest.mark.parametrize("name", ["fwalk", "bwalk", "bigbird_walk"])
def test_gait_recovers_from_small_pushes(name: str):
    scene = load(name)
    scene.duration = 5.0
    rollout = Rollout(scene, 10, "cpu")
    rollout.reset(velocity_noise=0.01, seed=1)
    rollout.run()
    assert rollout.alive == 10
