"""What kind of muscles a step has compiled in: their law, tendons, curves and paths, and what else acts on them."""

from typing import Any, NamedTuple

from warpmuscle.kernels.curve.custom_curves import CustomCurves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.muscle.contraction import COMPLIANT, EITHER
from warpmuscle.kernels.path.stretch import PathKind


class MuscleLaw(NamedTuple):
    """How force follows from excitation: three makers of Warp functions, each called with the `MuscleKind`.

    A law is one file, such as `hill_law.py`, whose `HILL` this is, and one name in `law_names.Law`, by which scenes
    choose it (`muscle_model.law`). See `muscle_pipeline.MuscleStep` for what its functions read and write.
    """

    activate: Any = None  # of (instance, m, muscle, model, state): moves `activation` over a step
    contract: Any = None  # of (instance, m, muscle, model, state): puts in `fibre`
    strength: Any = None  # of (instance, m, stretch, row, model, state) -> see `muscle_strength.strength_of`
    delayed: bool = True  # whether its muscles hear their excitation late
    past_arms: bool = False  # whether joints ask for force along the moment arms of the step before


class MuscleKind(NamedTuple):
    """What is compiled into a step."""

    curves: int  # LEE ... SARSHARI, see `curve_sets.py`
    tendon: int  # RIGID, SWITCH, COMPLIANT or EITHER
    law: MuscleLaw  # one of `muscle_laws.LAWS`
    pulls_in_scratch: bool = False  # moment arms and torques of all crossings are kept in the working set
    mixed: bool = True  # muscles, torques and spring-dampers may share a joint
    pulleys: bool = False  # some muscles run on pulleys
    conditions: bool = True  # some points of paths are conditional
    straight: bool = False  # all paths are straight, see `structs.Straight`; pulls are in the working set
    timed: bool = True  # some excitations are given over time
    neural: bool = False  # neural dynamics before that of the activation
    excited: bool = False  # the rate of activation depends on the excitation
    excited_rise: bool = False  # ... or does so only where the activation rises
    blended: bool = False  # ... or lies between those of rising and falling
    smoothed: bool = False  # the time constant of some activations changes smoothly, or is one of another law
    implicit: bool = False  # damping linearised over the step, with rigid tendons
    all_timed: bool = False  # and those of all muscles, so that it does not matter what joints want of them
    given: bool = False  # excitations come from outside, as they are
    special_curves: CustomCurves | Shaped | None = None  # in place of some curves of the model
    floored: bool = False  # excitations and activations have a minimum
    coordinate_joints: bool = False  # some joints are as in `coordinate_joint.py`
    followers: bool = False  # and some follow others
    paths: PathKind = PathKind()
    delayed: bool = True  # some muscles hear their excitation late
    shared: int = 0  # torques are shared out, see `sharing.py`: driven joints that a muscle crosses at most
    parts: int = 0  # that joints' torques are added up in, see `torque_parts.py`; 0: not in parts
    apart: bool = False  # a kernel of their own finds paths before each step, see `path_kernels.py`

    @property
    def may_be_in_scratch(self) -> bool:
        """Whether nothing wants to know moment arms later: some laws do, of the step before, damping, and parts."""
        return not self.law.past_arms and not self.implicit and self.parts == 0

    @property
    def may_be_apart(self) -> bool:
        """Whether a step leaves its paths to a kernel of their own: they take long, and nothing comes before them."""
        long = self.paths.routes is not None and self.paths.routes.in_rounds
        return long and self.paths.monomials == 0 and self.shared == 0 and not self.law.past_arms

    @property
    def wraps(self) -> bool:
        """Whether the step itself leads paths round surfaces."""
        return self.paths.wraps and not self.apart

    @property
    def long_paths(self) -> bool:
        """Whether paths take so much that registers are scarce."""
        return self.paths.routes is not None or self.paths.monomials > 0

    @property
    def elastic(self) -> bool:
        """Whether some tendons are compliant."""
        return self.tendon in (COMPLIANT, EITHER)

    @property
    def cables(self) -> bool:
        """Whether some of the muscles are actuators or ligaments, see `cables.py`."""
        return isinstance(self.special_curves, Shaped) and self.special_curves.cables
