"""Terms of the objective: on motions whose values are known, and as parts of the cost."""

import msgspec
import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled
from scipy.spatial.transform import Rotation

import kernel_tests
from muscle_arm import arm, constant, leg
from short_walks import OF_TORQUES
from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gait.cycles import body_weight, leg_angles
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.joint_moments import leg_moments
from warpmuscle.kernels.contact.gait_cycle import width_from_line
from warpmuscle.kernels.muscle.muscle import LARGEST_PASSIVE
from warpmuscle.kernels.objective import term_functions
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.structs import HINGE, Model, Scratch, Skeleton, State
from warpmuscle.model.objective import counted_terms, objective_kind
from warpmuscle.scene import InitialState, JointState, MuscleModel, Objective, Scene
from warpmuscle.scene.accounting import FORMULAS
from warpmuscle.scene.masses import DENSITY, muscle_mass
from warpmuscle.scene.norms import NORMS, PERCENT_OF_BIN, RUNNING_FORCE_BAND, running_force
from warpmuscle.scene.number import Free
from warpmuscle.scene.people.pinzone_two import SEARCHED_MOMENTS
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

ONES = dict.fromkeys(TERMS, 1.0) | {"tracking": 0.0}
WALKS_ONLY = {"norms": 0.0, "norm_force": 0.0, "norm_moments": 0.0, "step_width": 0.0, "stride_speed": 0.0}
EVERY = Objective(**ONES | WALKS_ONLY, head_body="tip")
ACTIVE = 0.6


def held(**changes) -> Scene:
    """An arm whose muscles have been equally active from the start, so that it hangs still, for a second."""
    scene = arm("hinge", {"excitation": constant(ACTIVE)}, duration=1.0, objective=EVERY, **changes)
    scene.character.muscles["extensor"].excitation = constant(ACTIVE)
    scene.muscle_model = MuscleModel(initial_activation=ACTIVE)
    return scene


def values(scene: Scene, instances: int = 1, **options) -> dict[str, np.ndarray]:
    rollout = recorded(scene, instances, **options)
    rollout.run()
    return rollout.terms()


def recorded(scene: Scene, instances: int = 1, **options) -> Rollout:
    """A batch whose first instance is recorded, also where no test looks at it: so all share one kernel."""
    return Rollout(scene, instances, "cpu", record=[0], **options)


def test_no_term_weighs_anything_by_default_and_each_has_a_unit():
    assert Objective.__struct_fields__[: len(TERMS)] == tuple(TERMS)
    assert not any(getattr(Objective(), name) for name in TERMS)
    assert all(term.unit and term.description for term in TERMS.values())


def test_each_metabolic_model_of_a_scene_is_summed_by_a_function_of_its_own():
    scene = msgspec.structs.replace(load("walk56"), objective=Objective(metabolic=1.0))
    for model in FORMULAS:
        scene.objective.metabolic_model = model
        assert objective_kind(scene, True).muscle == (f"metabolic_{model}",)


def test_only_terms_with_a_weight_are_summed_and_torque_always():
    assert counted_terms(Objective()) == ("torque",)
    assert counted_terms(Objective(torque=0.0, speed=2.0)) == ("torque", "speed")
    assert counted_terms(Objective(effort_cubed=Free(0.0, 0.0, 1.0))) == ("torque", "effort_cubed")


@pytest.mark.long
def test_efforts_of_two_muscles_at_constant_activation():
    terms = values(held())
    np.testing.assert_allclose(terms["effort_squared"], 2.0 * ACTIVE**2, rtol=1e-5)
    np.testing.assert_allclose(terms["effort_cubed"], 2.0 * ACTIVE**3, rtol=1e-5)
    mass = sum(muscle_mass(muscle, 6e5) for muscle in held().character.muscles.values())
    np.testing.assert_allclose(terms["mass_effort_squared"], mass * ACTIVE**2, rtol=1e-5)
    np.testing.assert_allclose(terms["mass_effort_cubed"], mass * ACTIVE**3, rtol=1e-5)


