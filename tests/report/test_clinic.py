"""The page of a judged gait: what it says of a walk made by hand, and of one that is too short for a cycle."""

from dataclasses import replace

import numpy as np
import pytest

from html_page import Page
from small_result import march
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gait.muscle_effort import BHARGAVA_NET
from warpmuscle.report.clinic import FIGURES, clinic_html
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies.judge import Judgement
from warpmuscle.studies.judge_recording import judge_recording
from warpmuscle.studies.verdicts import Verdict


@pytest.fixture(scope="module")
def scene():
    free = load("walk56")
    return substitute(free, start_values(free))


@pytest.fixture(scope="module")
def judgement(scene):
    return judge_recording(march(scene.character, 1.2, 8.0, 801, len(scene.character.muscles)), scene)


def first_cells(text: str, section: str) -> list[str]:
    """What stands in the first column of a section's table."""
    part = text[text.index(f'id="{section}"') :]
    return [row.partition("</td>")[0] for row in part[: part.index("</table>")].split("<tr><td>")[1:]]


def test_the_page_has_indices_both_sides_figures_muscles_and_all_rows(judgement):
    told: list[str] = []
    text = clinic_html("a <walk>", judgement, told.append)
    Page(text)
    assert len(text.encode()) < 1_000_000
    assert "a &lt;walk&gt;" in text
    assert told == [f"drawing: {kind}" for kind in FIGURES]
    assert text.count('<img src="data:image/svg+xml;base64,') == len(FIGURES)
    assert first_cells(text, "index") == [
        "Hip flexion", "Knee flexion", "Ankle dorsiflexion", "Pelvis obliquity", "Pelvis rotation"
    ]  # fmt: skip
    assert {"step length", "stance", "maximum vertical force"} < set(first_cells(text, "sides"))
    assert "+0.0<" not in text
    assert "-0.0<" not in text
    assert first_cells(text, "muscles")[:2] == ["gluteus maximus", "hip abductors"]
    assert first_cells(text, "table1") == [one.bar.name for one in judgement.verdicts]
    assert first_cells(text, "table2") == [one.bar.name for one in judgement.further]


def test_the_page_fits_a_phone(browser, judgement, tmp_path):
    (tmp_path / "walk.html").write_text(clinic_html("a walk", judgement), encoding="utf-8")
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto((tmp_path / "walk.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    page.close()


def test_a_body_that_stays_in_its_place_is_told_so_and_its_speed_has_no_sign(scene):
    walk = march(scene.character, 0.0, 8.0, 801, len(scene.character.muscles))
    still = np.broadcast_to(np.float32([0.0, 0.0, -0.001]), walk.com_velocity.shape)
    found = judge_recording(walk.changed(com_velocity=still), scene)
    assert found.measures["speed"] == pytest.approx(-0.001, abs=1e-4)
    notes = {one.bar.name: one.note for one in found.verdicts}
    assert notes["angles outside the norms"].endswith("of a body that stays in its place")
    assert notes["stance"].endswith("this body stays in its place, as on a treadmill")
    text = clinic_html("a walk", found)
    assert ">0.00<" in text
    for zero in ("-0.00<", ">-0<", "-0.00 m/s"):
        assert zero not in text


def test_a_cost_that_is_not_judged_is_no_number_that_is_read_first(judgement):
    told = f">{BHARGAVA_NET}, J/(kg m)"
    assert told in clinic_html("a walk", judgement)
    without = [
        one if one.bar.name != BHARGAVA_NET else Verdict(one.bar, None, "torques help") for one in judgement.verdicts
    ]
    assert told not in clinic_html("a walk", replace(judgement, verdicts=without))


def test_what_impairs_a_patient_stands_on_the_page(judgement):
    patient = replace(judgement, impaired=("calf: f_max x 0.5 of lSOL, lGAS",))
    assert "Impaired: calf: f_max x 0.5 of lSOL, lGAS." in clinic_html("a patient", patient)
    assert "Impaired" not in clinic_html("a walk", judgement)


def test_a_run_is_told_its_flight_and_is_not_scored_by_people_who_walk(judgement):
    walk, run = clinic_html("a walk", judgement), clinic_html("a run", replace(judgement, running=True))
    assert ">double support, % of the cycle" in walk
    assert ">flight, % of the cycle" not in walk
    assert ">flight, % of the cycle" in run
    assert ">double support, % of the cycle" not in run
    assert "gait profile score" in first_cells(walk, "sides")
    assert "gait profile score" not in run


def test_a_motion_without_a_whole_cycle_says_so(scene):
    short = judge_recording(march(scene.character, 1.2, 0.3, 31, len(scene.character.muscles)), scene)
    text = clinic_html("short", short)
    assert "has no whole gait cycle" in text
    assert 'id="sides"' not in text
    assert 'id="index"' not in text
    assert first_cells(text, "table1") == [one.bar.name for one in short.verdicts]


def test_a_judgement_without_its_motion_cannot_be_reported():
    with pytest.raises(Error, match="holds no motion"):
        clinic_html("nothing", Judgement([], False, "", {}, []))
