"""Activations from files against OpenSim's published ones; EMG, elastic tendons, reserves and what is refused."""

import numpy as np
import pytest

from opensim_table import table
from osim_models import written
from small_leg import loads, motion, small_leg, text
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.load import load
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.as_opensim.differences import choices
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.static_optimization import static_optimization


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def test_activations_are_those_that_opensim_published(reference_data):
    folder = reference_data / "inverse" / "static_optimization_92"
    body = BodyModel(folder / "subject01_simbody_adjusted_StaticOp.osim", "cpu")
    coordinates = read_coordinates(folder / "subject01_walk1_Kinematics.sto", body.scene)
    _, names, rows = table(folder / "subject01_StaticOptimization_activation.sto")
    found = static_optimization(
        body,
        coordinates,
        read_loads(folder / "foot_floor_loads.xml"),
        times=np.minimum(rows[:, 0], coordinates.times[-1]),
    )
    theirs = rows[:, [names.index(name) for name in found.muscles]]
    worst = np.abs(found.activation - theirs).max(axis=1)
    assert np.median(worst) < 0.005
    assert worst.max() < 0.01
    assert not found.unconverged
    assert not found.flagged()
    _, names, rows = table(folder / "subject01_StaticOptimization_force.sto")
    theirs = rows[:, [names.index(name) for name in found.muscles]]
    assert np.abs(found.force - theirs).max() < 0.01 * theirs.max()


def test_fibres_of_millard_pull_at_no_angle_as_in_opensim_unless_asked_for(body):
    """OpenSim 4.6 asks for the angle of a fibre with its length over the optimal one in place of metres."""
    at = motion()
    found, angled = (
        static_optimization(body, at, loads(at.times), reserve=10.0, pennation=one) for one in (False, True)
    )
    for k, name in enumerate(body.muscles):
        l_opt, angle = (float(getattr(body.muscle(name), field)) for field in ("l_opt", "pennation"))
        length, width = found.fibre_length[:, k], l_opt * np.sin(angle)
        cosine, theirs = np.sqrt(1.0 - (width / length) ** 2), np.sqrt(1.0 - (width * l_opt / length) ** 2)
        strength, own = (one.force[:, k] / one.activation[:, k] for one in (found, angled))
        assert strength / own == pytest.approx(theirs / cosine, rel=1e-5)
        assert width == 0.0 or (strength > own).all()
    assert any(body.muscle(name).pennation for name in body.muscles)


def test_fibres_of_de_groote_pull_as_along_themselves_as_in_opensim(tmp_path):
    """OpenSim 4.6 takes `activeFiberForce`, which is along the fibre, for that along the tendon."""
    words = text().replace("Millard2012EquilibriumMuscle", "DeGrooteFregly2016Muscle")
    body, at = BodyModel(written(tmp_path, words), "cpu"), motion(8)
    found, angled = (
        static_optimization(body, at, loads(at.times), reserve=10.0, least=0.01, pennation=one) for one in (False, True)
    )
    for k, name in enumerate(body.muscles):
        width = float(body.muscle(name).l_opt) * np.sin(float(body.muscle(name).pennation))
        cosine = np.sqrt(1.0 - (width / found.fibre_length[:, k]) ** 2)
        strength, own = (one.force[:, k] / one.activation[:, k] for one in (found, angled))
        assert own / strength == pytest.approx(cosine, rel=1e-5)


def test_activations_keep_within_the_controls_of_an_opensim_model(tmp_path):
    kind = '<Millard2012EquilibriumMuscle name="{}">'
    words = text()
    for name, low, high in (("rectus", 0.2, 1.0), ("hamstrings", 0.01, 1.5)):
        own = kind.format(name)
        assert own in words
        words = words.replace(own, f"{own}<min_control>{low}</min_control><max_control>{high}</max_control>")
    body, at = BodyModel(written(tmp_path, words), "cpu"), motion(8)
    assert body.scene.opensim.controls == {"rectus": (0.2, 1.0), "hamstrings": (0.01, 1.5)}
    found = static_optimization(body, at, loads(at.times), reserve=1e-3)
    least, most = (dict(zip(found.muscles, end, strict=True)) for end in np.quantile(found.activation, (0, 1), axis=0))
    assert least["rectus"] == pytest.approx(0.2)
    assert min(least.values()) == pytest.approx(0.01)
    assert most["hamstrings"] == pytest.approx(1.5)
    assert max(value for name, value in most.items() if name != "hamstrings") == 1.0


