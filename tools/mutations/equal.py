"""Lines whose changes change no result, for reasons that no rule can tell; and single changes of lines."""

EQUAL: dict[tuple[str, str], str] = {
    ("warpmuscle/kernels/learning/policy_actions.py", "error = wp.vec3(0.0)"):
        "every part of it that is read is written first",
    ("warpmuscle/kernels/control/simbicon.py", "work.torque[0] = wp.vec3(0.0, 0.0, 0.0)"):
        "the root has no joint: nothing reads its torque, and recordings leave it out",
    ("warpmuscle/model/objective.py", "return weight if isinstance(weight, float | int | np.ndarray) else 1.0"):
        "of a free weight only counts that it is not 0",
    ("warpmuscle/model/polynomials.py", "before, joints, axes = [0], [0], [0]"):
        "the monomial without factors is 1: nothing reads what it would be made of",
    ("warpmuscle/kernels/program/newton.py",
     "return bracket[1] > wp.float64(0.0) and bracket[1] - bracket[0] <= wp.float64(1.0e-6) * bracket[1]"):
        "a tolerance, at which a bracket is small enough",
    ("warpmuscle/kernels/path/wrap_mujoco.py", "near = nearest_on_segment(a, b)"):
        "the nearest point of a segment is the same from either end",
    ("warpmuscle/kernels/step_parts.py", "return 0 if self.muscles is None else self.muscles.paths.monomials"):
        "a place in the working set that nothing reads where there are no muscles",
    ("warpmuscle/kernels/inverse/marker_fit.py", "newton = 0.0"):
        "which step is tried after one that went wrong, not the fit that steps end at",
    ("warpmuscle/studies/muscle_table.py", "start_warp()"):
        "whatever uses Warp next would start it, with its banner",
    ("warpmuscle/kernels/path/route.py", "SETTLED = 5.0e-4  # m, by which the length then changes no more"):
        "a tolerance",
    ("warpmuscle/model/routes.py", "ANY_AXIS = 0  # of surfaces round both sides of which a path may go: none is read"):
        "its comment says it",
    ("warpmuscle/studies/robustness.py", "_RESAMPLES = 400"):
        "of how many draws a range is made, which is the same range for more of them",
    ("warpmuscle/kernels/body/followed.py", "right = wp.float32(0.0)"):
        "of an unknown whose coordinate is prescribed, which moves nothing: its moments are none",
    ("warpmuscle/kernels/inverse/marker_fit.py", "least = wp.float32(0.0)"):
        "nothing is compared with it before the first step has set it",
    ("warpmuscle/kernels/inverse/static_optimization_steps.py",
     "EXACT = 5.0e-4  # of the slope at the start of a step, that may be left"):
        "a tolerance, at which a search along a step ends",
    ("warpmuscle/model/bodies.py",
     '"stiffness": rows([0.0 if joint is None else joint.limit_stiffness for joint in joints]),'):
        "its number is of the root, which has no limits",
    ("warpmuscle/model/bodies.py",
     '"damping": rows([0.0 if joint is None else joint.limit_damping for joint in joints]),'):
        "its number is of the root, which has no limits",
    ("warpmuscle/model/forces.py", "other: int = 0"):
        "of a force on one body alone, of which nothing reads it",
    ("warpmuscle/kernels/program/lane_program.py", "count = wp.int32(0)"):
        "after how many steps it gives up, which it does when they lead nowhere",
    ("warpmuscle/kernels/path/wrap_sphere.py", "normal = wp.cross(a, b)"):
        "its sign says which of the two tangents of each end is called the first one; all four are tried",
    ("warpmuscle/kernels/inverse/static_optimization_steps.py", "scale[i] = reserve * reserve"):
        "a scale of the unknowns of a convex problem, not its solution",
    ("warpmuscle/model/muscles.py", "stiffness: list[Any] = [0.0]"):
        "of the root, which no joint drives",
    ("warpmuscle/kernels/program/lane_program.py", "count += 1"):
        "of steps, after so many of which it gives up, which it does when they lead nowhere",
    ("warpmuscle/kernels/program/lane_program.py", "size = wp.abs(work.needed[i])"):
        "the scale of a tolerance: by how much of it a balance may be missed",
    ("warpmuscle/model/controllers/simbicon.py",
     'columns = {"phase": rows(knots.phase or [0.0]), "value": rows(knots.value or [0.0])}'):
        "a knot of no curve, which nothing reads",
    ("warpmuscle/kernels/inverse/static_optimization.py",
     "BALANCED = 2.0e-5  # of what a coordinate's muscles can make, (sum B^2 + D^2)^1/2, that the balance may miss"):
        "a tolerance, at which Newton's method ends",
    ("warpmuscle/kernels/path/route_walk.py", "reached = wp.vec3(0.0)"):
        "on either way it is set anew before it is read",
    ("warpmuscle/model/parts.py",
     "return rows_of_all, max((one.part.declaration.memory for one in remembering), default=0)"):
        "the length of no rows",
}  # fmt: skip

