"""How the work of a launch is cut into pieces."""

import pytest

from warpmuscle.launching import WAVES, piece_lengths


@pytest.mark.parametrize("steps", [1, 7, 200])
@pytest.mark.parametrize("waves", [1.01, 1.3, 2.6, 10.3, 40.0])
def test_pieces_make_all_steps_and_waves_enough_to_fill_the_gaps_of_one_another(steps: int, waves: float):
    pieces = piece_lengths(steps, waves)
    assert sum(pieces) == steps
    assert min(pieces) >= 1
    assert max(pieces) - min(pieces) <= 1
    assert len(pieces) == steps or len(pieces) * waves >= WAVES > (len(pieces) - 1) * waves
