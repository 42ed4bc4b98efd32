"""A batch shared out over several devices gives what one device gives, to the last bit; the CPU stands for each."""

import inspect
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
import warp as wp

import warpmuscle.simulation.multi_device as split_module
from short_walks import CANDIDATE, assert_same_bits, candidates, limp, short_walk
from small_sweep import contents, small_sweep
from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.formats import load
from warpmuscle.optimization.evaluation import BatchEvaluator
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.replay import Replayer
from warpmuscle.optimization.resume import resume
from warpmuscle.scene import Robustness
from warpmuscle.simulation.batch import Batch
from warpmuscle.simulation.candidates import CandidateBatch
from warpmuscle.simulation.devices import devices_name, find_device, find_devices
from warpmuscle.simulation.multi_device import MultiDeviceRollout, make_rollout
from warpmuscle.simulation.perturbations import drawn
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.run import sweep


def both(scene, instances, **options):
    """One rollout, and the same over three devices."""
    return Rollout(scene, instances, "cpu", **options), MultiDeviceRollout(scene, instances, ["cpu"] * 3, **options)


def assert_same(one, split):
    for name in ("status", "end_time", "cost"):
        np.testing.assert_array_equal(getattr(one, name)(), getattr(split, name)(), err_msg=name)
    for name, values in one.terms().items():
        np.testing.assert_array_equal(values, split.terms()[name], err_msg=name)
    assert (one.time, one.alive, one.steps) == (split.time, split.alive, split.steps)


@pytest.mark.parametrize("instances", [2, 3, 7])
def test_a_batch_over_several_devices_gives_the_bits_of_one(instances):
    one, split = both(short_walk(0.3), instances, record=[instances - 1, 0], record_rate=200)
    assert [share.stop - share.start for share in split.shares] == {2: [1, 1], 3: [1, 1, 1], 7: [2, 2, 3]}[instances]
    for batch in (one, split):
        batch.set_parameters(candidates(instances, 1))
        batch.run(0.13)
    assert_same(one, split)
    for batch in (one, split):
        batch.run()
    assert_same(one, split)
    assert_same_bits(one.recording(), split.recording())
    assert_same_bits(one.recording(0), split.recording(0))


def test_noise_is_that_of_the_whole_batch_and_a_part_that_has_failed_waits_for_the_others():
    one, split = both(limp(), 7)
    for batch in (one, split):
        batch.reset(velocity_noise=0.5, seed=3)
        batch.run(0.2)
        assert batch.time == pytest.approx(0.2)
    assert_same(one, split)
    for batch in (one, split):
        batch.run()
    assert_same(one, split)
    assert split.alive == 0
    assert len({rollout.steps_done for rollout in split.rollouts}) > 1
    for batch in (one, split):
        batch.reset()
        batch.run(0.1)
    assert_same(one, split)


def test_disturbances_and_common_parameters_reach_every_part():
    scene = short_walk(0.3)
    runs = drawn(Robustness(runs=7, velocity_noise=0.2, push=60.0, slope=0.05), 0.3)
    one, split = both(scene, 7)
    for batch in (one, split):
        batch.disturb(runs)
        batch.set_parameters(CANDIDATE)
        batch.run()
    assert_same(one, split)
    assert len(set(split.cost())) == 7


@pytest.mark.parametrize(("telling", "times"), [(0.0, [0.1, 0.2, 0.3, 0.4]), (1e9, [0.1, 0.3, 0.4])])
def test_an_interrupted_split_batch_can_be_read_and_continued(
    telling: float, times: list[float], monkeypatch: pytest.MonkeyPatch
):
    """And devices wait for one another the more rarely, the faster they are."""
    monkeypatch.setattr(split_module, "TELLING", telling)
    one, split = both(short_walk(0.4), 5)
    one.run()
    told = []

    def stop(batch):
        told.append(batch.time)
        if len(told) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        split.run(progress=stop)
    assert np.isfinite(split.cost()).all()
    assert split.alive == 5
    split.run(progress=stop)
    np.testing.assert_allclose(told, times)
    assert_same(one, split)


