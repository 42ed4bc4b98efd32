"""Sound recordings of one trial, as arrays that a damage changes before they are written."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

Edit = Callable[[bytes], bytes]
NAMES = {"markers": "markers.trc", "c3d": "markers.c3d", "coordinates": "walk.mot", "loads": "loads.mot",
         "described": "loads.xml", "emg": "emg.csv", "setup": "ik.xml", "model": "model.osim"}  # fmt: skip


@dataclass
class Columns:
    """A table of numbers over time."""

    names: list[str]
    times: Any  # (F,) s
    values: Any  # (F, K)
    head: dict[str, str] = field(default_factory=dict)  # of a storage file; counts are added

    def storage(self) -> str:
        """As OpenSim's storage file."""
        head = {"nRows": str(len(self.times)), "nColumns": str(len(self.names) + 1)} | self.head
        lines = ["walk", "version=1", *(f"{key}={value}" for key, value in head.items()), "endheader"]
        return "\n".join(lines) + "\n" + self.rows("\t")

    def rows(self, mark: str) -> str:
        """Names and rows."""
        table = np.column_stack([self.times, self.values])
        lines = [mark.join(["time", *self.names]), *(mark.join(f"{x:.9g}" for x in row) for row in table)]
        return "\n".join(lines) + "\n"

    def keep(self, frames: Any) -> None:
        """Leave only these rows, in this order."""
        self.times, self.values = self.times[frames], self.values[frames]


@dataclass
class Trial:
    """Markers, coordinates, loads and EMG of one trial, and changes of the bytes they become."""

    model: Path
    marker_names: list[str]
    marker_times: Any  # (F,) s
    positions: Any  # (F, K, 3) mm, NaN where one is missing
    marker_bodies: list[str]  # of the model, that carry them
    coordinates: Columns  # angles in degrees
    loads: Columns
    plates: list[tuple[str, str, str, str]]  # body, and what names of columns of force, point and moment begin with
    emg: Columns
    unit: str = "mm"
    counts: tuple[str, str] | None = None  # that the head of the markers promises; None: those that there are
    edits: list[tuple[str, Edit]] = field(default_factory=list)  # by key of NAMES
    recorded: Any = None  # see `laboratory`

    def edit(self, what: str, change: Edit) -> None:
        """Change the bytes of a file once it is written."""
        self.edits.append((what, change))

    def laboratory(self) -> Any:
        """What a C3D of it has beside markers, `laboratory.Laboratory`, for changes of that."""
        from damaging.laboratory import Laboratory

        self.recorded = self.recorded or Laboratory()
        return self.recorded

    def keep_markers(self, frames: Any) -> None:
        """Leave only these frames of the markers, in this order."""
        self.marker_times, self.positions = self.marker_times[frames], self.positions[frames]

    def write(self, folder: Path, kind: str) -> None:
        """Write all files, damaged as was asked for; a C3D and a set-up only for cases of theirs."""
        shutil.copy(self.model, folder / "model.osim")
        (folder / NAMES["markers"]).write_text(self._trc())
        if kind == "c3d":
            self._write_c3d(folder / NAMES["c3d"])
        if kind == "laboratory":
            from damaging.laboratory import write_laboratory

            write_laboratory(self, self.laboratory(), folder / NAMES["c3d"])
        for what, text in (
            ("coordinates", self.coordinates.storage()), ("loads", self.loads.storage()),
            ("described", self._described()), ("emg", self.emg.rows(",")),
        ):  # fmt: skip
            (folder / NAMES[what]).write_text(text)
        if kind == "setup":
            (folder / NAMES["setup"]).write_text(self._setup())
        for what, change in self.edits:
            path = folder / NAMES[what]
            if path.exists():
                path.write_bytes(change(path.read_bytes()))

    def _trc(self) -> str:
        rate = (len(self.marker_times) - 1) / np.ptp(self.marker_times) if len(self.marker_times) > 1 else 100.0
        rate = 0.0 if not np.isfinite(rate) else rate
        frames, count = self.counts or (str(len(self.marker_times)), str(len(self.marker_names)))
        keys = [
            "DataRate",
            "CameraRate",
            "NumFrames",
            "NumMarkers",
            "Units",
            "OrigDataRate",
            "OrigDataStartFrame",
            "OrigNumFrames",
        ]
        words = [f"{rate:.4f}", f"{rate:.4f}", frames, count, self.unit, f"{rate:.4f}", "1", frames]
        lines = ["PathFileType\t4\t(X/Y/Z)\tmarkers.trc", "\t".join(keys), "\t".join(words)]
        lines.append("Frame#\tTime\t" + "\t\t\t".join(self.marker_names))
        lines += ["\t\t" + "\t".join(f"{a}{k + 1}" for k in range(len(self.marker_names)) for a in "XYZ"), ""]
        for k, (time, row) in enumerate(zip(self.marker_times, self.positions, strict=True)):
            cells = ["" if np.isnan(x) else f"{x:.6f}" for x in row.ravel()]
            lines.append("\t".join([str(k + 1), f"{time:.6f}", *cells]))
        return "\n".join(lines) + "\n"

    def _write_c3d(self, path: Path) -> None:
        import ezc3d

        content = ezc3d.c3d()
        rate = (len(self.marker_times) - 1) / np.ptp(self.marker_times)
        content["parameters"]["POINT"]["RATE"]["value"] = [rate]
        content["parameters"]["POINT"]["UNITS"]["value"] = [self.unit]
        content["parameters"]["POINT"]["LABELS"]["value"] = list(self.marker_names)
        points = np.ones((4, len(self.marker_names), len(self.marker_times)))
        points[:3] = self.positions.transpose(2, 1, 0)
        content["data"]["points"] = points
        content.write(str(path))

    def _described(self) -> str:
        forces = []
        for body, *starts in self.plates:
            tags = zip(("force_identifier", "point_identifier", "torque_identifier"), starts, strict=True)
            inner = "".join(f"<{tag}>{word}</{tag}>" for tag, word in tags)
            inner += "".join(
                f"<{what}_expressed_in_body>ground</{what}_expressed_in_body>" for what in ("force", "point")
            )
            forces.append(
                f'<ExternalForce name="on_{body}"><applied_to_body>{body}</applied_to_body>{inner}</ExternalForce>'
            )
        return (
            '<OpenSimDocument Version="40000"><ExternalLoads name="ground">\n<objects>\n'
            + "\n".join(forces)
            + f"\n</objects>\n<datafile>{NAMES['loads']}</datafile></ExternalLoads></OpenSimDocument>\n"
        )

    def _setup(self) -> str:
        """A set-up of inverse kinematics: all markers, and a coordinate that takes its values from a file."""
        tasks = [f'<IKMarkerTask name="{name}"><apply>true</apply><weight>{1 + k % 3}</weight></IKMarkerTask>'
                 for k, name in enumerate(self.marker_names)]  # fmt: skip
        name = next(name for name in self.coordinates.names if "hip_flexion" in name)
        tasks.append(f'<IKCoordinateTask name="{name}"><apply>true</apply><weight>0.001</weight>'
                     "<value_type>from_file</value_type></IKCoordinateTask>")  # fmt: skip
        first, last = self.marker_times[[0, -1]]
        return (
            '<OpenSimDocument Version="40000"><InverseKinematicsTool name="walk">\n'
            f"<model_file>{NAMES['model']}</model_file><marker_file>{NAMES['markers']}</marker_file>"
            f"<coordinate_file>{NAMES['coordinates']}</coordinate_file>\n"
            f"<time_range>{first:.4f} {last:.4f}</time_range>\n"
            "<IKTaskSet><objects>\n" + "\n".join(tasks) + "\n</objects></IKTaskSet>\n"
            "</InverseKinematicsTool></OpenSimDocument>\n"
        )


