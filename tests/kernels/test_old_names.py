"""Modules of users that name the working set as it was called before."""

from pathlib import Path

import numpy as np
import pytest

from muscle_arm import leg
from warpmuscle.kernels import structs
from warpmuscle.simulation.rollout import Rollout

MODULE = """import warp as wp
from warpmuscle.kernels.structs import Model, State, Work
@wp.func
def height(instance: int, model: Model, state: State, work: Work) -> float:
    return work.center[0][1]
"""


@pytest.mark.parametrize(("old", "new"), [("Work", "Scratch"), ("WorkRef", "ScratchRef")])
def test_the_working_set_is_found_by_its_old_name_with_a_warning(old: str, new: str):
    with pytest.warns(DeprecationWarning, match=f"{old} is called {new} now"):
        assert getattr(structs, old) is getattr(structs, new)


def test_other_names_are_not_there():
    with pytest.raises(AttributeError, match="no attribute 'Wrok'"):
        _ = structs.Wrok


def test_a_term_with_the_old_name_is_summed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "older_parts.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    scene = leg(duration=0.01)
    scene.objective.custom = {"older_parts:height": 1.0}
    with pytest.warns(DeprecationWarning, match="is called Scratch now"):
        rollout = Rollout(scene, 1, "cpu", trust=True)
    rollout.run()
    height = rollout.terms()["older_parts:height"][0] / scene.duration
    assert np.isclose(height, 1.0, atol=0.5)
    assert height > 0.0
