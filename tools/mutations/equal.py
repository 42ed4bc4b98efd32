"""Lines whose changes change no result, for reasons that no rule can tell."""

EQUAL: dict[tuple[str, str], str] = {
    ("kernels/simbicon.py", "work.torque[0] = wp.vec3(0.0, 0.0, 0.0)"):
        "the root has no joint: nothing reads its torque, and recordings leave it out",
    ("kernels/wrap_torus.py", "if not moved:"):
        "first bound of an iteration's step: another way to the same root",
    ("kernels/wrap_torus.py", "reach = wp.min(reach, size)"):
        "first bound of an iteration's step: another way to the same root",
}  # fmt: skip
