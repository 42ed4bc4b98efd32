"""Where gravity's power goes on slopes: what muscles do more and less, from the table of `warpmuscle adaptation`.

For docs/how-to/run-a-study.md.

    python tools/research/slope_work.py inclines.csv adaptation.json

The table has how three powers of a walk change: Wang's by positive and by net work, and Margaria's, work at 25 and -120
%. Positive work costs the same in the first two, and what lengthening fibres take is their difference; Margaria's then
says how much positive work there is, and what is left of Wang's is heat. All is in percent of the measured metabolic
power of the level walk, medians over seeds. Elsewhere is what muscles and gravity together give more than on the
level: what stops of joints, the ground and torques that help take away.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

UP, DOWN = 0.25, 1.2  # efficiencies of Margaria
POSITIVE, NET, WORK = "Wang, positive work", "Wang, net work", "Margaria, 25 and -120 % of work"
GRAVITY = 9.81


class Change(NamedTuple):
    """What changes against the level walk, percent of its measured metabolic power."""

    shortening: float  # work of fibres that shorten
    lengthening: float  # work that fibres take which lengthen, without its sign
    heat: float  # of activation, maintenance and shortening, by Wang
    gravity: float  # what gravity gives

    @property
    def elsewhere(self) -> float:
        """What neither muscles nor gravity keep."""
        return self.shortening - self.lengthening + self.gravity


def change_of(positive: float, net: float, work: float, gravity: float) -> Change:
    """Work and heat of changes of the three powers."""
    lengthening = positive - net
    shortening = UP * (work - lengthening / DOWN)
    return Change(shortening, lengthening, positive - shortening, gravity)


def changes(table: Path, measured: Path) -> dict[str, Change]:
    """The changes on slopes, by condition, of a table and the conditions that it was made for."""
    records = {one["identifier"]: one for one in json.loads(measured.read_text())}
    found: dict[str, dict[str, float]] = {}
    with table.open(newline="") as file:
        for row in csv.DictReader(file):
            if row["kind"] in ("uphill", "downhill"):
                found.setdefault(row["condition"], {})[row["quantity"]] = float(row["predicted (%)"])
    return {
        name: change_of(values[POSITIVE], values[NET], values[WORK], gravity_of(records[name], records))
        for name, values in found.items()
        if {POSITIVE, NET, WORK} <= set(values)
    }


def gravity_of(record: Mapping[str, object], records: Mapping[str, Mapping[str, object]]) -> float:
    """What gravity gives, percent of the measured power of the level walk of the study at the same speed."""
    alike = ("study", "speed_m_s")
    level = next(
        one for one in records.values()
        if all(one[key] == record[key] for key in alike) and not one["slope_pct"] and not one["added_mass_kg"]
    )  # fmt: skip
    speed, leg = float(str(record["speed_m_s"])), float(str(record["leg_length_m"]))
    fall = -math.sin(math.atan(float(str(record["slope_pct"])) / 100.0)) * speed / math.sqrt(GRAVITY * leg)
    return 100.0 * fall / float(str(level["metabolic_power_nd"]))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("measured", type=Path)
    chosen = parser.parse_args()
    print("| condition | shortening | lengthening | heat | gravity gives | elsewhere |\n|---|---|---|---|---|---|")
    for name, one in changes(chosen.table, chosen.measured).items():
        numbers = (one.shortening, one.lengthening, one.heat, one.gravity, one.elsewhere)
        print(f"| {name} | {' | '.join(f'{value:+.0f}' for value in numbers)} |")


if __name__ == "__main__":
    main()