def read_trial(
    model: Path, markers: Path, coordinates: Path, loads: Path, span: tuple[float, float] = (0.5, 1.1), every: int = 2
) -> Trial:
    """A part of real recordings, and EMG as smooth bursts of the model's muscles."""
    import warpmuscle as wm
    from warpmuscle.inverse.files import angle_names, read_coordinates, read_markers
    from warpmuscle.inverse.loads import read_loads

    scene = wm.load(model, ignored=[])
    assert scene.opensim is not None
    found, motion, plates = read_markers(markers), read_coordinates(coordinates, scene), read_loads(loads)
    known = [k for k, name in enumerate(found.names) if name in scene.opensim.markers]
    at = (found.times >= span[0]) & (found.times <= span[1])
    turned = [name in angle_names(scene) for name in motion.names]
    within = (motion.times >= span[0] - 1e-6) & (motion.times <= span[1] + 1e-6)
    on = (plates.times >= span[0] - 0.05) & (plates.times <= span[1] + 0.05)
    columns, names, starts = [], [], []
    for plate in plates.plates:
        start = f"{plate.body}_ground"
        starts.append((str(plate.body), f"{start}_force_v", f"{start}_force_p", f"{start}_torque_"))
        names += [f"{word}{axis}" for word in starts[-1][1:] for axis in "xyz"]
        columns += [plate.force[on], plate.point[on], plate.moment[on]]
    return Trial(
        model,
        [found.names[k] for k in known], found.times[at], 1000.0 * found.positions[at][:, known],
        [scene.opensim.markers[found.names[k]].body for k in known],
        Columns(list(motion.names), motion.times[within],
                np.where(turned, np.degrees(motion.values), motion.values)[within], {"inDegrees": "yes"}),
        Columns(names, plates.times[on][::every], np.concatenate(columns, axis=1)[::every]), starts,
        smooth_emg(list(scene.character.muscles)[:6], span),
    )  # fmt: skip


def smooth_emg(muscles: list[str], span: tuple[float, float], rate: float = 200.0) -> Columns:
    """Bursts from 0.05 to 0.55."""
    times = np.arange(span[0] - 0.1, span[1] + 0.1, 1.0 / rate)
    phases = np.arange(len(muscles))
    return Columns(muscles, times, 0.3 + 0.25 * np.sin(2.0 * np.pi * times[:, None] + phases))