@pytest.mark.parametrize(("slow", "tensions"), [(0.5, [6e5, 6e5]), (1.0, [6e5, 6e5]), (0.5, [3e5, 1.5e6])])
def test_metabolic_energy_of_muscles_held_still(slow: float, tensions: list[float]):
    """Heat of activation and maintenance alone (Wang 2012), at the length that the tendon leaves the fibre."""
    scene = held()
    if tensions[1] != 6e5:  # of the muscle model, and of the second muscle itself
        scene.muscle_model.specific_tension = tensions[0]
        list(scene.character.muscles.values())[1].specific_tension = tensions[1]
    scene.muscle_model.damping = 0.0
    scene.objective = msgspec.structs.replace(EVERY, basal_rate=0.0)
    expected = 0.0
    for muscle, tension in zip(scene.character.muscles.values(), tensions, strict=True):
        muscle.slow_fibres = slow
        x = (0.3 - muscle.l_slack) / muscle.l_opt
        u = slow * np.sin(np.pi / 2 * ACTIVE), (1.0 - slow) * (1.0 - np.cos(np.pi / 2 * ACTIVE))
        mass = muscle.f_max * muscle.l_opt * DENSITY / tension
        maintained = np.interp(x, [0.5, 1.0, 1.5], [0.5, 1.0, 0.0])
        expected += mass * (40.0 * u[0] + 133.0 * u[1] + maintained * (74.0 * u[0] + 111.0 * u[1]))
    np.testing.assert_allclose(values(scene)["metabolic"], expected, rtol=2e-3)


def test_the_body_at_rest_costs_its_basal_rate_and_transport_counts_a_metre_at_least():
    scene = held()
    terms, mass = values(scene), 4.0
    still = values(msgspec.structs.replace(scene, objective=msgspec.structs.replace(EVERY, basal_rate=0.0)))
    np.testing.assert_allclose(terms["metabolic"] - still["metabolic"], 1.51 * mass * 1.0, rtol=1e-6)
    np.testing.assert_allclose(terms["cost_of_transport"], terms["metabolic"] / mass, rtol=1e-6)


def test_speed_error_of_what_stands_still_is_the_target_squared():
    scene = held()
    scene.objective = msgspec.structs.replace(EVERY, target_speed=1.5)
    np.testing.assert_allclose(values(scene)["speed"], 1.5**2, rtol=1e-4)


def test_turning_of_the_head_is_its_squared_angular_velocity_over_time():
    scene = arm("hinge", {"excitation": constant(0.8)}, duration=0.3, objective=EVERY)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    turning = np.sum(rollout.recording().joint_angular_velocity ** 2) * scene.time_step
    assert turning > 0.1
    np.testing.assert_allclose(rollout.terms()["head"], turning, rtol=1e-5)


def test_torques_of_limits_count_only_where_a_joint_is_beyond_them():
    scene = leg(duration=0.2, objective=msgspec.structs.replace(EVERY, head_body="shank"))
    scene.initial_state = InitialState((0.0, 1.0, 0.0), joints={"knee": JointState(angular_velocity=(5.0, 0.0, 0.0))})
    free = values(scene)
    scene.character.joints["knee"].limits = [(-0.05, 0.05)]
    stopped = values(scene)
    assert free["joint_limits"][0] == 0.0
    assert stopped["joint_limits"][0] > 1.0


@wp.kernel(enable_backward=False)
def excess(model: Model, state: State, work: Scratch, found: wp.array[wp.vec3]):
    its = work
    found[0] = term_functions.torque_of_limits(0, 1, model, state, its)


