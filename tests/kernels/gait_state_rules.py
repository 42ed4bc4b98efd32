"""How legs come from state to state, in plain Python."""

from collections.abc import Mapping

from warpmuscle.kernels.gait_state_structs import EARLY_STANCE, LANDING, LATE_STANCE, LIFTOFF, SWING

LIMITS = {"stance_load": 0.2, "swing_load": 0.1, "landing": 0.05, "late_stance": 0.0, "liftoff": -0.4, "least": 0.01}


def expected_state(
    now: int, ahead: float, other_ahead: float, load: float, other_load: float, limits: Mapping[str, float] = LIMITS
) -> int:
    """The transitions as SCONE's documentation lists them."""
    loaded, other_loaded = load > limits["stance_load"], other_load > limits["stance_load"]
    behind = other_loaded and ahead < other_ahead
    match now:
        case 0 if loaded:
            return LIFTOFF if behind else LATE_STANCE if ahead < limits["late_stance"] else EARLY_STANCE
        case 0:
            return LANDING if ahead > limits["landing"] else SWING
        case 1:
            return LIFTOFF if behind else LATE_STANCE if ahead < limits["late_stance"] else EARLY_STANCE
        case 2:
            return LIFTOFF if behind or ahead < limits["liftoff"] else LATE_STANCE
        case 3:
            return SWING if load <= limits["swing_load"] else LIFTOFF
        case 4 if loaded:
            return EARLY_STANCE if ahead > other_ahead else SWING
        case 4:
            return LANDING if ahead > limits["landing"] else SWING
    return EARLY_STANCE if loaded else LANDING
