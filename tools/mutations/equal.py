"""Lines whose changes change no result, for reasons that no rule can tell."""

EQUAL: dict[tuple[str, str], str] = {
    ("kernels/policy_actions.py", "error = wp.vec3(0.0)"): "every part of it that is read is written first",
    ("kernels/simbicon.py", "work.torque[0] = wp.vec3(0.0, 0.0, 0.0)"):
        "the root has no joint: nothing reads its torque, and recordings leave it out",
    ("kernels/wrap_torus.py", "if not moved:"):
        "first bound of an iteration's step: another way to the same root",
    ("kernels/wrap_torus.py", "reach = wp.min(reach, size)"):
        "first bound of an iteration's step: another way to the same root",
    ("warpmuscle/model/objective.py", "return weight if isinstance(weight, float | int | np.ndarray) else 1.0"):
        "of a free weight only counts that it is not 0",
}  # fmt: skip
