"""What the comparison with OpenSim does where OpenSim is not."""

import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import opensim_oracle  # noqa: E402


def test_what_is_missing_is_said_in_a_sentence(monkeypatch, tmp_path):
    model = tmp_path / "model.osim"
    model.write_text("<OpenSimDocument/>")
    monkeypatch.setenv("WARPMUSCLE_OPENSIM_CACHE", str(tmp_path))
    monkeypatch.setattr(opensim_oracle, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="OpenSim is not installed: pip install opensim"):
        opensim_oracle.numbers(model, 1, 1, 1)