EQUAL_CHANGES: dict[tuple[str, str, str], str] = {  # by what stands there after the change
    ("warpmuscle/kernels/objective/failure.py", "gone = work.center[0] - state.passed[instance]",
     "(state.passed[instance] - work.center[0])"): "only the squares of its components are used",
    ("warpmuscle/kernels/objective/failure.py",
     "if limits.leg_crossing > 0.0 and has_crossed(feet_apart(model, work), limits.leg_crossing):",
     "limits.leg_crossing, feet_apart(model, work)"): "a >= -b where b >= -a, to the bit; neither for NaN",
    ("warpmuscle/kernels/path/wrap_sphere.py", "if out[axis] * float(side) < 0.0:", "out[axis] / float(side)"):
        "side is 1 or -1 there, and x / 1 is x * 1, x / -1 is x * -1, to the bit",
    ("warpmuscle/kernels/path/ellipsoid_arc.py", "x = wp.where(k == 2, 0.0, wp.where(k < 2, -near, near))", "k <= 2"):
        "they differ for k = 2 alone, for which the outer choice takes 0",
    ("warpmuscle/model/paths.py", "p.segment_points = to_device(table.segments or [(0, 0)], int, device)", "1"):
        "stands there where there are no segments, by whose numbers alone the array is read",
    ("warpmuscle/kernels/memory/scratch.py", "w.frame = integers_at(memory, second + 5, CONTROL, n)",
     "(second + 5 + 5)"): "a place that is free while a controller needs it",
    ("warpmuscle/kernels/control/simbicon.py", "work.frame[i] = 0", "pass"):
        "kinematics has left floats there in this step, and only the integer 1, which would be one of 1e-45, counts",
    ("warpmuscle/gait/joint_moments.py",
     "return float(np.mean([np.abs(curve - mean).mean() for curve in curves]) / deviation)", "(mean - curve)"):
        "only its absolute value is used",
    ("warpmuscle/kernels/body/composite_bodies.py",
     "body, work.position[body] - work.position[parent], a, b, c, wp.vec3(0.0), wp.vec3(0.0), work", "1.0"):
        "bias forces, of which the kernel of the mass matrix reads none",
    ("warpmuscle/kernels/inverse/emg_driven.py", "row = at(model.muscles.row, 0, m)", "1"):
        "the model is one person's, with one row for all instances: the last row is the first one",
    ("warpmuscle/kernels/inverse/emg_driven.py", "if is_cable(0, m, model):", "1"): "the same",
    ("warpmuscle/kernels/inverse/emg_driven.py",
     "force[c, f, m] = ligament_force(0, m, known.length[f, m], known.speed[f, m], row, model)", "1"): "the same",
    ("warpmuscle/kernels/inverse/emg_driven.py", "of_muscle = curves_of(0, m, model)", "1"): "the same",
    ("warpmuscle/kernels/path/wrap_sphere.py", "middle = a + b", "(a + b + b)"):
        "both tangent points of an end lie the same way along it, so that only the other end counts, by its sign",
    ("warpmuscle/kernels/path/wrap_sphere.py",
     "if depth < 0.0 or wp.abs(t - 0.5) + wp.sqrt(wp.max(depth, 0.0) / span) >= 0.5:", "wp.max(depth, 0.0)"):
        "ends are outside: what the line has within the sphere lies between them wholly, or not at all",
    ("warpmuscle/kernels/path/wrap_cylinder.py", "if radius < LEAST_SHARE * full:", "LEAST_SHARE"):
        "a tolerance: how near to its axis an end is, here a tenth of a millimetre, for which nothing is gone round",
    ("warpmuscle/gait/sides.py", '"maximum vertical force": (FORCE, 1.0, 0, 100),', "101"):
        "the cycle has no percent above 100",
    ("warpmuscle/gait/penetration.py", "frame = int(np.argmax(depth)) if len(depth) else 0", "1"):
        "of no frames, of which none is looked at",
    ("warpmuscle/kernels/path/wrap_sphere.py",
     "angle = wp.atan2(wp.length(wp.cross(touch.first, touch.second)), wp.dot(touch.first, touch.second))",
     "touch.second, touch.first"): "the length of a cross product is the same either way",
    ("warpmuscle/kernels/control/walking/torques.py",
     "right = wp.quat_rotate_inv(frame, work.position[leg_of(1, model).shank] - work.position[leg_of(1, model).thigh])",
     "2"): "every side but the left one is the right one",
    ("warpmuscle/kernels/algebra/bending.py", "square = np.zeros(DEGREE + 1)", "(DEGREE + 1 + 1)"):
        "one more coefficient that is none, and cut off behind",
    ("warpmuscle/kernels/algebra/bending.py", "square = np.zeros(DEGREE + 1)", "2"):
        "one more coefficient that is none, and cut off behind",
    ("warpmuscle/kernels/control/gait_sensors.py", "w = q[3]", "4"):
        "Warp gives the last number of a quaternion for every index beyond the others",
    ("warpmuscle/kernels/constraint/solution.py",
     "largest = wp.max(largest, wp.abs(work.followed_matrix[row * count + row]))", "row * count - row"):
        "the scale of a tolerance: how little must move along a row for it to count as immobile",
    ("warpmuscle/model/routes.py",
     "-(-max(len(muscle.path) for muscle in routes) // POINTS_A_SIZE) * POINTS_A_SIZE if wraps else 0,",
     "-max(len(muscle.path) for muscle in routes) * POINTS_A_SIZE"): "more room for points than there are",
    ("warpmuscle/kernels/muscle/sharing.py", "work.softness[body] = SOFTNESS * square + SMALLEST",
     "(SOFTNESS * square + SMALLEST + SMALLEST)"): "the least that is divided by, where no muscle pulls",
    ("warpmuscle/kernels/control/reflex.py",
     "trailing = stance and state.muscles.stands[instance, 1 - side] == 1 and state.muscles.landed[instance] != side",
     "(side - 1)"): "0 of the right leg and -1 of the left one, which Warp counts from the end",
}  # fmt: skip