def test_controls_whose_least_is_above_the_greatest_are_told(tmp_path):
    own = '<Millard2012EquilibriumMuscle name="rectus">'
    words = text().replace(own, f"{own}<min_control>0.9</min_control><max_control>0.2</max_control>")
    ignored: list[Ignored] = []
    scene = load(written(tmp_path, words), ignored=ignored)
    assert scene.opensim.controls == {}
    assert any("min_control, 0.9, is above its max_control, 0.2" in one.reason for one in ignored)


def test_whether_pennation_counts_is_told_with_what_the_other_way_changes(body):
    at = motion(8)
    given = loads(at.times)
    found = [static_optimization(body, at, given, reserve=10.0, pennation=one).activation for one in (False, True)]
    most = np.abs(found[0] - found[1]).max()
    assert most > 1e-3
    for one, words in (
        (False, "is left out, as in OpenSim; with it (--pennation)"),
        (True, "is taken into account; without it"),
    ):
        options = ActivationOptions(reserve=10.0, pennation=one)
        (choice,) = choices(body, ("so",), [at], [given], [at.times], options=options)
        assert words in choice.sentence
        assert f"differ by up to {most:.2g} (" in choice.sentence
    for steps, options in ((("id",), ActivationOptions()), (("so",), ActivationOptions(elastic=True))):
        assert choices(body, steps, [at], [given], [at.times], options=options) == []


def test_pennate_muscles_are_as_in_opensim(reference_data, tmp_path):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    folder = reference_data / "opensim_walk"
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder}")
    opensim.Logger.setLevelString("off")
    path = str(folder / "subject01.osim")
    body = BodyModel(path, "cpu")
    reserves = opensim.ForceSet()
    strengths = {name: 100.0 if name.startswith(("pelvis", "lumbar")) else 1.0 for name in body.map.names}
    for name, strength in strengths.items():
        reserve = opensim.CoordinateActuator(name)
        reserve.setName(f"{name}_reserve")
        reserve.setOptimalForce(strength)
        reserve.setMinControl(-1000.0)
        reserve.setMaxControl(1000.0)
        reserves.cloneAndAppend(reserve)
    reserves.printToXML(str(tmp_path / "reserves.xml"))
    tool = opensim.AnalyzeTool()
    tool.setName("walk")
    tool.setModelFilename(path)
    tool.setCoordinatesFileName(str(folder / "ik" / "subject01_walk_IK.mot"))
    tool.setExternalLoadsFileName(str(folder / "subject01_walk_grf.xml"))
    tool.setLowpassCutoffFrequency(6.0)
    tool.setInitialTime(0.8)
    tool.setFinalTime(0.9)
    tool.setResultsDir(str(tmp_path))
    files = opensim.ArrayStr()
    files.append(str(tmp_path / "reserves.xml"))
    tool.setForceSetFiles(files)
    tool.setReplaceForceSet(False)
    analysis = opensim.StaticOptimization()
    analysis.setStartTime(0.8)
    analysis.setEndTime(0.9)
    analysis.setConvergenceCriterion(1e-6)
    tool.updAnalysisSet().cloneAndAppend(analysis)
    tool.printToXML(str(tmp_path / "tool.xml"))
    opensim.AnalyzeTool(str(tmp_path / "tool.xml")).run()
    _, names, rows = table(tmp_path / "walk_StaticOptimization_activation.sto")
    coordinates = read_coordinates(folder / "ik" / "subject01_walk_IK.mot", body.scene)
    plates = read_loads(folder / "subject01_walk_grf.xml")
    found = static_optimization(body, coordinates, plates, filter=6.0, times=rows[:, 0], reserve=strengths)
    theirs = rows[:, [names.index(name) for name in found.muscles]]
    assert np.abs(found.activation - theirs).max() < 1e-3  # 0.036 with the angle


def test_muscles_make_the_moments_with_reserves(body):
    at = motion()
    found = static_optimization(body, at, loads(at.times), reserve=10.0)
    assert set(found.unmuscled) == set(at.names[:6])
    assert found.reserve[:, :6] == pytest.approx(found.moments.values[:, :6])
    assert found.force == pytest.approx(found.activation * found.force.max() / found.activation.max(), rel=10.0)
    power = np.sum(found.power, axis=1)
    rates = np.gradient(at.values, at.times, axis=0)
    needed = np.sum((found.moments.values - found.reserve)[:, 6:] * rates[:, 6:], axis=1)
    middle = slice(3, -3)
    assert power[middle] == pytest.approx(needed[middle], abs=0.02 * np.abs(needed).max())


