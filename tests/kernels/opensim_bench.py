"""All muscles of an OpenSim model on one slider in OpenSim, and the same as ours, to compare them state by state.

Muscles keep all that the file says of them but their paths, which become the slider's coordinate.
"""

from __future__ import annotations

import copy
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from muscle_arm import ZERO, X
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    CurveShape,
    DeGrooteCurves,
    Failure,
    Joint,
    MillardCurves,
    Muscle,
    MuscleModel,
    Pulley,
    Scene,
    ThelenCurves,
)

MODELS = {  # in the reference data
    "Rajagopal2016": "opensim_models/Rajagopal2016.osim",
    "gait2392_thelen": "opensim_models/gait2392_thelen2003muscle.osim",
    "gait2392_millard": "opensim_models/gait2392_millard2012muscle.osim",
    "gait10dof18musc": "opensim_models/gait10dof18musc.osim",
    "arm26": "opensim_models/arm26.osim",
}


class Bench:
    """Muscles in OpenSim: `model`, `state`, the coordinate that is their length, and themselves."""

    def __init__(self, file: Path | None, osim: Any, muscles: list[Any] | None = None) -> None:
        """Take the muscles of a file, or muscles made in Python."""
        self.osim = osim
        osim.Logger.setLevelString("off")
        with tempfile.TemporaryDirectory() as folder:
            at = Path(folder)
            self._bare(at / "bare.osim", muscles or [osim.Millard2012EquilibriumMuscle("none", 1.0, 0.1, 0.1, 0.0)])
            if file is not None:
                osim.Model(str(file)).printToXML(str(at / "newest.osim"))
                self._put(at / "newest.osim", at / "bare.osim")
            self.model = osim.Model(str(at / "bare.osim"))
        self.state = self.model.initSystem()
        self.length = self.model.getCoordinateSet().get("q")
        every = [self.model.getMuscles().get(k) for k in range(self.model.getMuscles().getSize())]
        self.muscles = [getattr(osim, one.getConcreteClassName()).safeDownCast(one) for one in every]

    def _bare(self, file: Path, muscles: list[Any]) -> None:
        osim, model = self.osim, self.osim.Model()
        body = osim.Body("b", 1.0, osim.Vec3(0), osim.Inertia(1, 1, 1))
        joint = osim.SliderJoint("j", model.getGround(), body)
        joint.updCoordinate().setName("q")
        model.addBody(body)
        model.addJoint(joint)
        for muscle in muscles:
            muscle.addNewPathPoint("a", model.getGround(), osim.Vec3(0))
            muscle.addNewPathPoint("b", body, osim.Vec3(0))
            model.addForce(muscle)
        model.finalizeConnections()
        model.printToXML(str(file))

    def _put(self, source: Path, target: Path) -> None:
        tree = ET.parse(target)
        forces = tree.getroot().find(".//ForceSet/objects")
        assert forces is not None
        tag = "path" if forces[0].find("path") is not None else "GeometryPath"
        route = copy.deepcopy(forces[0].find(tag))
        assert route is not None
        forces.remove(forces[0])
        for one in ET.parse(source).getroot().findall(".//ForceSet/objects/*"):
            old = one.find(tag)
            if old is not None and one.find("optimal_fiber_length") is not None:
                one.remove(old)
                one.append(copy.deepcopy(route))
                forces.append(one)
        tree.write(target)

    def put(self, muscle: Any, activation: float, length: float, fibre: float = 0.0, speed: float = 0.0) -> None:
        """Put a muscle into a state: path length, m, and fibre length, m, or 0 for equilibrium at rest."""
        self.length.setValue(self.state, length)
        self.length.setSpeedValue(self.state, speed)
        muscle.setActivation(self.state, activation)
        self.model.realizeVelocity(self.state)
        if fibre > 0.0:
            muscle.setFiberLength(self.state, fibre)
        elif not muscle.get_ignore_tendon_compliance():
            muscle.computeEquilibrium(self.state)
        self.model.realizeDynamics(self.state)


