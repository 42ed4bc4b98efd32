"""The commands that judge gaits, on short runs of the walk on torques: tables, files, and what becomes of a fall."""

import json
import sys
from pathlib import Path

import pytest
import warp  # noqa: F401  what is tested launches kernels

from warpmuscle.core.errors import Error

TOOLS = Path(__file__).parents[2] / "tools" / "research"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import gait_table  # noqa: E402

FALLS = "fwalk:failure.com_height=1.2"  # at once
SHORT = "fwalk:initial_state.root_position.1=1.03"


def table(capsys: pytest.CaptureFixture[str], *names: str, duration: float = 4.0, **options: object) -> list[list[str]]:
    """Cells of the table of gaits, by row."""
    given = {"noise": 0.02, "device": "cpu", "threads": 1, "output": None, "pictures": None} | options
    gait_table.main(list(names), duration, 2, **given)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_a_gait_stands_beside_people_and_the_original_and_a_fall_is_told(capsys, tmp_path):
    rows = {row[0]: row[1:] for row in table(capsys, FALLS, SHORT, output=tmp_path / "gaits.json")}
    assert rows["measure"] == ["unit", "human", "`fwalk`", "`fwalk 1.2`", "`fwalk 1.03`"]
    assert rows["upright"][2:] == ["4", "fell at 0.0", "4"]
    assert rows["upright of 2 runs of 4 s, noise 0.02 m/s"][2:4] == ["2", "0"]
    assert rows["speed"][1:] == ["1.27 to 1.46", rows["speed"][2], "", rows["speed"][4]]
    assert 0.8 < float(rows["speed"][2]) < 1.1
    assert rows["knee, maximum in swing"][1].endswith("at 72 %")
    assert " at " in rows["knee, maximum in swing"][2]
    assert "cost of transport" not in rows  # no gait here has muscles
    written = json.loads((tmp_path / "gaits.json").read_text())
    gaits = {gait["name"]: gait for gait in written["gaits"]}
    assert gaits["fwalk"]["measures"]["speed"] == pytest.approx(float(rows["speed"][2]), abs=0.01)
    assert gaits["fwalk 1.2"]["measures"] == {}
    assert "no whole gait cycle" in gaits["fwalk 1.2"]["why"]
    assert written["units"]["speed"] == "m/s"
    assert written["human"]["stance"]["value"] == "64"


def test_a_gait_on_muscles_has_a_cost_and_says_how_it_is_counted(capsys):
    gait_table.main(["walk56"], 4.0, 1, noise=0.0, device="cpu", threads=1, output=None, pictures=None)
    lines = capsys.readouterr().out.splitlines()
    rows = {row[0]: row[1:] for line in lines if line.startswith("|") for row in [line.strip("| ").split(" | ")]}
    assert rows["muscle mass"][0] == "kg"
    assert rows["muscle mass"][-1] == "25.1"
    cost, common = (float(rows[f"cost of transport{at}"][-1]) for at in ("", " at 0.25 MPa"))
    assert 4.0 < cost < 0.9 * common
    counted = "Wang 2012 with positive work, 1.51 W/kg at rest, 25.1 kg of muscle at 0.6 MPa (60.3 kg at 0.25 MPa)"
    assert f"Metabolic power of `walk56`: {counted}." in lines


def test_pictures_of_a_gait_are_written(capsys, tmp_path):
    table(capsys, "fwalk", pictures=tmp_path / "new")
    names = {"gaits.png", *(f"fwalk_{kind}.png" for kind in ("sticks", "angles", "ground_force", "feet"))}
    assert {path.name for path in (tmp_path / "new").iterdir()} == names


def test_what_misses_its_aim_is_said():
    measures = {
        "speed": 1.1,
        "target speed": 1.0,
        "error of the speed": 0.1,
        "cost of transport": 5.0,
        "knee, minimum": -3.0,
    }
    found = gait_table.misses(gait_table.Judged("a", "fell", False, 7.25, 17, False, measures), 20)
    assert found == [
        "fell at 7.2 s",
        "upright in 17 of 20 runs",
        "speed 1.10 m/s for 1 m/s",
        "cost of transport 5.0 J/(kg m) (aim: 4.5)",
        "knee, minimum -3.0 deg (aim: -1 or more)",
    ]
    measures = {"target speed": -0.6, "error of the speed": 0.02, "cost of transport": 4.0}
    assert gait_table.misses(gait_table.Judged("b", "", True, 60.0, 18, False, measures), 20) == []


@pytest.mark.parametrize("name", ["fwolk", "fwalk:duration", "fwalk:duration=x", "fwalk:durations=3"])
def test_a_scene_or_number_that_is_not_there_is_an_error_of_the_user(name: str, capsys):
    with pytest.raises(Error, match=r"dur|fwolk"):
        table(capsys, name)