def test_chunks_of_each_device_grow(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(split_module, "TELLING", 1e9)
    monkeypatch.setattr("warpmuscle.simulation.rollout.QUICK", 1e9)
    split = both(short_walk(1.0), 4)[1]
    launched: dict[int, list[int]] = {}
    for number, rollout in enumerate(split.rollouts):
        advance = rollout.advance

        def noted(step: int, number: int = number, advance: Callable[[int], None] = advance) -> None:
            launched.setdefault(number, []).append(step)
            advance(step)

        monkeypatch.setattr(rollout, "advance", noted)
    split.run()
    assert launched == {number: [200, 600, 1400, 2000] for number in range(len(split.rollouts))}


def test_bad_input_of_a_split_batch_is_told_as_for_one_device():
    for batch in both(short_walk(), 3, record=[1]):
        with pytest.raises(RolloutError, match=r"shape \(3, 1\); this rollout takes \(3, 2\) or \(2,\)"):
            batch.set_parameters(np.zeros((3, 1)))
        with pytest.raises(RolloutError, match="not a finite number"):
            batch.set_parameters([[1.0, 2.0], [np.nan, 1.0], [1.0, 2.0]])
        with pytest.raises(RolloutError, match="2 disturbances for 3"):
            batch.disturb(drawn(Robustness(runs=2), 1.0))
        with pytest.raises(RolloutError, match="duration must be"):
            batch.run(-1.0)
        with pytest.raises(RolloutError, match="instance 2 was not recorded"):
            batch.recording(2)
    for wrong in ({"instances": 0}, {"record": [3]}, {"threads": 0}):
        with pytest.raises(RolloutError):
            MultiDeviceRollout(short_walk(), **{"instances": 3, "devices": ["cpu", "cpu"], **wrong})


# Names of devices.


@pytest.fixture
def two_cpus(monkeypatch):
    """A machine whose GPUs are two CPUs."""
    cpu = wp.get_device("cpu")
    monkeypatch.setattr(wp, "get_cuda_devices", lambda: [cpu, cpu])


@pytest.mark.skipif(wp.is_cuda_available(), reason="there are GPUs here")
@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cuda:all", r"there is no GPU here, of which 'cuda:all' takes all; known: cpu"),
        ("cuda:0,cuda:2", r"there is no device 'cuda:0', which 'cuda:0,cuda:2' names, here; known: cpu"),
        ("cuda:7", r"there is no device 'cuda:7' here; known: cpu"),
    ],
)
def test_a_machine_without_a_gpu_says_so(name, message):
    for use in (find_devices, devices_name, lambda device: make_rollout(short_walk(), 2, device)):
        with pytest.raises(RolloutError, match=message):
            use(name)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cpu,cpu", "'cpu,cpu' names the CPU as one of several devices; only GPUs share a batch"),
        ("cpu,", "there is no device ''"),
        ("abc,def", "there is no device 'abc', which 'abc,def' names, here"),
    ],
)
def test_a_list_of_devices_that_cannot_share_a_batch_is_refused(name, message):
    with pytest.raises(RolloutError, match=message):
        find_devices(name)
    with pytest.raises(RolloutError):
        optimize(load("fwalk"), 4, device=name)


def test_a_single_rollout_takes_no_several_devices():
    with pytest.raises(RolloutError, match=r"'cuda:all' may be several devices, .* see warpmuscle.make_rollout"):
        Rollout(short_walk(), 2, "cuda:all")
    assert find_device("cpu") == find_devices(" cpu")[0]
    assert isinstance(make_rollout(short_walk(), 2, "cpu"), Rollout)


# Through what is built on batches.


def test_trials_over_several_devices_are_those_of_one(two_cpus):
    scene = msgspec.structs.replace(short_walk(0.2), robustness=Robustness(runs=3, velocity_noise=0.2, push=60.0))
    one, several = CandidateBatch(scene, 5, "cpu"), CandidateBatch(scene, 5, "cuda:all")
    assert len(several.batch.rollouts) == 2
    assert len(several.batch.rollouts[0].status()) == 7  # in the middle of a candidate
    for trials in (one, several):
        trials.set_parameters(candidates(5, 0))
        trials.run()
    np.testing.assert_array_equal(one.ended(), several.ended())
    for name in ("cost", "status", "end_time"):
        values = (getattr(trials.outcomes(), name) for trials in (one, several))
        np.testing.assert_array_equal(*values, err_msg=name)


