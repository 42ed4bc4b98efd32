"""Modules of users that have names of before."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from muscle_arm import leg
from warpmuscle import scene
from warpmuscle.kernels import structs
from warpmuscle.kernels.control import control
from warpmuscle.kernels.force import forces
from warpmuscle.simulation.rollout import Rollout

MODULE = """import warp as wp
from warpmuscle.kernels.structs import Model, State, Work
@wp.func
def height(instance: int, model: Model, state: State, work: Work) -> float:
    return work.center[0][1]
"""


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        (structs, "Work", "Scratch"),
        (structs, "WorkRef", "ScratchRef"),
        (structs, "Term", "Contribution"),
        (structs, "Motion", "PrescribedMotion"),
        (forces, "Force", "ForceKind"),
        (control, "Controller", "ControllerKind"),
        (scene, "State", "MachineState"),
    ],
)
def test_what_has_another_name_is_found_by_its_old_one_with_a_warning(module: ModuleType, old: str, new: str):
    with pytest.warns(DeprecationWarning, match=f"{old} is called {new} now"):
        assert getattr(module, old) is getattr(module, new)


def test_other_names_are_not_there():
    with pytest.raises(AttributeError, match="no attribute 'Wrok'"):
        _ = structs.Wrok


def test_a_term_with_the_old_name_is_summed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "older_parts.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path))
    arm = leg(duration=0.01)
    arm.objective.custom = {"older_parts:height": 1.0}
    with pytest.warns(DeprecationWarning, match="is called Scratch now"):
        rollout = Rollout(arm, 1, "cpu", trust=True)
    rollout.run()
    height = rollout.terms()["older_parts:height"][0] / arm.duration
    assert np.isclose(height, 1.0, atol=0.5)
    assert height > 0.0
