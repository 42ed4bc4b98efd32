"""Names of `warpmuscle.kernels` that programs of others may rely on: what changes there is told as a change of the API.

All other names of these modules may change with any version. A name here keeps its arguments, their order and units.
"""

STABLE: dict[str, tuple[str, ...]] = {  # by module
    "objective.accelerations": ("centre_acceleration", "centre_of_mass"),
    "muscle.activation": ("activation_rate", "activation_relaxed", "activation_step"),
    "contact.contact": ("friction_damping", "normal_force"),
    "contact.terrain": ("above_surface",),
    "control.control": ("CustomController",),
    "curve.curve_sets": ("DE_GROOTE", "LEE", "MILLARD", "SARSHARI", "THELEN", "THELEN_EXPLICIT"),
    "curve.curves": (
        "active_force_length", "force_velocity", "force_velocity_slope", "passive_force_length", "tendon_force_slope",
        "tendon_force_strain",
    ),
    "learning.decision": ("Decision", "goal_point"),
    "objective.declaration": ("Declaration",),
    "force.forces": ("ForceKind", "Wrench"),
    "contact.hunt_crossley": ("friction_coefficient", "hertz_force", "smooth_hertz_force"),
    "control.joint_values": ("joint_coordinate", "joint_speed", "joint_speeds"),
    "muscle.metabolics": (
        "bhargava_power", "bhargava_strict_power", "margaria_power", "umberger_power", "wang_power",
    ),
    "muscle.muscle": (
        "along_tendon", "bounded_fibre_length", "compliant_force", "compliant_step", "equilibrium_speed",
        "fibre_damping", "fibre_equilibrium", "fibre_force", "pennation_cosine", "rigid_fibre_length",
        "rigid_fibre_speed", "rigid_force", "tendon_strain",
    ),
    "muscle.muscles": ("activate", "muscle_force_compliant", "muscle_force_rigid", "settle_fibres"),
    "stages": ("forward_dynamics", "forward_kinematics", "mass_matrix"),
    "status": ("Status",),
    "structs": ("Model", "ModelRef", "Scratch", "ScratchRef", "SimbiconState", "State", "StateRef"),
    "objective.term_functions": ("MuscleWork",),
}  # fmt: skip

FIELDS: dict[str, tuple[str, ...]] = {  # of structures, that functions of others may read
    "Decision": ("action", "command", "difficulty", "failed", "goal", "length", "previous_action", "reached", "time"),
    "Model": ("body_count", "gravity", "head", "time_step"),
    "MuscleWork": ("activation", "excitation", "force", "length", "speed"),
    "Scratch": (
        "acceleration", "angular_acceleration", "angular_velocity", "center", "orientation", "position", "rotation",
        "stiffness", "target", "torque", "velocity",
    ),
    "SimbiconState": ("machine_state", "phase", "stance"),
    "State": ("coordinates", "foot_force", "muscles", "simbicon", "speeds", "status", "step"),
    "Wrench": ("force", "moment"),
}  # fmt: skip

MOVED = {  # fields of structures that functions of others may still read where they were
    "State.phase": "simbicon.phase", "State.stance": "simbicon.stance", "State.machine_state": "simbicon.machine_state",
}  # fmt: skip
