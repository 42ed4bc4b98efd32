"""Set-up files of inverse kinematics, and what is wrong with damaged ones."""

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.opensim_setups import read_scale_setup, read_tasks

TASKS = """<?xml version="1.0"?>
<OpenSimDocument Version="40000"><InverseKinematicsTool name="ik"><coordinate_file>Unassigned</coordinate_file>
<time_range>0.5 1</time_range><IKTaskSet><objects>
<IKMarkerTask name="a"><apply>true</apply><weight>3</weight></IKMarkerTask>
<IKMarkerTask name="b"><apply>false</apply><weight>3</weight></IKMarkerTask>
<IKMarkerTask name="c"/>
<IKCoordinateTask name="q"><apply>true</apply><weight>2</weight><value_type>manual_value</value_type><value>0.1</value>
</IKCoordinateTask>
<IKCoordinateTask name="r"><weight>1</weight><value_type>default_value</value_type></IKCoordinateTask>
<IKCoordinateTask name="s"><weight>0</weight></IKCoordinateTask>
</objects></IKTaskSet></InverseKinematicsTool></OpenSimDocument>"""


def test_tasks_that_are_applied_are_read(tmp_path):
    (tmp_path / "ik.xml").write_text(TASKS)
    found = read_tasks(tmp_path / "ik.xml")
    assert found.markers == {"a": 3.0, "c": 1.0}
    assert {name: (task.weight, task.kind, task.value) for name, task in found.coordinates.items()} == {
        "q": (2.0, "manual_value", 0.1),
        "r": (1.0, "default_value", 0.0),
    }
    assert found.times == (0.5, 1.0)
    assert found.coordinate_file == ""


def test_a_set_of_tasks_alone_is_read(tmp_path):
    inner = TASKS[TASKS.index("<IKTaskSet>") : TASKS.index("</InverseKinematicsTool>")]
    (tmp_path / "tasks.xml").write_text(f'<OpenSimDocument Version="40000">{inner}</OpenSimDocument>')
    assert read_tasks(tmp_path / "tasks.xml").markers == {"a": 3.0, "c": 1.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("<weight>3</weight>", "<weight>-3</weight>"), r"ik\.xml:4: .*must be 0 or more"),
        (("<weight>3</weight>", "<weight>heavy</weight>"), r"ik\.xml:4: .*'heavy' is not a number"),
        (("<weight>3</weight>", "<weight>inf</weight>"), r"ik\.xml:4: .*not a finite number"),
        (('name="a"', 'name=""'), "has no name"),
        (("manual_value", "guessed"), "none of default_value"),
        (("0.5 1<", "1 0.5<"), "runs from 1 back to 0.5 s"),
        (("0.5 1<", "1<"), "needs 2 numbers, has 1"),
        (("<apply>true", "<apply>perhaps"), "is true or false, not 'perhaps'"),
        (("</IKTaskSet>", ""), "not sound XML"),
        (("IKTaskSet", "OtherSet"), "holds no <IKTaskSet>"),
    ],
)
def test_a_damaged_file_is_one_line(tmp_path, change, message):
    (tmp_path / "ik.xml").write_text(TASKS.replace(*change))
    with pytest.raises(SceneError, match=message) as error:
        read_tasks(tmp_path / "ik.xml")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "content", [b"", b"\x00\x01\x02", b"<a", b"<!DOCTYPE a><a/>", b"<ScaleTool/>", "\u00e9".encode("latin-1")]
)
def test_other_files_are_one_line(tmp_path, content):
    (tmp_path / "x.xml").write_bytes(content)
    with pytest.raises(SceneError, match=r"x\.xml"):
        read_tasks(tmp_path / "x.xml")
    if content != b"<ScaleTool/>":
        with pytest.raises(SceneError, match=r"x\.xml"):
            read_scale_setup(tmp_path / "x.xml")
    with pytest.raises(SceneError, match="no such file"):
        read_scale_setup(tmp_path / "none.xml")


def test_the_published_set_up_is_read(reference_data):
    path = reference_data / "opensim_walk" / "ik" / "walk_Setup_IK.xml"
    if not path.is_file():
        pytest.skip(f"no reference data: {path}")
    found = read_tasks(path)
    assert len(found.markers) == 31
    assert found.markers["Top.Head"] == 3.0
    assert "R.Knee.Lat" not in found.markers
