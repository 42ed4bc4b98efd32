"""Work and heat on slopes from changes of three powers, against a walk whose work is known."""

import json
import math
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools" / "research"))

from slope_work import NET, POSITIVE, WORK, change_of, changes  # noqa: E402


def test_work_and_heat_come_back_out_of_the_powers_that_they_make():
    shortening, lengthening, heat = 12.0, 30.0, -4.0
    found = change_of(
        heat + shortening, heat + shortening - lengthening, shortening / 0.25 + lengthening / 1.2, gravity=23.0
    )
    assert found[:3] == pytest.approx((shortening, lengthening, heat))
    assert found.elsewhere == pytest.approx(12.0 - 30.0 + 23.0)


def test_gravity_gives_its_part_of_the_power_of_the_level_walk(tmp_path: Path):
    common = {"study": "a", "speed_m_s": 1.3, "added_mass_kg": 0, "leg_length_m": 0.9}
    records = [
        {**common, "identifier": "level", "slope_pct": 0, "metabolic_power_nd": 0.14},
        {**common, "identifier": "down", "slope_pct": -8, "metabolic_power_nd": 0.09},
    ]
    (tmp_path / "a.json").write_text(json.dumps(records))
    rows = [f'down,a,downhill,"{name}",-36,{value},0,0,20' for name, value in ((POSITIVE, 1), (NET, -9), (WORK, 0))]
    head = "condition,study,kind,quantity,measured (%),predicted (%),5 % (%),95 % (%),seeds"
    (tmp_path / "a.csv").write_text("\n".join([head, *rows]))
    found = changes(tmp_path / "a.csv", tmp_path / "a.json")["down"]
    per_mass = 9.81 * math.sin(math.atan(0.08)) * 1.3  # W/kg
    assert found.gravity == pytest.approx(100.0 * per_mass / (0.14 * 9.81**1.5 * math.sqrt(0.9)))
    assert found.lengthening == pytest.approx(10.0)
