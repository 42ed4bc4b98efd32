"""What the joints of a character ask of the stages that are compiled for it."""

import pytest

from warpmuscle.kernels.body.joint_motion import MotionOf, coupled_motion
from warpmuscle.kernels.body.joint_stages import SkeletonKind
from warpmuscle.kernels.structs import FIRST_OF_TABLE, FOLLOWER

OWN, FOLLOWING = MotionOf(FIRST_OF_TABLE, coupled_motion), MotionOf(FOLLOWER, coupled_motion)


@pytest.mark.parametrize(
    ("joints", "follows"), [((), False), ((OWN,), False), ((FOLLOWING,), True), ((OWN, FOLLOWING), True)]
)
def test_some_follow_where_one_does(joints: tuple, follows: bool):
    assert SkeletonKind(joints).follows is follows


@pytest.mark.parametrize(("joints", "rows", "wanted"), [((), 0, False), ((OWN,), 0, True), ((), 1, True)])
def test_joints_of_one_coordinate_and_constraints_need_room(joints: tuple, rows: int, wanted: bool):
    assert SkeletonKind(joints, constraints=rows).with_coordinates is wanted


def test_followed_coordinates_and_constraints_stay_open():
    assert SkeletonKind((), followed=3, constraints=2).open == 5