def test_an_optimisation_over_several_devices_is_that_of_one_and_can_be_resumed(two_cpus, tmp_path):
    scene = msgspec.structs.replace(load("fwalk"), duration=0.1)
    one = optimize(scene, 30, seed=3, device="cpu", search="cma", population=6)
    path = tmp_path / "several.h5"
    part = optimize(scene, 12, seed=3, device="cuda:all", search="cma", population=6, output=path)
    assert part.device == "cuda:all"
    whole = resume(path, 18)
    assert whole.device == "cuda:all"
    np.testing.assert_array_equal(whole.evaluations.cost, one.evaluations.cost)
    assert_same_bits(whole.replays[0], one.replays[0])


def test_batches_are_larger_on_more_devices(two_cpus):
    scene = msgspec.structs.replace(load("fwalk"), duration=0.1)
    one, two = BatchEvaluator(scene, "cpu", 1), BatchEvaluator(scene, "cuda:all", 1)
    assert (two.device, two.largest) == ("cuda:all", 2 * one.largest)
    assert two.term_names == one.term_names


@pytest.mark.long
def test_a_sweep_over_several_devices_is_that_of_one(two_cpus, tmp_path):
    files = [tmp_path / f"{name}.h5" for name in ("one", "several")]
    for device, file in zip(("cpu", "cuda:all"), files, strict=True):
        assert not sweep(small_sweep(tmp_path, candidates=8), file, device=device, command="test").failed
    one, several = map(contents, files)
    assert one.keys() == several.keys()
    differing = {name for name in one if not np.array_equal(one[name], several[name])}
    assert {name.rpartition("@")[2] for name in differing} == {"device"}


def test_a_sweep_on_a_cluster_takes_no_several_devices(tmp_path):
    with pytest.raises(Error, match=r"a task of a cluster gets one GPU, not 'cuda:all'"):
        sweep(small_sweep(tmp_path), tmp_path / "out.h5", cluster="auto", device="cuda:all")


def test_a_replay_is_made_on_the_first_device(two_cpus):
    scene = short_walk(0.1)
    replays = (Replayer(scene, device).replay(CANDIDATE)[0] for device in ("cuda:all", "cpu"))
    assert_same_bits(*replays)


def test_what_joints_add_and_parts_of_a_motion_come_from_the_device_that_has_the_instance():
    one, split = both(short_walk(0.3), 5, record=[4, 1])
    for batch in (one, split):
        batch.set_parameters(candidates(5, 1))
        batch.run()
    for instance in range(5):
        assert one.parts(instance) == split.parts(instance)
    assert_same_bits(one.recording(1, 0.1), split.recording(1, 0.1))
    with pytest.raises(RolloutError, match="instance must be a whole number from 0 to 4, not 5"):
        split.parts(5)


@pytest.mark.parametrize("kind", [Rollout, MultiDeviceRollout])
def test_all_that_a_batch_can_do_is_there_and_documented(kind: type[Batch]):
    devices = ["cpu"] if kind is MultiDeviceRollout else "cpu"
    batch = kind(short_walk(0.3), 2, devices)
    for name in Batch.__annotations__:
        assert hasattr(batch, name), name
    parts = [part for part in kind.__mro__ if part.__module__.startswith("warpmuscle.") and part is not Batch]
    own = {name for part in parts for name in vars(part)}
    for name, member in vars(Batch).items():
        if not name.startswith("_"):
            inherited = name in ("devices", "time", "alive", "status_names", "parameter_names", "close")
            assert inherited or name in own, f"{kind.__name__} lacks {name}"
            assert inspect.getdoc(getattr(kind, name)), name
            assert callable(member) or hasattr(batch, name)
