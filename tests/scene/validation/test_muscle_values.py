"""Numbers of fibres, tendons and curves that no muscle can have are refused in one line with their key."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import (
    DeGrooteCurves,
    Excitation,
    Ligament,
    MillardCurves,
    MuscleModel,
    PathActuator,
    Scene,
    Spline,
    SplineCurves,
    ThelenCurves,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene

OWN = {
    "tendon": "rigid", "v_max": 12.0, "damping": 0.05, "rise_time": 0.015, "fall_time": 0.05,
    "minimum_activation": 0.01, "tendon_strain": 0.033, "passive_strain": 0.6,
    "curve_shape": MillardCurves(active_from=0.25, active_bend=0.77, active_until=1.9, active_slope=0.75),
}  # fmt: skip


def scene(own: dict[str, Any] | None = None, **model: Any) -> Scene:
    """An arm whose flexor has values of its own."""
    return arm(flexor=own, muscle_model=MuscleModel(**{"curves": "millard", "tendon": "compliant", **model}))


def test_activations_may_rise_and_fall_by_other_laws():
    one = scene({"activation": "blended"}, activation="scaled")
    check_scene(one)
    check_scene(scene({"activation": "scaled", "activation_smoothing": 0.1}, activation="excited"))
    assert loads(dumps(one)).character.muscles["flexor"].activation == "blended"


def test_all_own_values_are_taken_and_come_back_from_toml() -> None:
    one = scene(OWN, curve_shape=MillardCurves(shortening_slope=0.3))
    check_scene(one)
    again = loads(dumps(one))
    assert again.character.muscles["flexor"] == one.character.muscles["flexor"]
    assert again.muscle_model == one.muscle_model


@pytest.mark.parametrize(
    ("own", "model", "key", "words"),
    [
        ({"v_max": 0.0}, {}, "flexor.v_max", "greater than 0"),
        ({"rise_time": -1.0}, {}, "flexor.rise_time", "greater than 0"),
        ({"minimum_activation": 1.5}, {}, "flexor.minimum_activation", "within 0 and 1"),
        ({"activation": "blended"}, {}, "flexor.activation", "excited or excited_rise"),
        (
            {"activation": "scaled"},
            {"activation": "neural"},
            "flexor.activation",
            "scaled, blended, excited or excited_rise",
        ),
        ({"activation": "blended", "activation_smoothing": 0.1}, {"activation": "scaled"}, "smoothing", "is smoothed"),
        ({"damping": 0.0}, {}, "flexor.damping", "greater than 0"),
        ({"tendon": "compliant"}, {"tendon": "rigid", "damping": 0.0}, "muscle_model.damping", "greater than 0"),
        ({"tendon": "compliant", "l_slack": 0.0}, {"tendon": "rigid"}, "flexor.l_slack", "greater than 0"),
        ({"tendon": "rigid"}, {"tendon": "switch"}, "flexor.tendon", "switch"),
        ({"tendon_strain": 0.0}, {}, "flexor.tendon_strain", "greater than 0"),
        ({"tendon_strain": 0.03}, {"curves": "lee"}, "flexor.tendon_strain", "'lee' curves have no"),
        ({"tendon_strain": 0.03}, {"legacy": True, "curves": "lee", "tendon": "rigid"}, "flexor.tendon_strain", "leg"),
        ({"tendon": "rigid"}, {"ideal": True}, "flexor.tendon", "legacy and ideal"),
        ({"curve_shape": ThelenCurves()}, {"curves": "sarshari"}, "flexor.curve_shape", "curves have no"),
        ({"passive_strain": Free(0.6, 0.5, 0.7)}, {}, "flexor.passive_strain", "tables"),
        ({"curve_shape": ThelenCurves(lengthening_force=0.9)}, {}, "lengthening_force", "greater than 1"),
        ({"curve_shape": ThelenCurves(straight_from=0.5)}, {}, "straight_from", "1/lengthening_force"),
        ({"curve_shape": DeGrooteCurves(active_width=0.0)}, {}, "active_width", "greater than 0"),
        ({"curve_shape": MillardCurves(active_bend=0.3)}, {}, "active_from", "between 0 and 0.3"),
        ({"curve_shape": MillardCurves(active_slope=9.0)}, {}, "active_slope", "between"),
        ({"curve_shape": MillardCurves(passive_slope=0.1)}, {}, "passive_slope", "between"),
        ({"curve_shape": MillardCurves(passive_slack=0.8)}, {}, "passive_slack", "passive_strain 0.7"),
        ({"curve_shape": MillardCurves(tendon_curviness=2.0)}, {}, "tendon_curviness", "between 0 and 1"),
        ({"curve_shape": MillardCurves(lengthening_slope=0.0)}, {}, "lengthening_slope", "between 1.5e-08"),
        ({"curve_shape": MillardCurves(shortening_slope=0.0)}, {}, "shortening_slope", "between 1.5e-08"),
        ({}, {"curve_shape": ThelenCurves()}, "muscle_model.curve_shape.type", "'millard'"),
        ({"curve_shape": PathActuator(), "v_max": 9.0}, {}, "flexor.v_max", "path actuator has no"),
        ({"curve_shape": PathActuator()}, {"curves": "lee"}, "curve_shape.type", "needs muscles with curves of"),
        ({"curve_shape": PathActuator()}, {"sharing": "least_effort"}, "curve_shape.type", "share no torques"),
        ({"curve_shape": Ligament([1.0], [0.0])}, {}, "curve_shape.x", "two knots"),
        ({"curve_shape": Ligament([1.0, 2.0], [0.0])}, {}, "curve_shape.y", "1 tension for 2"),
        ({"curve_shape": Ligament([1.0, 1.0], [0.0, 1.0])}, {}, "curve_shape.x.1", "increase"),
        ({"curve_shape": Ligament([1.0, 2.0], [0.0, 1.0], dissipation=-1.0)}, {}, "dissipation", "not be negative"),
        (
            {"curve_shape": Ligament([1.0, 2.0], [0.0, 1.0]), "excitation": Excitation([0.0], [0.5])},
            {},
            "excitation",
            "ligament has no",
        ),
        ({"curve_shape": Ligament([1.0, 2.0], [0.0, 1.0]), "l_slack": 0.0}, {}, "flexor.l_slack", "greater than 0"),
        ({}, {"curve_shape": MillardCurves(), "force_velocity": "a:b"}, "muscle_model.curve_shape", "no shape"),
    ],
)
def test_what_no_muscle_can_have_is_refused(own: dict, model: dict, key: str, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        check_scene(scene(own, **model))
    assert caught.value.key.endswith(key)
    assert words in str(caught.value)


def test_numbers_of_tables_cannot_be_free() -> None:
    text = dumps(scene({"curve_shape": MillardCurves(active_bend=0.7)}))
    with pytest.raises(SceneError, match="active_bend"):
        loads(text.replace("active_bend = 0.7", "active_bend = { value = 0.7, min = 0.6, max = 0.8 }"))


def test_thelen_muscles_need_no_damping() -> None:
    check_scene(scene(curves="thelen", damping=0.0, curve_shape=ThelenCurves()))
    check_scene(msgspec.structs.replace(scene(curves="thelen", damping=0.0, tendon_strain=0.033)))


def through_knots(**changed: Spline) -> SplineCurves:
    """Curves through knots, some of them others."""
    active, passive = Spline([0.4, 1.0, 1.6], [0.0, 1.0, 0.0]), Spline([0.0, 1.0, 1.6], [0.0, 0.0, 1.0])
    usual = {"active": active, "passive": passive, "tendon": Spline([0.0, 0.04], [0.0, 1.0])}
    return SplineCurves(**usual | changed)


def test_curves_through_knots_come_back_from_toml_of_one_muscle_and_of_all() -> None:
    speeds = Spline([-1.0, 0.0, 1.0], [0.0, 1.0, 1.4], "linear")
    one = scene({"curve_shape": through_knots(velocity=speeds)}, curve_shape=through_knots())
    check_scene(one)
    again = loads(dumps(one))
    assert again.character.muscles["flexor"] == one.character.muscles["flexor"]
    assert again.muscle_model == one.muscle_model


@pytest.mark.parametrize(
    ("curves", "key", "words"),
    [
        ({"active": Spline([0.5], [1.0])}, "active.x", "at least two knots"),
        ({"passive": Spline([0.0, 1.0], [0.0])}, "passive.y", "1 value for 2 places"),
        ({"active": Spline([0.5, 0.5], [1.0, 2.0])}, "active.x.1", "increas"),
        ({"tendon": Spline([0.0, 0.04], [0.0, -1.0])}, "tendon.y", "must rise"),
        ({"tendon": Spline([0.0, 4.0], [0.0, 1.0])}, "tendon.y", "must rise"),
        ({"velocity": Spline([-1.0, 1.0], [1.0, 0.0])}, "velocity.y", "must not fall"),
        ({"passive": Spline([0.0, float("nan")], [0.0, 1.0])}, "passive.x.1", "number"),
    ],
)
def test_curves_through_knots_that_no_fibre_has_are_refused(
    curves: dict[str, Spline], key: str, words: str
) -> None:  # fmt: skip
    with pytest.raises(SceneError, match=words) as caught:
        check_scene(scene({"curve_shape": through_knots(**curves)}))
    assert str(caught.value.key).endswith(f"flexor.curve_shape.{key}")
