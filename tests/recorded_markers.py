"""Markers as a .trc file."""

import numpy as np

from warpmuscle.inverse.trial import Markers

COLUMNS = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"


def trc_text(markers: Markers) -> str:
    """The text; what is missing is empty."""
    count, names = len(markers.times), markers.names
    rate = (count - 1) / (markers.times[-1] - markers.times[0]) if count > 1 else 100.0
    lines = [
        "PathFileType\t4\t(X/Y/Z)\tmarkers.trc",
        COLUMNS,
        f"{rate:.6f}\t{rate:.6f}\t{count}\t{len(names)}\tm\t{rate:.6f}\t1\t{count}",
        "Frame#\tTime\t" + "\t\t\t".join(names),
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(names)) for axis in "XYZ"),
        "",
    ]
    for k, (time, row) in enumerate(zip(markers.times, markers.positions, strict=True)):
        cells = ["" if np.isnan(x) else f"{x:.9f}" for x in row.ravel()]
        lines.append("\t".join([str(k + 1), f"{time:.8f}", *cells]))
    return "\n".join(lines) + "\n"
