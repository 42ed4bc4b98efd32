"""Tables of Vicon Nexus, written here as it writes them: markers and EMG of one trial in one file."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import SignalError
from warpmuscle.markers.files import read_markers
from warpmuscle.synergy.recordings import read_signals

EMG = np.random.default_rng(0).normal(size=(40, 2))
PLACES = 1000.0 + 10.0 * np.arange(24.0).reshape(4, 6)  # mm


def exported(path: Path, mark: str = ",", bom: str = "") -> Path:
    """Ten samples a frame of two channels of EMG, whose device has one name, then two markers at 100 Hz."""
    lines = ["Devices", "1000", ",,Trigno - Voltage,", "Frame,Sub Frame,BIC,TRI", ",,V,V"]
    lines += [f"{k // 10 + 1},{k % 10},{a!r},{b!r}" for k, (a, b) in enumerate(EMG.tolist())]
    lines += ["", "Trajectories", "100", ",,Anna:RSHO,,,Anna:RELB,,", "Frame,Sub Frame,X,Y,Z,X,Y,Z",
              ",,mm,mm,mm,mm,mm,mm"]  # fmt: skip
    rows = [",".join(["" if k == 1 and c > 2 else repr(x) for c, x in enumerate(row)])
            for k, row in enumerate(PLACES.tolist())]  # fmt: skip
    lines += [f"{k + 1},0,{row}" for k, row in enumerate(rows)]
    text = "\n".join(lines)
    if mark == ";":
        text = text.replace(",", ";").replace(".", ",")
    path.write_text(bom + text.replace(",", mark) + "\n" if mark == "\t" else bom + text + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_emg_has_the_rate_of_its_block(tmp_path: Path, mark: str):
    found = read_signals(exported(tmp_path / "trial.csv", mark, "\ufeff"))
    assert (found.names, found.rate) == (("BIC", "TRI"), 1000.0)
    np.testing.assert_allclose(found.values, EMG, rtol=1e-12)
    assert read_signals(tmp_path / "trial.csv", ["TRI"]).names == ("TRI",)


def test_markers_are_in_metres_without_the_subjects_name_and_may_be_lost(tmp_path: Path):
    found = read_markers(exported(tmp_path / "trial.csv"))
    assert found.names == ("RSHO", "RELB")
    np.testing.assert_allclose(found.time, [0.0, 0.01, 0.02, 0.03])
    expected = PLACES.reshape(4, 2, 3) / 1000.0
    expected[1, 1] = np.nan
    np.testing.assert_allclose(found.position, expected)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("Trajectories", "Joints", "has no block 'Trajectories', but Devices, Joints"),
        ("1010.0", "x", "trial.csv:.*'x' is not a number"),
        ("X,Y,Z,X,Y,Z", "X,Y,Q,X,Y,Q", "no markers"),
        ("mm,mm,mm,mm", "furlong,mm,mm,mm", "units of positions"),
        ("Frame,Sub Frame,X", "Frame,X", "must begin with `Frame`"),
        ("\n100\n", "\nfast\n", "'fast' is no rate"),
    ],
)
def test_tables_that_are_otherwise_are_refused_in_a_line(tmp_path: Path, old: str, new: str, says: str):
    path = exported(tmp_path / "trial.csv")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(SignalError, match=says):
        read_markers(path)
