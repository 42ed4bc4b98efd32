"""A policy and its learning curve come back from a result file as they were; damaged ones are refused in one line."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from small_policy import learning_curve, small_policy
from warpmuscle.core.errors import ResultError
from warpmuscle.results.learned import CURVE, LATER, Ancestor, ClippedNoise, KeptGait, Learned
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import read, read_learned, write


def a_result() -> Result:
    learned = Learned(
        small_policy(), "{}", learning_curve(5), {"epochs": 4, "hidden": (17, 6), "until": 2.5}, "time is up"
    )
    return Result('name = "x"\n', "cpu", "warpmuscle learn x", 7, parameter_table([]), learned=learned)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "policy.h5"
    write(path, a_result())
    return path


def test_all_of_it_comes_back(file):
    wanted, found = a_result().learned, read(file).learned
    assert (found.policy.observation, found.policy.action) == (wanted.policy.observation, wanted.policy.action)
    assert found.policy.widest == wanted.policy.widest
    for name in ("mean", "deviation"):
        np.testing.assert_array_equal(getattr(found.policy, name), getattr(wanted.policy, name))
    for one, other in zip(found.policy.layers, wanted.policy.layers, strict=True):
        assert one.weight.dtype == np.float32
        np.testing.assert_array_equal(one.weight, other.weight)
        np.testing.assert_array_equal(one.bias, other.bias)
    assert set(found.curve) == set(CURVE)
    for name in CURVE:
        np.testing.assert_array_equal(found.curve[name], wanted.curve[name])
    assert (found.options, found.ended, found.task) == (wanted.options, "time is up", "{}")
    assert "9-17-6-4" in repr(read(file))


@pytest.mark.parametrize("column", LATER)
def test_a_file_of_before_disturbances_were_counted_had_all_of_them(file, column):
    with h5py.File(file, "a") as content:
        del content[f"curve/{column}"]
    curve = read(file).learned.curve
    np.testing.assert_array_equal(curve[column], np.ones(5))
    assert list(curve) == list(CURVE)
    with h5py.File(file, "a") as content:
        del content["curve/speed"]
    with pytest.raises(ResultError, match="curve/speed"):
        read(file)


def test_the_noise_of_a_policy_comes_back(tmp_path):
    noise = ClippedNoise(np.linspace(0.1, 0.4, 4, dtype=np.float32), -0.25, 2.25)
    result = a_result()
    write(tmp_path / "noisy.h5", replace(result, learned=replace(result.learned, policy=small_policy(noise=noise))))
    found = read(tmp_path / "noisy.h5").learned.policy.noise
    np.testing.assert_array_equal(found.deviation, noise.deviation)
    assert (found.low, found.high) == (noise.low, noise.high)


def test_a_critic_and_what_a_policy_was_begun_with_come_back(tmp_path):
    critic = small_policy(observations=12, actions=1, seed=4)
    ancestors = (Ancestor("b.h5", 3, 5_000_000_000, "warpmuscle learn b"), Ancestor("a.h5", 1, 24, ""))
    result = a_result()
    path = tmp_path / "p.h5"
    write(path, replace(result, learned=replace(result.learned, critic=critic, ancestors=ancestors)))
    found = read(path).learned
    assert found.ancestors == ancestors
    np.testing.assert_array_equal(found.critic.layers[0].weight, critic.layers[0].weight)
    np.testing.assert_array_equal(found.critic.mean, critic.mean)
    assert found.critic.observation == critic.observation
    assert read_learned(path).ancestors == ancestors
    for group, message in (
        ("critic/layers/2", "critic/layers/1"),
        ("training/ancestors/command", "command is missing"),
    ):
        with h5py.File(path, "r+") as file:
            del file[group]
        with pytest.raises(ResultError, match=message):
            read(path)
        write(path, replace(result, learned=replace(result.learned, critic=critic, ancestors=ancestors)))


def a_gait() -> KeptGait:
    frames = np.linspace(0.0, 1.0, 20)
    coordinate = np.stack([np.sin(frames), np.cos(frames), frames**3], axis=1)
    return KeptGait("0f" * 32, coordinate, np.tile([0.0, 0.99, 0.01], (20, 1)), np.array([0.4, 1.5, 2.61]), 0.49, 1.1)


@pytest.fixture
def file_with_gait(tmp_path):
    path, result = tmp_path / "imitates.h5", a_result()
    policy = replace(result.learned.policy, gait=a_gait())
    write(path, replace(result, learned=replace(result.learned, policy=policy)))
    return path


def test_a_gait_comes_back_to_the_bit_and_older_files_have_none(file, file_with_gait):
    wanted, found = a_gait(), read(file_with_gait).learned.policy.gait
    for name in ("coordinate", "up", "landings"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))
    assert (found.scene, found.right, found.cycle_time) == (wanted.scene, wanted.right, wanted.cycle_time)
    assert read_learned(file_with_gait).policy.gait.scene == wanted.scene
    assert read(file).learned.policy.gait is None


def test_the_same_policy_gives_the_same_bytes(file, tmp_path):
    write(tmp_path / "again.h5", read(file))
    assert (tmp_path / "again.h5").read_bytes() == file.read_bytes()


def changed(name, value, new=False):
    def change(file):
        if not new:
            del file[name]
        file[name] = value

    return change


def noisy(deviation, low, high):
    def change(file):
        file["policy/noise"] = deviation
        file["policy"].attrs["action_min"], file["policy"].attrs["action_max"] = low, high

    return change


def without(name):
    def change(file):
        del file[name]

    return change


def linked(file):
    del file["policy/mean"]
    file["policy/mean"] = h5py.ExternalLink("/etc/passwd", "/x")


def attribute(owner, name, value):
    return lambda file: file[owner].attrs.__setitem__(name, value)


def grouped(name):
    def change(file):
        del file[name]
        file.create_group(name)

    return change


DAMAGES = {
    "no mean": (without("policy/mean"), "mean is missing"),
    "no layers": (without("policy/layers"), "layers is missing"),
    "a layer fewer": (without("policy/layers/2"), "policy/layers/1"),
    "no first layer": (without("policy/layers/0"), "layers/0 is missing"),
    "no curve": (without("curve"), "curve"),
    "no training": (without("training"), "training"),
    "no column": (without("curve/gain"), "gain is missing"),
    "weights not finite": (changed("policy/layers/0/weight", np.full((17, 9), np.nan, np.float32)), "layers/0/weight"),
    "weights too large": (changed("policy/layers/0/weight", np.full((17, 9), 1e30, np.float32)), "1e\\+30"),
    "weights turned": (changed("policy/layers/0/weight", np.zeros((9, 17), np.float32)), "shape"),
    "weights as texts": (changed("policy/layers/0/weight", np.full((17, 9), b"x")), "holds no numbers"),
    "deviation 0": (changed("policy/deviation", np.zeros(9, np.float32)), "policy/deviation"),
    "a name fewer": (changed("policy/observation", [b"a"]), "policy/mean has shape"),
    "names as numbers": (changed("policy/action", np.arange(4)), "damaged"),
    "curve of unequal columns": (changed("curve/gain", np.zeros(3)), "curve/gain has shape"),
    "curve of tables": (changed("curve/iteration", np.zeros((5, 2))), "curve/iteration has shape"),
    "noise of another size": (noisy(np.ones(3, np.float32), -1.0, 1.0), "policy/noise has shape"),
    "noise of no width": (noisy(np.zeros(4, np.float32), -1.0, 1.0), "policy/noise"),
    "noise between no ends": (noisy(np.ones(4, np.float32), 1.0, -1.0), "action_min = 1 and action_max = -1"),
    "noise up to no number": (noisy(np.ones(4, np.float32), 1.0, np.nan), "action_max of /policy is nan"),
    "noise without ends": (changed("policy/noise", np.ones(4, np.float32), new=True), "action_min"),
    "a link elsewhere": (linked, "link"),
    "no widest": (lambda file: file["policy"].attrs.__delitem__("widest"), "widest"),
    "widest a text": (attribute("policy", "widest", "wide"), "widest of /policy is 'wide'"),
    "widest as texts": (attribute("policy", "widest", ["a", "b"]), "widest of /policy is an array of shape \\(2,\\)"),
    "another activation": (attribute("policy", "activation", "tanh"), "activation 'tanh'"),
    "activations": (attribute("policy", "activation", [1, 2]), "only 'elu' is known"),
    "layers as numbers": (changed("policy/layers", np.arange(3)), "/policy/layers is not a group"),
    "no training but a number": (changed("training", 3), "/training is not a group"),
    "a mean without a shape": (changed("policy/mean", h5py.Empty("f4")), "/policy/mean holds nothing"),
    "names without a shape": (changed("policy/action", h5py.Empty("S3")), "/policy/action holds nothing"),
    "names as a group": (grouped("policy/action"), "/policy/action is not a dataset"),
    "a task as a group": (grouped("policy/task"), "/policy/task is not a dataset"),
    "a task of bytes": (changed("policy/task", np.bytes_(b"\xff\xfe")), "/policy/task holds bytes that are no text"),
    "widest not a number": (attribute("policy", "widest", np.nan), "widest of /policy is nan"),
}  # fmt: skip


def is_refused(path, damage, message):
    with h5py.File(path, "r+") as content:
        damage(content)
    for reader in (read_learned, read):
        with pytest.raises(ResultError, match=message) as caught:
            reader(path)
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_policy_is_refused_in_one_line(name, file):
    is_refused(file, *DAMAGES[name])


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [("seed", "x", "seed of / is 'x'"), ("format_version", "two", "format_version of / is 'two'"),
     ("seed", 2.5, "should be a whole number"), ("format_version", [3, 3], r"is an array of shape \(2,\)")],
)  # fmt: skip
def test_an_attribute_that_is_no_whole_number_is_named(name, value, said, file):
    with h5py.File(file, "r+") as content:
        content.attrs[name] = value
    with pytest.raises(ResultError, match=said):
        read(file)


def test_ancestors_of_unequal_columns_are_refused(tmp_path):
    learned = replace(a_result().learned, ancestors=(Ancestor("walk.h5", 3, 500, "warpmuscle learn walk"),))
    write(tmp_path / "two.h5", replace(a_result(), learned=learned))
    with h5py.File(tmp_path / "two.h5", "r+") as content:
        del content["training/ancestors/seed"]
        content["training/ancestors/seed"] = np.zeros(2, dtype=np.int64)
    with pytest.raises(ResultError, match="training/ancestors has columns of different lengths"):
        read(tmp_path / "two.h5")


GAIT_DAMAGES = {
    "no coordinates": (without("gait/coordinate"), "coordinate is missing"),
    "no landings": (without("gait/landings"), "landings is missing"),
    "no scene": (lambda file: file["gait"].attrs.__delitem__("scene"), "scene"),
    "scene no digest": (attribute("gait", "scene", "walk56"), "no SHA-256"),
    "coordinates not finite": (changed("gait/coordinate", np.full((20, 3), np.nan)), "gait/coordinate"),
    "coordinates too large": (changed("gait/coordinate", np.full((20, 3), 1e30)), "1e\\+30"),
    "coordinates in a row": (changed("gait/coordinate", np.zeros(20)), "gait/coordinate has shape"),
    "no frames": (changed("gait/coordinate", np.zeros((0, 3))), "gait/coordinate has shape"),
    "frames without end": (changed("gait/coordinate", np.zeros((20_000, 1))), "gait/coordinate has shape"),
    "coordinates as texts": (changed("gait/coordinate", np.full((20, 3), b"x")), "holds no numbers"),
    "whole numbers": (changed("gait/coordinate", np.zeros((20, 3), dtype=int)), "gait/coordinate holds no numbers"),
    "other frames": (changed("gait/up", np.tile([0.0, 1.0, 0.0], (19, 1))), "gait/up has shape"),
    "no vertical": (changed("gait/up", np.zeros((20, 3))), "gait/up holds vectors that point nowhere"),
    "long vertical": (changed("gait/up", np.full((20, 3), 2.0)), "gait/up holds 2"),
    "one landing": (changed("gait/landings", np.array([1.0])), "gait/landings holds 1 time"),
    "landings back": (changed("gait/landings", np.array([1.0, 3.0, 2.0])), "one after the other"),
    "landings not finite": (changed("gait/landings", np.array([1.0, np.inf])), "gait/landings holds inf"),
    "landings in a table": (changed("gait/landings", np.ones((2, 2))), "gait/landings has shape"),
    "right not finite": (attribute("gait", "right", np.nan), "right of /gait is nan"),
    "right beyond the cycle": (attribute("gait", "right", 1.0), "right = 1"),
    "right a text": (attribute("gait", "right", "half"), "right of /gait is 'half', and should be a number"),
    "time a text": (attribute("gait", "cycle_time", "1 s"), "cycle_time of /gait is '1 s'"),
    "no time": (attribute("gait", "cycle_time", 0.0), "cycle_time = 0"),
    "time not finite": (attribute("gait", "cycle_time", np.inf), "cycle_time of /gait is inf"),
    "gait no group": (changed("gait", np.zeros(3)), "damaged"),
}  # fmt: skip


@pytest.mark.parametrize("name", GAIT_DAMAGES)
def test_a_damaged_gait_is_refused_in_one_line(name, file_with_gait):
    is_refused(file_with_gait, *GAIT_DAMAGES[name])


def test_what_was_learnt_is_read_without_the_motions_beside_it(file, tmp_path):
    with h5py.File(file, "r+") as content:
        content["replay/0/time"] = b"no numbers"
    found = read_learned(file)
    np.testing.assert_array_equal(found.policy.mean, a_result().learned.policy.mean)
    with pytest.raises(ResultError, match="damaged"):
        read(file)
    write(tmp_path / "none.h5", replace(a_result(), learned=None))
    assert read_learned(tmp_path / "none.h5") is None


def test_what_is_not_finite_is_not_written(tmp_path):
    result = a_result()
    policy = replace(result.learned.policy, mean=np.full(9, np.inf, dtype=np.float32))
    with pytest.raises(ResultError, match="not finite"):
        write(tmp_path / "x.h5", replace(result, learned=replace(result.learned, policy=policy)))
    assert list(tmp_path.iterdir()) == []
