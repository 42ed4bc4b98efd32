"""Names of modules that programs of others may rely on, besides those of `import warpmuscle as wm`.

All other names may change with any version. `throw`, `synergy` and `markers` use nothing else of the package, so a
study of one's own can be built on these. `kernels.stable` is the same for Warp functions.
"""

PUBLIC: dict[str, tuple[str, ...]] = {  # by module
    "core.archive": ("DamagedArchive", "read_arrays"),
    "core.array_checks": ("check_numbers",),
    "core.array_types": ("Floats", "Integers"),
    "core.errors": ("SignalError",),
    "core.extras": ("imported",),
    "core.files": ("check_regular", "read_file", "replace_file", "unreadable"),
    "core.hdf5": ("Says", "array", "check_contents", "opened", "strings"),
    "core.hdf5_writing": ("store",),
    "core.limits": ("check_size",),
    "core.machine": ("this_machine",),
    "core.names": ("file_name",),
    "core.number_rows": ("first_number", "rows"),
    "core.plain_text": ("few_of", "number_of", "readable"),
    "core.pose": ("about", "conjugate", "from_rotation_vector", "multiply", "normalized", "rotate", "twist_angle"),
    "formats.toml": ("dumps",),
    "model.path_table": ("joints_of_muscles",),
    "plots.style": ("matplotlib", "save"),
    "results.records": ("parameter_table",),
    "results.result": ("THROW_FORMAT", "write_extended"),
    "scene": ("Actuation", "Drive", "Failure", "Joint", "Motion", "Muscle"),
    "scene.joints": ("joint_type", "root_type"),
    "scene.muscles.settings": ("special_settings",),
    "scene.parameters": ("Parameter", "at_start", "free_parameters", "start_values", "substitute", "with_values"),
    "scene.topology": ("Topology", "topology"),
    "search.batched": ("ask_all", "tell_all"),
    "search.cma": ("CmaSearch",),
    "search.directions": ("directions",),
    "search.nlopt": ("NloptSearch",),
    "simulation.devices": ("find_device",),
    "studies.inverse_dynamics": ("inverse_dynamics", "points_of"),
    "studies.muscle_table": ("MuscleTable", "PathGeometry"),
    "studies.poses": ("initial_coordinates", "prescribed_coordinates"),
}