def shape_of(muscle: Any) -> tuple[CurveShape, float, float]:
    """The shape of a muscle's curves, and the strains of tendon and passive fibre at f_max."""
    kind = muscle.getConcreteClassName()
    if kind == "Thelen2003Muscle":
        thelen = ThelenCurves(
            muscle.get_KshapeActive(), muscle.get_KshapePassive(), muscle.get_Af(), muscle.get_Flen(),
            muscle.get_fv_linear_extrap_threshold(),
        )  # fmt: skip
        return thelen, muscle.get_FmaxTendonStrain(), muscle.get_FmaxMuscleStrain()
    if kind == "DeGrooteFregly2016Muscle":
        groote = DeGrooteCurves(muscle.get_active_force_width_scale(), not muscle.get_ignore_passive_fiber_force())
        strains = muscle.get_tendon_strain_at_one_norm_force(), muscle.get_passive_fiber_strain_at_one_norm_force()
        return groote, *strains
    active, velocity = muscle.get_ActiveForceLengthCurve(), muscle.get_ForceVelocityCurve()
    passive, tendon = muscle.get_FiberForceLengthCurve(), muscle.get_TendonForceLengthCurve()
    millard = MillardCurves(
        active.get_min_norm_active_fiber_length(), active.get_transition_norm_fiber_length(),
        active.get_max_norm_active_fiber_length(), active.get_shallow_ascending_slope(), active.get_minimum_value(),
        velocity.get_concentric_slope_at_vmax(), velocity.get_concentric_slope_near_vmax(),
        velocity.get_isometric_slope(), velocity.get_eccentric_slope_near_vmax(),
        velocity.get_eccentric_slope_at_vmax(), velocity.get_max_eccentric_velocity_force_multiplier(),
        velocity.get_concentric_curviness(), velocity.get_eccentric_curviness(), passive.get_strain_at_zero_force(),
    )  # fmt: skip
    return millard, tendon.get_strain_at_one_norm_force(), passive.get_strain_at_one_norm_force()


def as_ours(muscle: Any, rest_length: float = 1.0, moment_arm: float = 0.0) -> Muscle:
    """A muscle of ours with all that an OpenSim muscle says, on a pulley."""
    shape, tendon_strain, passive_strain = shape_of(muscle)
    thelen = isinstance(shape, ThelenCurves)
    floored = not isinstance(shape, DeGrooteCurves)
    return Muscle(
        pulleys=[Pulley("joint", moment_arm)], rest_length=rest_length,
        f_max=muscle.get_max_isometric_force(), l_opt=muscle.get_optimal_fiber_length(),
        l_slack=muscle.get_tendon_slack_length(), pennation=muscle.get_pennation_angle_at_optimal(),
        tendon="rigid" if muscle.get_ignore_tendon_compliance() else "compliant",
        v_max=muscle.get_max_contraction_velocity(), damping=0.0 if thelen else muscle.get_fiber_damping(),
        rise_time=muscle.get_activation_time_constant(), fall_time=muscle.get_deactivation_time_constant(),
        minimum_activation=muscle.get_minimum_activation() if floored else None,
        tendon_strain=tendon_strain, passive_strain=passive_strain, curve_shape=shape,
    )  # fmt: skip


def bench_scene(muscles: dict[str, Muscle], **changes: Any) -> Scene:
    """A scene in which the muscles pull on a hinge."""
    bodies = {name: Body(1.0, (1.0, 1.0, 1.0)) for name in ("base", "tip")}
    joints = {"joint": Joint("hinge", "base", "tip", ZERO, ZERO, [X])}
    scene = Scene(
        "bench", Character("base", bodies, joints, "fixed", muscles), failure=Failure(0.0, 0.0),
        muscle_model=MuscleModel(curves="millard", activation="scaled"), actuation={"joint": Actuation("muscle")},
    )  # fmt: skip
    for field, value in changes.items():
        setattr(scene, field, value)
    return scene
