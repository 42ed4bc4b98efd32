"""What a page is sent about norms."""

import numpy as np

from warpmuscle.gait.likeness import norms_of
from warpmuscle.view.content import LegNorm, panel_contents
from warpmuscle.view.curves import Line, Panel


def angle(title: str, left: float, right: float) -> Panel:
    """A panel of a joint of both sides that hardly moves."""
    lines = (Line(f"l{title}", "left", np.full(5, left)), Line(f"r{title}", "right", np.full(5, right)))
    return Panel("angles", title, "°", lines, joint=f"l{title}")


def test_norms_are_shown_at_the_joints_of_the_legs_also_where_others_are_bent_as_little():
    panels = [angle("Shoulder", 4.0, 4.0), angle("Hip", 5.0, 6.0), angle("Knee", -9.0, -8.0), angle("Elbow", 8.0, 8.0)]
    bands = norms_of(False)[-1].angles
    norms = [
        LegNorm(side, np.full(5, value), "somebody", bands[title])
        for title, left, right in (("Hip flexion", 5.0, 6.0), ("Knee flexion", 9.0, 8.0))
        for side, value in (("left", left), ("right", right))
    ]
    told = panel_contents(panels, norms)
    assert [panel["title"] for panel in told if "norm" in panel] == ["Hip", "Knee"]
    swing = np.argmax(bands["Knee flexion"].mean(np.linspace(0.0, 100.0, 51)))
    assert np.argmin(told[2]["norm"]["mean"]) == swing  # with the sign of the curve
