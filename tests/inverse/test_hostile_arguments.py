"""What cannot be a recording, or an option of a step, is told in one line; nothing else than numbers comes out."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import warpmuscle as wm
from leg_model import chain_of, leg, markers_of, walk
from small_leg import NAMES, loads, motion, small_leg
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.emg_driven.calibrate import calibrate
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.inverse.trial import Coordinates, Loads, Markers

pytestmark = pytest.mark.filterwarnings("ignore:the force 'plate' acts")
MOTION, STRANGE = motion(), (None, 3, "walk.mot", {"a": 1.0}, np.zeros(3), [None], object())
FORCES = loads(MOTION.times)
PLATE = FORCES.plates[0]


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("body")), "cpu")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return leg(tmp_path_factory.mktemp("leg"))


def refused(work: Callable[[], object], message: str = ".", error: type[Error] = Error) -> None:
    with pytest.raises(error, match=message) as told:
        work()
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (MOTION.values.astype(str), "array of numbers"), (MOTION.values + 0j, "array of numbers"),
        (np.full(MOTION.values.shape, None), "array of numbers"), (MOTION.values > 0.0, "array of numbers"),
        (MOTION.values.T, "shape"), (None, "array of numbers"), ([[1.0], [1.0, 2.0]], "array of numbers"),
        (np.ma.masked_greater(MOTION.values, 0.5), "not a finite number in frame"),
    ],
)  # fmt: skip
def test_values_that_are_no_numbers_are_refused(values, message):
    refused(lambda: Coordinates(NAMES, MOTION.times, values), message, ArgumentError)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (MOTION.times.astype(str), "array of numbers"), (None, "array of numbers"), (MOTION.times[:, None], "shape"),
        (MOTION.times + np.inf, "increase"), (MOTION.times[::-1], "increase"), (1e-9 * MOTION.times, "in seconds"),
        (1e300 * MOTION.times, "in seconds"), (MOTION.times.astype("M8[s]"), "array of numbers"),
    ],
)  # fmt: skip
def test_times_that_are_none_are_refused_by_all_that_has_times(times, message):
    envelopes = np.full((len(MOTION.times), 1), 0.3)
    for work in (
        lambda: Coordinates(NAMES, times, MOTION.values), lambda: Emg(("rectus",), times, envelopes),
        lambda: Markers(("a",), times, np.zeros((40, 1, 3))), lambda: Loads(times, ()),
    ):  # fmt: skip
        refused(work, message, ArgumentError)


@pytest.mark.parametrize("names", [None, "abcdefghijk", range(11), (NAMES[0],) * 11])
def test_names_that_are_none_are_refused(names):
    refused(lambda: Coordinates(names, MOTION.times, MOTION.values), "name", ArgumentError)


def test_lists_and_numbers_of_other_kinds_are_as_the_same_ones_of_double_precision(body):
    usual = wm.inverse_dynamics(body, MOTION, FORCES).values
    other = Coordinates(list(NAMES), MOTION.times.tolist(), MOTION.values.astype(">f8"))
    assert wm.inverse_dynamics(body, other, FORCES).values.tobytes() == usual.tobytes()
    single = Coordinates(NAMES, MOTION.times, MOTION.values.astype(np.float32))
    assert single.values.dtype == np.float64
    assert np.abs(wm.inverse_dynamics(body, single, FORCES).values - usual).max() < 0.5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"force": 1e12 * PLATE.force}, "force of 'plate' is .* N in frame 1"), ({"force": None}, "array of numbers"),
        ({"moment": np.nan * PLATE.moment}, "not a finite number"), ({"point": 1e12 + PLATE.point}, "point of 'plate'"),
        ({"point": PLATE.point.astype(str)}, "array of numbers"), ({"name": 3}, "texts"),
    ],
)  # fmt: skip
def test_plates_that_are_none_are_refused(change, message):
    refused(lambda: Loads(FORCES.times, (replace(PLATE, **change),)), message, ArgumentError)
    refused(lambda: Loads(FORCES.times, (1,)), "each plate must be a Plate", ArgumentError)  # type: ignore[arg-type]
    refused(lambda: Loads(FORCES.times, None), "list of plates", ArgumentError)  # type: ignore[arg-type]


@pytest.mark.parametrize("strange", STRANGE, ids=lambda one: type(one).__name__)
def test_what_is_no_trial_is_refused_by_every_step(body, scene, strange):
    acting = "activations must be Activations"
    none = "coordinates must be Coordinates|walk.mot: there is no such file"
    refused(lambda: wm.inverse_dynamics(body, strange), none)
    refused(lambda: wm.track(body, strange), none)
    refused(lambda: wm.inverse_kinematics(scene, strange, device="cpu"), "markers|no such file")
    if strange is not None and not isinstance(strange, list):
        refused(lambda: wm.inverse_dynamics(body, MOTION, strange), "loads must be Loads")
        refused(lambda: static_optimization(body, MOTION, FORCES, emg=strange), "emg must be Emg")
        refused(lambda: wm.joint_reactions(body, MOTION, FORCES, strange), acting)
        refused(lambda: wm.inverse_kinematics(scene, "no.trc", strange, device="cpu"), "weights|no such file")


@pytest.mark.parametrize(
    "options",
    [
        {"power": 2.5}, {"power": [2]}, {"power": True}, {"weight": ["volume"]}, {"rates": 1}, {"elastic": "x"},
        {"pennation": None}, {"reserve": "5"}, {"reserve": [1.0]}, {"reserve": {"knee_angle": None}}, {"least": "a"},
        {"least": 1.0}, {"emg_weight": None}, {"emg_weight": 1e300}, {"filter": "6"}, {"filter": np.nan},
        {"times": np.array([np.nan])}, {"times": np.array([0.1, np.nan])}, {"times": np.array(["a"])},
    ],
    ids=str,
)  # fmt: skip
def test_options_that_are_none_are_refused(body, options):
    refused(lambda: static_optimization(body, MOTION, FORCES, **options), error=ArgumentError)


def test_begin_and_end_and_numbers_of_a_calibration_are_numbers(body):
    emg = Emg(("rectus",), MOTION.times, np.full((40, 1), 0.3))
    for options in ({"begin": "a"}, {"end": np.nan}):
        refused(lambda given=options: wm.track(body, MOTION, FORCES, **given), "finite|a number", ArgumentError)
    for options in ({"members": "2"}, {"members": 1.5}, {"generations": np.nan}, {"seed": -1}, {"bounds": "x"}):
        refused(lambda given=options: calibrate(body, MOTION, emg, of=["knee_angle"], **given), error=ArgumentError)
    refused(lambda: calibrate(body, MOTION, emg, of=None), "of: name", ArgumentError)  # type: ignore[arg-type]


@pytest.mark.parametrize("weight", ["1", None, -1.0, np.nan, 1e300])
def test_weights_that_are_no_numbers_are_refused(scene, weight):
    chain = chain_of(scene)
    markers = markers_of(chain, walk(chain, 5))
    weights = dict.fromkeys(markers.names, weight)
    refused(lambda: wm.inverse_kinematics(scene, markers, weights, device="cpu"), "a weight must be 0 or more")


def test_forces_of_other_muscles_make_no_reactions(body):
    acting = static_optimization(body, MOTION, FORCES, reserve=10.0)
    for wrong in (
        replace(acting, muscles=acting.muscles[::-1]), replace(acting, force=np.nan * acting.force),
        replace(acting, muscles=acting.muscles[:3], force=acting.force[:, :3]),
    ):  # fmt: skip
        refused(lambda given=wrong: wm.joint_reactions(body, MOTION, FORCES, given), "activations", ArgumentError)


def test_lengths_that_no_unit_makes_and_frames_of_no_laboratory_are_told(body):
    far = np.where(np.array(NAMES) == "pelvis_tx", 1e9, MOTION.values)
    refused(lambda: wm.inverse_dynamics(body, Coordinates(NAMES, MOTION.times, far)), "in another unit", ArgumentError)
    with pytest.warns(UserWarning, match="frames are 1e-06 s apart; are its times in seconds"):
        wm.inverse_dynamics(body, Coordinates(NAMES, 1e-4 * MOTION.times, MOTION.values))
    times = MOTION.times.copy()
    times[20] = times[19] + 1e-5
    with pytest.warns(UserWarning, match="two frames at 0.19 s are only 1e-05 s apart"):
        wm.inverse_dynamics(body, Coordinates(NAMES, times, MOTION.values))


def test_a_set_up_that_names_what_is_not_there_is_named_itself(scene, tmp_path):
    chain = chain_of(scene)
    markers = markers_of(chain, walk(chain, 5))
    tasks = "".join(f'<IKMarkerTask name="{name}"/>' for name in markers.names)
    file = '<IKCoordinateTask name="ankle"><weight>1</weight><value_type>from_file</value_type></IKCoordinateTask>'
    for more, table, message in (
        ('<IKMarkerTask name="hoof"/>', "", "ik.xml: a weight is of the marker 'hoof'"),
        ('<IKCoordinateTask name="hoof"/>', "", "ik.xml: a task is of the coordinate 'hoof'"),
        (file, "", "ik.xml: .* no <coordinate_file>"), (file, "no.mot", "ik.xml: <coordinate_file>: .* 'no.mot'"),
        (file, "late.csv", "late.csv: reaches from 90 to 91 s, the markers from 2 to"),
    ):  # fmt: skip
        path = tmp_path / "ik.xml"
        path.write_text(
            f"<OpenSimDocument><InverseKinematicsTool><coordinate_file>{table}</coordinate_file><IKTaskSet><objects>"
            f"{tasks}{more}</objects></IKTaskSet></InverseKinematicsTool></OpenSimDocument>"
        )
        (tmp_path / "late.csv").write_text("time,ankle\n90,1\n91,2\n")
        refused(lambda: wm.inverse_kinematics(scene, markers, setup=path, device="cpu"), message)  # noqa: B023
