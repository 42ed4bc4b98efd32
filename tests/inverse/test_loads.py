"""Loads from external loads' descriptions and from tables alone, and files that are damaged."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from small_leg import motion, small_leg
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics
from warpmuscle.inverse.loads import _contacts, read_loads
from warpmuscle.inverse.trial import Loads, Plate

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


@pytest.mark.parametrize("moments", ["ground_moment_1_m", "ground_torque_1_", "ground_moment_1_"])
def test_moments_of_a_plate_may_be_called_so_beside_its_forces(tmp_path, moments):
    columns = [f"{start}{axis}" for start in ("ground_force_1_v", "ground_force_1_p", moments) for axis in "xyz"]
    (plate,) = read_loads(written(tmp_path, columns)).plates
    assert (plate.name, plate.moment[0].tolist()) == ("ground_force_1_", [7.0, 8.0, 9.0])


def test_a_force_without_a_point_acts_at_the_origin_of_its_body(tmp_path):
    written(tmp_path)
    (plate,) = read_loads(described(tmp_path, point_identifier="")).plates
    assert (plate.point_on, plate.point.any()) == ("calcn_r", False)


def test_a_force_that_is_switched_off_is_left_out(tmp_path):
    written(tmp_path)
    with pytest.raises(Error, match="describes no force that is applied"):
        read_loads(described(tmp_path, appliesForce="false"))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"force_identifier": "nowhere_v"}, "no column 'nowhere_vx'"),
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


def test_a_table_may_lie_in_another_folder(tmp_path):
    (tmp_path / "data").mkdir()
    path = written(tmp_path / "data")
    text = described(tmp_path).read_text()
    for told in ("data/grf.mot", "data\\grf.mot", str(path)):
        (tmp_path / "loads.xml").write_text(text.replace("somewhere\\else\\grf.mot", told))
        assert read_loads(tmp_path / "loads.xml").plates[0].force[0].tolist() == [1.0, 2.0, 3.0]


def test_forces_and_points_in_axes_of_a_body_are_turned_to_the_grounds(tmp_path):
    """The root's angles are about z, x and y of OpenSim's axes one after the other, and its shifts along them."""
    body, at = BodyModel(small_leg(tmp_path), "cpu"), motion(12)
    turn = Rotation.from_euler("ZXY", at.values[:, :3])
    random = np.random.default_rng(4)
    force, point, moment = random.normal(size=(3, 12, 3)) * [[[100.0]], [[0.3]], [[5.0]]]
    told = Plate("push", "calcn_r", force, point, moment, axes_of="pelvis", point_on="pelvis")
    turned = Plate("push", "calcn_r", turn.apply(force), at.values[:, 3:6] + turn.apply(point), turn.apply(moment))
    found, wanted = (inverse_dynamics(body, at, Loads(at.times, (one,))).values for one in (told, turned))
    assert found == pytest.approx(wanted, abs=2e-5 * np.abs(wanted).max())
    away = Plate("push", "calcn_r", force, point, moment, point_on="torso")
    with pytest.raises(ArgumentError, match="given in the axes of 'torso', which the model does not have"):
        inverse_dynamics(body, at, Loads(at.times, (away,)))
    with pytest.raises(ArgumentError, match=r"in the axes of 'pelvis', which only the `\.osim` of the model has"):
        inverse_dynamics(body.scene, at, Loads(at.times, (told,)))


def test_a_description_says_in_whose_axes_a_force_is(tmp_path):
    written(tmp_path)
    changes = {"force_expressed_in_body": "/bodyset/tibia_r", "point_expressed_in_body": "toes_r"}
    (plate,) = read_loads(described(tmp_path, **changes)).plates
    assert (plate.axes_of, plate.point_on) == ("tibia_r", "toes_r")


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