def test_asking_for_the_torque_of_limits_leaves_the_body_as_it_was():
    plan = {"joint_type": [0, HINGE], "parent": [-1, 0], "has_limits": [0, 1]}
    limits = {"low": [[[-0.5, 0.0, 0.0]] * 2], "high": [[[0.4, 0.0, 0.0]] * 2], "stiffness": [[400.0] * 2]}
    row = {"axis_a": [[[1.0, 0.0, 0.0]] * 2]}
    model = filled(Model, time_step=0.001, skeleton=filled(Skeleton, plan=plan, row=row, limits=limits))
    one = np.ones((1, 1), np.float32)
    state = filled(State, coordinates=0.6 * one, speeds=0.0 * one, accelerations=0.0 * one)
    torque, stiff = np.array([[0.0] * 3, [7.0, 8.0, 9.0]]), np.array([[0.0] * 6, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]])
    work = filled(Scratch, rotation=np.tile(np.eye(3), (2, 1, 1)), torque=torque, stiffness=stiff)
    found = wp.zeros(1, dtype=wp.vec3, device="cpu")
    wp.launch(excess, 1, [model, state, work, found], device="cpu")
    assert np.linalg.norm(found.numpy()) == pytest.approx(400.0 * 0.2, rel=1e-3)
    np.testing.assert_array_equal(work.torque.numpy(), torque)
    np.testing.assert_array_equal(work.stiffness.numpy().reshape(2, 6), stiff)


def walked(name: str, duration: float, weights: dict[str, float], gait: str = "") -> Rollout:
    """The start of a shipped walk, every step of it recorded."""
    scene = msgspec.structs.replace(load(name), duration=duration, objective=Objective(**weights, gait=gait))
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    return rollout


@pytest.fixture(scope="module")
def walk() -> Rollout:
    """Some steps of a walk on torques, with all terms of these."""
    with kernel_tests.optimized():
        return walked("fwalk", 3.0, OF_TORQUES)


def percent_of_cycle(recording, side: int, weight: float) -> np.ndarray:
    """Where a leg is in its gait cycle, to a hundredth of it.

    That is the time since its foot touched down over the length of the cycle that ended then; before the foot has
    landed twice, the phase of the controller.
    """
    step = 0.5 * np.minimum(recording.phase, 1.0)
    part = step + np.where(recording.stance == side, 0.0, 0.5)
    landings = touch_downs(recording, SIDES[side], weight)
    for before, last, end in zip(landings[:-1], landings[1:], [*landings[2:], np.inf], strict=True):
        here = (recording.time >= last) & (recording.time < end)
        part[here] = np.minimum((recording.time[here] - last) / (last - before), 1.0)
    return np.clip((part * 100.0).astype(int), 0, 99) + 0.5


def test_norms_are_squared_half_widths_between_legs_and_human_ones(walk: Rollout):
    recording = walk.recording()
    angles = leg_angles(recording, walk.numeric)
    total = np.zeros(len(recording.time))
    for title, sides in angles.items():
        for number, side in enumerate(SIDES):
            human = NORMS[title].mean(percent_of_cycle(recording, number, body_weight(walk.numeric)))
            total += ((sides[side] - human) / NORMS[title].half_width) ** 2
    expected = total[:-1].mean() * walk.end_time()[0]
    assert expected > 5.0
    np.testing.assert_allclose(walk.terms()["norms"], expected, rtol=0.01)


def test_norm_moments_are_squared_deviations_between_moments_of_legs_and_peoples(walk: Rollout):
    """Beside what the judge of gaits makes of the recorded torques in float64; people's are typed numbers."""
    recording = walk.recording()
    total, most = np.zeros(len(recording.time)), 0.0
    for title, sides in leg_moments(recording, walk.numeric).items():
        deviation = SEARCHED_MOMENTS[title].sd(PERCENT_OF_BIN).mean()
        for number, side in enumerate(SIDES):
            percent = percent_of_cycle(recording, number, body_weight(walk.numeric))
            away = (sides[side] - SEARCHED_MOMENTS[title].mean(percent)) / deviation
            total += np.minimum(away**2, 16.0)
            most = max(most, np.abs(away).max())
    expected = total[:-1].mean() * walk.end_time()[0]
    assert expected > 5.0
    assert most > 4.0
    np.testing.assert_allclose(walk.terms()["norm_moments"], expected, rtol=0.02)


