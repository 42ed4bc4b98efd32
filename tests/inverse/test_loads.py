"""Loads from external loads' descriptions and from tables alone, and files that are damaged."""

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.inverse.loads import _contacts, read_loads

COLUMNS = [f"{start}{axis}" for start in ("right_v", "right_p", "left_v", "left_p", "right_torque_") for axis in "xyz"]


def written(folder, columns=COLUMNS, rows=None, name="grf.mot"):
    values = np.arange(1.0, 61.0).reshape(4, 15)[:, : len(columns)] if rows is None else rows
    lines = [
        "\t".join([f"{0.01 * k:g}", *(f"{x:g}" if isinstance(x, float) else str(x) for x in row)])
        for k, row in enumerate(values)
    ]
    text = (
        "grf\nversion=1\ninDegrees=no\nendheader\n" + "\t".join(["time", *columns]) + "\t\n" + "\n".join(lines) + "\n"
    )
    path = folder / name
    path.write_text(text)
    return path


def described(folder, **changes):
    words = {
        "applied_to_body": "calcn_r", "force_expressed_in_body": "ground", "point_expressed_in_body": "ground",
        "force_identifier": "right_v", "point_identifier": "right_p", "torque_identifier": "right_torque_",
        "data_source_name": "Unassigned",
    } | changes  # fmt: skip
    inner = "".join(f"<{tag}>{text}</{tag}>" for tag, text in words.items())
    path = folder / "loads.xml"
    path.write_text(
        f'<OpenSimDocument Version="40000"><ExternalLoads name="x"><objects><ExternalForce name="right">{inner}'
        "</ExternalForce></objects><datafile>somewhere\\else\\grf.mot</datafile></ExternalLoads></OpenSimDocument>"
    )
    return path


def test_a_description_says_which_columns_act_on_which_body(tmp_path):
    written(tmp_path)
    found = read_loads(described(tmp_path))
    (plate,) = found.plates
    assert (plate.name, plate.body) == ("right", "calcn_r")
    assert plate.force[0].tolist() == [1.0, 2.0, 3.0]
    assert plate.point[0].tolist() == [4.0, 5.0, 6.0]
    assert plate.moment[0].tolist() == [13.0, 14.0, 15.0]


def test_a_table_alone_has_its_plates_by_the_names_of_columns(tmp_path):
    found = read_loads(written(tmp_path))
    assert [(plate.name, plate.body) for plate in found.plates] == [("right_", None), ("left_", None)]
    assert found.plates[1].force[0].tolist() == [7.0, 8.0, 9.0]
    assert not found.plates[1].moment.any()


def test_a_force_that_is_switched_off_is_left_out(tmp_path):
    written(tmp_path)
    with pytest.raises(Error, match="describes no force that is applied"):
        read_loads(described(tmp_path, appliesForce="false"))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"force_identifier": "nowhere_v"}, "no column 'nowhere_vx'"),
        ({"force_expressed_in_body": "tibia_r"}, "only forces in ground axes"),
        ({"applied_to_body": ""}, "names no <applied_to_body>"),
        ({"force_identifier": "", "torque_identifier": ""}, "neither"),
        ({"isDisabled": "perhaps"}, "true or false"),
    ],
)
def test_a_damaged_description_is_refused_in_a_line(tmp_path, changes, words):
    written(tmp_path)
    with pytest.raises(Error, match=words) as error:
        read_loads(described(tmp_path, **changes))
    assert "\n" not in str(error.value)


def test_a_description_without_its_table_is_refused(tmp_path):
    with pytest.raises(Error, match="no such file"):
        read_loads(described(tmp_path))


@pytest.mark.parametrize(
    ("cell", "words"), [("nan", "not a finite number"), ("word", "not a number"), ("inf", "not a finite number")]
)
def test_gaps_in_a_table_are_refused_with_their_line(tmp_path, cell, words):
    rows = [[float(k) for k in range(15)] for _ in range(4)]
    rows[2][3] = cell
    with pytest.raises(Error, match=words) as error:
        read_loads(written(tmp_path, rows=rows))
    assert ":8:" in str(error.value)


def test_columns_that_are_no_plate_are_refused(tmp_path):
    with pytest.raises(Error, match="no columns of a force and its point"):
        read_loads(written(tmp_path, columns=[f"c{k}" for k in range(15)]))


def test_contacts_share_out_the_time_between_them():
    force = np.zeros((20, 3))
    force[2:6, 1], force[12:16, 1] = 500.0, 500.0
    assert _contacts(force) == [(0, 9), (9, 20)]
    assert _contacts(np.zeros((20, 3))) == []
