"""What an interpreter shows of results, motions and batches is one short line, and statuses have names."""

import numpy as np
import pytest

import warpmuscle as wm
from small_result import search_result
from small_scene import muscle_scene
from warpmuscle.core.status import counted, words

RESULT = search_result()


def shown() -> dict[str, object]:
    scene = muscle_scene()
    assert RESULT.best is not None
    assert RESULT.searched is not None
    return {
        "Scene('small', 4 bodies, 3 joints, 2 muscles, 10 s)": scene,
        "Rollout('small', 3 on cpu, 0 of 10 s: 3 running)": wm.Rollout(scene, 3, "cpu"),
        "Stages('small', 2 on cpu, 0 of 10 s: 2 running)": wm.Stages(scene, 2, "cpu"),
        "MultiDeviceRollout('small', 2 on cpu, 0 of 10 s: 2 running)": wm.MultiDeviceRollout(scene, 2, ["cpu"]),
        "Recording(401 frames, 0 to 4 s, 15 bodies, 14 joints, 56 muscles)": RESULT.replays[0],
        "Recording(0 frames, 15 bodies, 14 joints, 56 muscles)": RESULT.replays[0].window(5.0),
        f"Result('walk56', seed 7 on cpu, 60 candidates, best cost {RESULT.best.cost:.6g}, 1 motion)": RESULT,
        "Evaluations(60 candidates: 9 completed, 51 running)": RESULT.evaluations,
        "History(12 generations of searches)": RESULT.searched.history,
        "Searched(2 x cma, all candidates have been evaluated)": RESULT.searched,
        f"Best(candidate {RESULT.best.index}, cost {RESULT.best.cost:.6g}, 72 parameters)": RESULT.best,
        "ParameterTable(72 parameters)": RESULT.parameters,
    }


@pytest.mark.parametrize(("text", "value"), shown().items(), ids=range(12))
def test_what_is_shown_is_one_short_line(text: str, value: object):
    assert repr(value) == text


def test_a_page_is_shown_by_its_size_and_holds_the_motion_still():
    page = wm.show(RESULT)
    assert repr(page).startswith("Page(")
    assert len(repr(page)) < 100
    assert len(page._repr_html_()) > 50_000


def test_statuses_have_names():
    batch = wm.Rollout(muscle_scene(), 2, "cpu")
    assert batch.status_names() == ("running", "running")
    assert RESULT.evaluations is not None
    assert set(RESULT.evaluations.status_names()) == {"running", "completed"}
    assert words(np.array([1, 2, 99])) == ("completed", "fell", "status 99")
    assert counted([1, 1, 2]) == "2 completed, 1 fell"
    assert wm.Status.FELL.word == "fell"