def test_norm_force_is_the_same_of_vertical_forces_in_body_weights(walk: Rollout):
    norm = NORMS["Vertical ground force"]
    check_force(walk, norm.mean, norm.half_width)


def test_norm_force_of_a_run_is_half_a_sine_that_carries_the_body():
    assert 2.0 * running_force(np.linspace(0.0, 100.0, 100_001)).mean() == pytest.approx(1.0, abs=1e-4)
    check_force(walked("fwalk", 3.0, OF_TORQUES | {"norm_moments": 0.0}, gait="run"), running_force, RUNNING_FORCE_BAND)


def check_force(rollout, mean, half_width):
    recording = rollout.recording()
    total = np.zeros(len(recording.time))
    for number, side in enumerate(SIDES):
        force = recording[f"foot_force_{side}"][:, 1] / body_weight(rollout.numeric)
        percent = percent_of_cycle(recording, number, body_weight(rollout.numeric))
        total += ((force - mean(percent)) / half_width) ** 2
    np.testing.assert_allclose(rollout.terms()["norm_force"], total.mean() * rollout.end_time()[0], rtol=0.02)


def test_passive_force_is_that_of_fibres_stretched_beyond_their_optimum():
    rollout = walked("walk56", 1.0, ONES)
    recording, muscles = rollout.recording(), rollout.numeric.character.muscles
    total = 0.0
    for index, name in enumerate(recording.muscle_names):
        stretch = recording.muscle_fibre_length[:, index] / muscles[name].l_opt - 1.0
        passive = np.where(stretch > 0.0, np.expm1(4.0 * stretch / 0.6) / np.expm1(4.0), 0.0)  # Bergmann 2017, eq. 6
        total += muscles[name].f_max * np.minimum(passive, LARGEST_PASSIVE).mean()
    assert total > 100.0
    np.testing.assert_allclose(rollout.terms()["passive_force"], total * rollout.end_time()[0], rtol=0.01)


def test_step_width_is_how_far_the_other_foot_stands_from_the_line_of_a_foot_s_placements(walk: Rollout):
    recording = walk.recording()
    downs = sorted((time, side) for side in (0, 1) for time in touch_downs(recording, SIDES[side]))
    expected, width, last = 0.0, {}, {0: [], 1: []}
    ends = [*(time for time, _ in downs[1:]), walk.end_time()[0]]
    for (time, side), end in zip(downs, ends, strict=True):
        foot = recording.position_of("lr"[side] + "Foot")
        last[side].append(np.array([np.interp(time, recording.time, foot[:, axis]) for axis in (0, 2)]))
        if len(last[side]) > 1 and last[1 - side]:
            (x, z), (ox, oz) = last[side][-1] - last[side][-2], last[1 - side][-1] - last[side][-1]
            width[side] = (1.0 if side else -1.0) * (ox * z - oz * x) / np.hypot(x, z)  # the left of z is x
        expected += sum((one - 0.08) ** 2 for one in width.values()) * (end - time)
    assert len(width) == 2
    np.testing.assert_allclose(walk.terms()["step_width"], expected, rtol=0.1)


