"""Outcomes: their numbers are part of the file format."""

from warpmuscle.core.status import Status
from warpmuscle.kernels import structs
from warpmuscle.scene import Failure
from warpmuscle.scene.units import declared


def test_numbers_stay_as_files_have_them():
    names = ["RUNNING", "COMPLETED", "FELL", "TURNED", "TOUCHED", "DIVERGED", "CROSSED", "COLLIDED"]
    names += ["FAILED", "STOPPED"]
    assert [status.name for status in sorted(Status)] == names
    assert [int(status) for status in sorted(Status)] == list(range(10))


def test_every_outcome_has_a_meaning_of_one_line():
    assert all(status.meaning and "\n" not in status.meaning for status in Status)


def test_kernels_use_the_same_numbers():
    assert all(getattr(structs, status.name) == status for status in Status)


def test_every_failure_has_a_limit_in_the_scene():
    failures = set(Status) - {Status.RUNNING, Status.COMPLETED}
    limits = declared(Failure, Status)
    assert set(limits.values()) == failures
    assert set(Failure.__struct_fields__) - set(limits) == {"self_collision_pairs"}
