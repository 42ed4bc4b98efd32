"""Segments of another size: lengths, masses and inertias as for the same material, free numbers included."""

import warnings

import msgspec
import numpy as np
import pytest

from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene import ContactMaterial, PolynomialPath, Scene, Sphere, ViaPoint
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import leaves, start_values, substitute
from warpmuscle.scene.scaling import _lowest_point, multiplied, path_lengths, scaled_segments
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.stages import Stages


def numbers(scene: Scene) -> dict[str, float]:
    return {path: leaf for path, leaf in leaves(substitute(scene, start_values(scene))) if isinstance(leaf, float)}


def test_segment_scales_with_all_that_is_attached_to_it():
    scene = load("walk56")
    scaled = scaled_segments(scene, {"lLowerleg": 1.2})
    check_scene(scaled)
    before, after = numbers(scene), numbers(scaled)
    ratio = {path: after[path] / before[path] for path in before if after[path] != before[path]}
    assert ratio.pop("character.bodies.lLowerleg.mass") == pytest.approx(1.2**3)
    for axis in range(3):
        assert ratio.pop(f"character.bodies.lLowerleg.inertia.{axis}") == pytest.approx(1.2**5)
    ratio.pop("initial_state.root_position.1", None)
    assert ratio == pytest.approx(dict.fromkeys(ratio, 1.2))
    assert {path.split(".")[2] for path in ratio if ".joints." in path} == {"lKnee", "lAnkle"}
    assert any(".muscles.lSOL.path." in path for path in ratio)
    assert any(".bodies.lLowerleg.shapes." in path for path in ratio)


def test_lines_that_via_points_lie_on_scale_with_their_body():
    scene = muscle_scene()
    scene.character.muscles["HFL"].path[1] = ViaPoint("lFoot", start=(0.1, 0.2, 0.3), end=(0.4, 0.5, 0.6), at=0.5)
    before, after = numbers(scene), numbers(scaled_segments(scene, {"lFoot": 2.0}))
    ratio = {path: after[path] / before[path] for path in before if ".HFL.path.1." in path}
    assert ratio.pop("character.muscles.HFL.path.1.at") == 1.0
    assert set(ratio.values()) == {2.0}


def test_lowest_point_stays_on_the_ground():
    scene = load("fwalk")
    for factors in ({"lLowerleg": 1.3, "rLowerleg": 1.3}, dict.fromkeys(scene.character.bodies, 0.8)):
        scaled = scaled_segments(scene, factors)
        assert _lowest_point(scaled) == pytest.approx(_lowest_point(scene), abs=1e-12)
        assert scaled.initial_state.root_position[1] != scene.initial_state.root_position[1]


def test_lowest_point_is_that_of_the_simulation():
    scene = load("fwalk")
    kinematics = Stages(scene, 1, "cpu").forward_kinematics()
    names = Stages(scene, 1, "cpu").names.bodies
    from warpmuscle.core.pose import rotate
    from warpmuscle.scene.geometry import contact_points

    heights = [
        (kinematics["position"][0, i] + rotate(kinematics["orientation"][0, i], np.array(point)))[1] - radius
        for i, name in enumerate(names)
        for shape in scene.character.bodies[name].shapes
        for point, radius in contact_points(shape)
    ]
    assert _lowest_point(scene) == pytest.approx(min(heights), abs=1e-6)


def test_whole_character_scales_its_weight_by_the_cube():
    scene = load("fwalk")
    scaled = scaled_segments(scene, dict.fromkeys(scene.character.bodies, 1.1))
    mass = [sum(body.mass for body in one.character.bodies.values()) for one in (scene, scaled)]
    assert mass[1] == pytest.approx(1.1**3 * mass[0])


OPENSIM = {  # models, factors of bodies; lengths of path, fibre and tendon of OpenSim 4.6's Model.scale at the start, m
    "Rajagopal2016": ({"femur_r": 1.1, "tibia_r": 0.9, "pelvis": 1.05, "patella_r": 1.1}, {
        "glmax1_r": (0.2041263, 0.1567298, 0.0520736), "gasmed_r": (0.4177193, 0.0466457, 0.3646746),
        "recfem_r": (0.5538247, 0.0820910, 0.4850761), "iliacus_r": (0.2210795, 0.1134651, 0.1023109),
    }),
    "arm26": ({"r_humerus": 1.2, "r_ulna_radius_hand": 0.8}, {
        "TRIlong": (0.3403129, 0.1642666, 0.1752995), "BRA": (0.1592533, 0.0927294, 0.0578208),
    }),
    "gait2392_thelen2003muscle": ({"femur_r": 0.9, "tibia_r": 1.1}, {
        "vas_int_r": (0.1604533, 0.0766811, 0.1198693), "lat_gas_r": (0.4894594, 0.0700695, 0.4160378),
    }),
}  # fmt: skip


@pytest.mark.parametrize("model", OPENSIM)
def test_surfaces_points_and_muscles_scale_as_opensim_scales_them(reference_data, model):
    factors, expected = OPENSIM[model]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = load(reference_data / "opensim_models" / f"{model}.osim", hard_points=True)  # whose paths are OpenSim's
    scaled = scaled_segments(scene, factors, muscles=True)
    check_scene(scaled)
    found = path_lengths(scaled)
    for name, (length, *fibre_and_tendon) in expected.items():
        muscle = scaled.character.muscles[name]
        assert (found[name], muscle.l_opt, muscle.l_slack) == pytest.approx((length, *fibre_and_tendon), abs=1e-5)
    still = scaled_segments(scene, factors)
    assert all(still.character.muscles[name].l_opt == scene.character.muscles[name].l_opt for name in expected)