def test_a_reserve_beyond_five_percent_flags_its_frame(body):
    at = motion()
    found = static_optimization(body, at, loads(at.times), reserve={"": 0.1, "knee_angle": 50.0})
    flagged = found.flagged()
    assert {name for _, name, _ in flagged} <= set(at.names[6:])
    peak = np.abs(found.moments.values[:, at.names.index("knee_angle")]).max()
    frames = [frame for frame, name, _ in flagged if name == "knee_angle"]
    wanted = np.abs(found.reserve[:, at.names.index("knee_angle")]) > 0.05 * peak
    assert frames == np.flatnonzero(wanted).tolist()


def test_emg_draws_activations_towards_it_at_any_rate(body):
    at = motion()
    times = np.linspace(-0.1, 1.0, 777)  # another rate than the motion's
    emg = Emg(("gastrocnemius",), times, np.full((777, 1), 0.5))
    plain, weak, strong = (
        static_optimization(body, at, emg=emg, emg_weight=weight, reserve=5.0).activation[:, 8]
        for weight in (0.0, 1.0, 100.0)
    )
    away = [np.abs(one - 0.5).mean() for one in (plain, weak, strong)]
    assert away[0] > away[1] > away[2]
    assert away[2] < 0.1


def test_elastic_tendons_shorten_the_fibres_of_muscles_that_pull(body):
    at = motion()
    rigid, elastic = (
        static_optimization(body, at, loads(at.times), reserve=20.0, elastic=elastic) for elastic in (False, True)
    )
    pulling = (rigid.activation > 0.3) & (elastic.activation > 0.3)
    assert pulling.any()
    assert (elastic.fibre_length < rigid.fibre_length)[pulling].mean() > 0.9
    assert not elastic.unconverged


def test_passive_forces_take_a_part_of_the_moments_where_told(body):
    at = motion()
    without, with_passive = (
        static_optimization(body, at, loads(at.times), reserve=20.0, passive=passive) for passive in (False, True)
    )
    assert (with_passive.force >= -1e-3).all()
    assert not np.array_equal(without.activation, with_passive.activation)


def test_forces_without_physiology_are_activations_times_strength(body):
    at = motion(10)
    found = static_optimization(body, at, physiology=False, reserve=5.0)
    assert found.force == pytest.approx(found.activation * 1500.0, rel=1e-5)


def test_many_trials_are_as_each_alone(body):
    trials = [motion(12, seed=seed) for seed in range(3)]
    together = static_optimization(body, trials, [loads(one.times) for one in trials], reserve=5.0)
    for one, found in zip(trials, together, strict=True):
        alone = static_optimization(body, one, loads(one.times), reserve=5.0)
        assert np.array_equal(alone.activation, found.activation)
        assert np.array_equal(alone.moments.values, found.moments.values)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"power": 5}, "power is 1, 2, 3 or 4"),
        ({"weight": "mass"}, "volume"),
        ({"reserve": 0.0}, "strength"),
        ({"reserve": {"knee": 1.0}}, "no coordinate 'knee'"),
        ({"least": 1.0}, "least"),
        ({"emg_weight": -1.0}, "emg_weight"),
        ({"emg_weight": 1.0, "power": 3}, "EMG counts beside squares"),
        ({"exponent": 2}, "no option 'exponent'"),
    ],
)
def test_options_that_are_none_are_refused_in_a_line(body, options, words):
    with pytest.raises(ArgumentError, match=words) as error:
        static_optimization(body, motion(10), **options)
    assert "\n" not in str(error.value)


def test_emg_of_another_time_muscle_or_range_is_refused(body):
    times = np.linspace(5.0, 6.0, 50)
    with pytest.raises(ArgumentError, match="the EMG reaches from 5 to 6 s"):
        static_optimization(body, motion(10), emg=Emg(("rectus",), times, np.zeros((50, 1))), emg_weight=1.0)
    with pytest.raises(ArgumentError, match="not a muscle of the model"):
        static_optimization(body, motion(10), emg=Emg(("biceps",), times - 5.0, np.zeros((50, 1))), emg_weight=1.0)
    with pytest.raises(ArgumentError, match="from 0 to 1"):
        Emg(("rectus",), times, np.full((50, 1), 80.0))
