"""How metabolic energy is counted: by which formula, with which work and rate at rest, and for how much muscle."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from warpmuscle.core.number_rows import first_number
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.masses import muscle_mass_text


class Formula(NamedTuple):
    """A published formula of metabolic power; `kernels/muscle/metabolics.py` has its heats."""

    source: str
    work: str  # net: lengthening fibres give back what work they take; positive: they give nothing back
    basal_rate: float  # W/kg, of the body at rest, that usually goes with it


# 1.51: Wang 2012; 1.2: the default of OpenSim's probes, of standing in Umberger 2003.
FORMULAS = {
    "wang": Formula("Wang 2012", "positive", 1.51),
    "umberger": Formula("Umberger 2010", "net", 1.2),
    "bhargava": Formula("Bhargava 2004", "net", 1.2),
    "margaria": Formula("Margaria 1968", "positive", 1.2),
}


def fibre_work(objective: Objective) -> str:
    """Which work of fibres counts, net or positive: the objective's, or that of its formula."""
    return objective.metabolic_work or FORMULAS[objective.metabolic_model].work


def negative_share(objective: Objective) -> float:
    """How much of the work that lengthening fibres take is given back, 0 or 1."""
    return 1.0 if fibre_work(objective) == "net" else 0.0


def basal_rate(objective: Objective) -> Any:
    """What the body takes at rest, W/kg: the objective's rate, or that of its formula; a float or (n,)."""
    rate = objective.basal_rate
    return FORMULAS[objective.metabolic_model].basal_rate if rate is None else rate


def accounting(scene: Scene, muscles: Iterable[str]) -> str:
    """How the metabolic energy of some muscles of a numeric scene is counted, in words; empty without muscles.

    An example: Wang 2012 with positive work, 1.51 W/kg at rest, 27.5 kg of muscle at 0.6 MPa (66 kg at 0.25 MPa).

    Args:
        scene: without free parameters.
        muscles: names of those that are simulated.
    """
    counted = [scene.character.muscles[name] for name in muscles]
    if not counted:
        return ""
    objective = scene.objective
    rate = first_number(basal_rate(objective))
    formula = f"{FORMULAS[objective.metabolic_model].source} with {fibre_work(objective)} work"
    return f"{formula}, {rate:g} W/kg at rest, {muscle_mass_text(counted, scene.muscle_model)}"