def test_stride_speed_is_what_a_foot_goes_from_landing_to_landing_over_the_time_between(walk: Rollout):
    recording, end = walk.recording(), float(walk.end_time()[0])
    target, expected = walk.numeric.objective.target_speed, 0.0
    for side in (0, 1):
        downs = touch_downs(recording, SIDES[side])
        foot = recording.position_of("lr"[side] + "Foot")[:, 2]
        places = np.interp(downs, recording.time, foot)
        fine = np.linspace(0.0, end, 20001)
        landed = np.searchsorted(downs, fine, side="right")
        speed = np.interp(fine, recording.time, recording.com_velocity[:, 2])
        for count in range(2, len(downs) + 1):
            now = landed == count
            length = downs[count - 1] - downs[count - 2]
            speed[now] = (places[count - 1] - places[count - 2]) / np.maximum(length, fine[now] - downs[count - 1])
        assert len(downs) > 1
        expected += np.mean((speed - target) ** 2) * end
    np.testing.assert_allclose(walk.terms()["stride_speed"], expected, rtol=0.05)


def test_rise_is_how_far_the_centre_of_mass_came_above_its_start_and_lowers_the_cost(walk: Rollout):
    height = walk.recording().com[:, 1]
    assert 0.005 < height.max() - height[0] < 0.2
    assert height[-1] < height.max()
    np.testing.assert_allclose(walk.terms()["rise"], height[0] - height.max(), atol=2e-4)


@pytest.mark.parametrize("way", [0.0, 0.7, 3.0])
@pytest.mark.parametrize("width", [0.12, -0.04])
def test_width_from_a_line_is_signed_and_does_not_depend_on_the_way_that_one_walks(way: float, width: float):
    turn = Rotation.from_euler("y", way)
    for side, outwards in ((0, 1.0), (1, -1.0)):
        before, place, other = np.array([[0, 0, 0], [0, 0, 1.2], [-outwards * width, 0, 0.6]], dtype=float)
        facing = turn.apply([np.sin(0.4), 0.0, np.cos(0.4)])
        found = evaluate(width_from_line, turn.apply(before), turn.apply(place), turn.apply(other), facing, side)
        np.testing.assert_allclose(found, width, atol=1e-6)
        backwards = evaluate(width_from_line, turn.apply(place), turn.apply(before), turn.apply(other), facing, side)
        np.testing.assert_allclose(backwards, width, atol=1e-6)


def test_without_feet_there_is_no_step_width():
    with pytest.raises(SceneError, match=r"step_width.*no feet"):
        check_scene(msgspec.structs.replace(arm("hinge", {}), objective=Objective(step_width=1.0)))


@pytest.mark.parametrize("term", ["norms", "norm_force", "norm_moments"])
def test_what_does_not_walk_is_not_compared_with_human_walking(term: str):
    with pytest.raises(SceneError, match=f"{term}.*no feet"):
        check_scene(msgspec.structs.replace(arm("hinge", {}), objective=Objective(**{term: 1.0})))
    scene = sound_scene()
    scene.objective = Objective(**{term: 1.0})
    with pytest.raises(SceneError, match="has no hip, knee and ankle"):
        check_scene(scene)


def test_moments_of_people_who_run_are_not_known():
    with pytest.raises(SceneError, match="walking only"):
        check_scene(msgspec.structs.replace(load("fjog"), objective=Objective(norm_moments=1.0, gait="run")))


@pytest.mark.usefixtures("optimized_test")
def test_cost_is_the_weighted_sum_and_a_failure_costs_more():
    scene = load("fwalk")
    weights = {name: 0.5 + number for number, name in enumerate(OF_TORQUES)}
    scene = msgspec.structs.replace(scene, duration=2.5, objective=Objective(**weights))  # steps have a width by then
    rollout = recorded(scene)
    rollout.run()
    terms = rollout.terms()
    expected = sum(weight * terms[name] for name, weight in weights.items())
    np.testing.assert_allclose(rollout.cost(), expected, rtol=1e-6)
    assert terms["torque"][0] > 100.0
    assert all(terms[name][0] * TERMS[name].factor > 0.0 for name in weights)
    state = InitialState((0.0, 3.0, 0.0))
    weak = msgspec.structs.replace(scene, duration=1.0, objective=Objective(fall=1.0), initial_state=state)
    rollout = Rollout(weak, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] != Status.COMPLETED
    np.testing.assert_allclose(rollout.terms()["fall"], 1.0 - rollout.end_time())
    assert rollout.cost()[0] > 1e6


