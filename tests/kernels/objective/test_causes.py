"""Numbers of what ended an instance: one of its own for each part, from which the part can be read again."""

from itertools import product

from warpmuscle.kernels.objective.causes import (
    CONDITION,
    EFFORT,
    ENTRY,
    EXCITATION,
    FORCE,
    GIVEN_EXCITATION,
    GIVEN_TORQUE,
    KINDS,
    TERM,
    cause_of,
)

PARTS = (TERM, FORCE, EFFORT, EXCITATION, GIVEN_TORQUE, GIVEN_EXCITATION, CONDITION)


def test_every_part_of_every_sort_and_entry_has_a_number_of_its_own_that_says_what_it_is():
    found = {}
    for part, kind, entry in product(PARTS, (0, 1, 2, 7, KINDS - 1), (0, 1, 91)):
        number = cause_of(part, kind) + entry * ENTRY
        assert (number % 8, number // 8 % 256, number // 2048) == (part, kind, entry)
        found[number] = (part, kind, entry)
    assert len(found) == 7 * 5 * 3
    assert 0 not in found  # which is no cause at all


def test_parts_beyond_the_room_for_numbers_count_as_the_last_one():
    assert cause_of(FORCE, 256) == cause_of(FORCE, 100000) == cause_of(FORCE, 255) == 2 + 8 * 255