def test_markers_scale_with_their_body(reference_data):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = load(reference_data / "opensim_models" / "arm26.osim")
    scaled = scaled_segments(scene, {"r_humerus": 1.2})
    before, after = (one.opensim.markers["r_humerus_epicondyle"].position for one in (scene, scaled))
    assert after == pytest.approx([1.2 * x for x in before])


def test_polynomial_path_is_not_scaled_in_silence():
    scene = muscle_scene()
    scene.character.muscles["HFL"].path = []
    scene.character.muscles["HFL"].polynomial = PolynomialPath(
        [next(n for n, j in scene.character.joints.items() if j.child == "lFoot")], [[0], [1]], [0.3, 0.02]
    )
    with pytest.raises(SceneError, match="its path is a polynomial, which cannot be scaled with the body 'lFoot'"):
        scaled_segments(scene, {"lFoot": 1.1})


def test_unknown_bodies_and_impossible_factors_are_errors():
    scene = muscle_scene()
    with pytest.raises(SceneError, match="no body is called 'lfoot'; did you mean 'lFoot'"):
        scaled_segments(scene, {"lfoot": 1.1})
    for factor in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(SceneError, match="positive factor"):
            scaled_segments(scene, {"lFoot": factor})
    for factor in (1e300, 1e-300, 1e7):  # whose fifth power is no number, or none that a body could have
        with pytest.raises(SceneError, match=r"between 1e-06 and 1e\+06"):
            scaled_segments(scene, {"lFoot": factor})


def follower_scene() -> Scene:
    scene = muscle_scene()
    scene.character.muscles["HFL"].f_max = Free(1000.0, 500.0, 2000.0, step=10.0)
    scene.character.muscles["TFL"].f_max = Free(same_as="character.muscles.HFL.f_max", factor=0.5)
    return scene


def test_free_numbers_are_multiplied_with_their_intervals():
    muscles = multiplied(follower_scene(), {"character.muscles.HFL.l_opt": 2.0, "character.muscles.HFL.f_max": 0.5})
    muscles = muscles.character.muscles
    assert muscles["HFL"].f_max == Free(500.0, 250.0, 1000.0, step=5.0)
    assert muscles["HFL"].l_opt == 0.4
    assert muscles["TFL"].f_max == Free(same_as="character.muscles.HFL.f_max", factor=1.0)  # 500 N as before


@pytest.mark.parametrize(("names", "forces"), [("HT", (500, 250)), ("H", (500, 500)), ("T", (1000, 250))])
def test_only_the_numbers_named_change_also_where_one_follows_another(names, forces):
    paths = {"H": "character.muscles.HFL.f_max", "T": "character.muscles.TFL.f_max"}
    scene = multiplied(follower_scene(), {paths[name]: 0.5 for name in names})
    check_scene(scene)
    values = numbers(scene)
    assert (values[paths["H"]], values[paths["T"]]) == forces


def test_points_that_a_number_goes_through_change_with_it_and_with_what_it_follows():
    scene = follower_scene()
    f_max = "character.muscles.HFL.f_max"
    scene.character.muscles["TFL"].f_max = Free(same_as=f_max, through=((600.0, 50.0), (1800.0, 90.0)))
    before = numbers(scene)["character.muscles.TFL.f_max"]
    assert numbers(multiplied(scene, {f_max: 2.0}))["character.muscles.TFL.f_max"] == pytest.approx(before)
    halved = multiplied(scene, {f_max: 2.0, "character.muscles.TFL.f_max": 0.5})
    assert numbers(halved)["character.muscles.TFL.f_max"] == pytest.approx(0.5 * before)
    assert halved.character.muscles["TFL"].f_max.through == ((1200.0, 25.0), (3600.0, 45.0))


def test_what_cannot_be_multiplied_is_a_clear_error():
    scene = follower_scene()
    with pytest.raises(SceneError, match=r"TFL.f_max: follows character.muscles.HFL.f_max, which would be 0"):
        multiplied(scene, {"character.muscles.HFL.f_max": 0.0})
    with pytest.raises(SceneError, match="no number here"):
        multiplied(scene, {"name": 2.0})
    log = msgspec.structs.replace(scene, gravity=Free(9.8, 1.0, 10.0, scale="log"))
    with pytest.raises(SceneError, match="gravity: cannot be multiplied by -1"):
        multiplied(log, {"gravity": -1.0})
    assert multiplied(scene, {}) == scene


def test_what_shapes_are_made_of_stays_as_it_is():
    scene = load("fwalk")
    scene.ground.law = "hunt_crossley"
    name = next(name for name, body in scene.character.bodies.items() if body.shapes)
    scene.character.bodies[name].shapes = [Sphere((0.0, 0.1, 0.0), 0.05, ContactMaterial(1e6, 2.0))]
    (shape,) = scaled_segments(scene, {name: 1.5}).character.bodies[name].shapes
    assert isinstance(shape, Sphere)
    assert shape.radius == pytest.approx(0.075)
    assert shape.material == ContactMaterial(1e6, 2.0)