@pytest.mark.usefixtures("optimized_test")
def test_without_muscles_applied_torque_is_the_feedback_torque():
    scene = msgspec.structs.replace(load("fwalk"), duration=0.5, objective=Objective(**OF_TORQUES))
    terms = values(scene)
    np.testing.assert_allclose(terms["applied_torque"], terms["torque"], rtol=1e-6)


def test_terms_do_not_depend_on_batch_threads_or_chunks():
    scene = msgspec.structs.replace(load("walk56"), duration=0.3, objective=Objective(**ONES))
    alone, among = values(scene), values(scene, 5, threads=2)
    rollout = recorded(scene)
    for _ in range(6):
        rollout.run(0.05)
    for name, value in rollout.terms().items():
        assert value[0] == alone[name][0] == among[name][4], name


def test_legs_that_cross_fail_where_the_scene_says_so():
    scene = msgspec.structs.replace(load("fwalk"), duration=1.0)
    for hip, angle in (("lHip", -0.4), ("rHip", 0.4)):
        scene.initial_state.joints[hip] = JointState((0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)))
    outcome = []
    for largest in (0.0, 0.05):
        scene.failure.leg_crossing = largest
        rollout = recorded(scene)
        rollout.run()
        outcome.append(Status(rollout.status()[0]))
    assert outcome[1] == Status.CROSSED
    assert outcome[0] != Status.CROSSED


def test_a_head_that_is_no_body_is_named():
    scene = sound_scene()
    scene.objective = Objective(head=1.0, head_body="haed")
    with pytest.raises(SceneError, match="haed"):
        check_scene(scene)


def test_what_joints_and_muscles_add_to_terms_sums_up_to_them():
    rollout = recorded(held(), 2)
    rollout.run()
    terms, parts = rollout.terms(), rollout.parts(1)
    assert set(parts["effort_squared"]) == {"flexor", "extensor"}
    assert set(parts["metabolic"]) == {"flexor", "extensor", "basal rate"}
    assert set(parts["cost_of_transport"]) == set(parts["metabolic"])
    assert not {"speed", "heading", "head", "fall"} & set(parts)
    for name, own in parts.items():
        assert sum(own.values()) == pytest.approx(terms[name][1], rel=1e-6)


@pytest.mark.usefixtures("optimized_test")
def test_gait_cycles_begin_anew_after_a_reset_and_do_not_depend_on_the_batch():
    scene = msgspec.structs.replace(load("fwalk"), duration=2.5, objective=Objective(**OF_TORQUES))
    alone, batch = recorded(scene), recorded(scene, 3)
    for rollout in (alone, batch):
        rollout.run()
    first = batch.terms()
    for name in ("norms", "norm_force"):
        np.testing.assert_array_equal(first[name], np.repeat(alone.terms()[name], 3))
    batch.reset(mask=np.array([False, True, False]))
    batch.step(round(2.5 / scene.time_step))
    for name in ("norms", "norm_force"):
        np.testing.assert_array_equal(batch.terms()[name], first[name])


def test_umbergers_power_counts_each_muscles_own_mass():
    """Two mirror images at rest, one of twice the strength and so of twice the mass: twice the least heat, 1 W/kg."""
    scene = arm(flexor={"f_max": 800.0}, gravity=0.0, duration=0.02)
    scene.objective = Objective(metabolic=1.0, metabolic_model="umberger", basal_rate=0.0)
    rollout = recorded(scene)
    rollout.run()
    spent = rollout.parts(0)["metabolic"]
    assert spent["extensor"] > 0.0
    assert spent["flexor"] == pytest.approx(2.0 * spent["extensor"], rel=0.01)
