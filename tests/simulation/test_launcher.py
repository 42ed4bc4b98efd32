"""How the work of a launch is cut into pieces, and by which kernel it is done."""

import threading
from types import SimpleNamespace

import pytest
import warp as wp

from small_scene import sound_scene
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load
from warpmuscle.kernels.memory.scratch import (
    ALL,
    CONTROL,
    ENTRIES,
    LEAN,
    LEANER,
    LEANEST,
    NEAR,
    SECOND,
    SLOT_FLOATS,
    work_floats,
)
from warpmuscle.kernels.path.route_bends import RouteKind
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.kernels.recording.record import NOTHING, RecordKind
from warpmuscle.kernels.step import block_registers, blocks_of
from warpmuscle.kernels.step_parts import StepKind
from warpmuscle.model.controllers.outside import driven_from_outside
from warpmuscle.model.controllers.simbicon import HELD
from warpmuscle.model.muscles import muscle_kind
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import MuscleModel
from warpmuscle.simulation import fused_kernel, launcher
from warpmuscle.simulation.fused_kernel import WAVES, FusedKernel, KernelConfig, piece_lengths
from warpmuscle.simulation.launcher import (
    Launcher,
    in_large_blocks,
    kernel_config,
    large_blocks,
    soon_loaded,
    spread_config,
    usual_lanes,
)
from warpmuscle.simulation.rollout import Rollout

CONFIG = KernelConfig(15, 8, 32, StepKind(recorded=NOTHING))


@pytest.mark.parametrize("steps", [1, 7, 200])
@pytest.mark.parametrize("waves", [1.01, 1.3, 2.6, 10.3, 40.0])
def test_pieces_make_all_steps_and_waves_enough_to_fill_the_gaps_of_one_another(steps: int, waves: float):
    pieces = piece_lengths(steps, waves)
    assert sum(pieces) == steps
    assert min(pieces) >= 1
    assert max(pieces) - min(pieces) <= 1
    assert len(pieces) == steps or len(pieces) * waves >= WAVES > (len(pieces) - 1) * waves


def test_the_few_that_are_left_get_the_lanes_and_the_kernel_of_a_replay():
    replay = CONFIG._replace(lanes=16).compiling(recorded=RecordKind())
    assert [spread_config(CONFIG, running, 132) for running in (65536, 4096, 2560, 1)] == [None, None, replay, replay]
    assert spread_config(CONFIG.compiling(recorded=RecordKind()), 1, 132) == replay


def test_nothing_changes_for_those_that_have_as_many_lanes_or_record_in_part():
    assert spread_config(CONFIG._replace(lanes=16), 1, 132) is None
    assert spread_config(CONFIG.compiling(recorded=RecordKind(complete=False)), 1, 132) is None


class Compiled(FusedKernel):
    """Stands for a kernel that Warp has in its cache, or has not."""

    cached = True

    def __init__(self, config: KernelConfig, device: object, threads: int) -> None:
        self.config, self.device = config, device

    @property
    def compiles(self) -> bool:
        return not self.cached

    def load(self) -> None:
        fused_kernel._loaded.add((self.config, str(self.device)))


@pytest.mark.parametrize("cached", [True, False])
def test_a_kernel_is_loaded_in_the_background_but_never_compiled(cached: bool, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(fused_kernel, "_loaded", set())
    monkeypatch.setattr(launcher, "_sought", set())
    monkeypatch.setattr(Compiled, "cached", cached)
    monkeypatch.setattr(launcher, "FusedKernel", Compiled)
    soon_loaded(CONFIG, "cuda:0")
    for thread in threading.enumerate():
        if thread.name == "kernel":
            thread.join()
    assert soon_loaded(CONFIG, "cuda:0") == cached


def test_a_batch_goes_on_with_the_other_kernel_once_few_are_left_and_it_is_there(monkeypatch: pytest.MonkeyPatch):
    scene = sound_scene()
    scene.duration = 0.04
    rollout = Rollout(scene, 5, "cpu")
    usual = rollout._launcher.kernel()
    other = FusedKernel(usual.config, rollout.device, 1)
    there, launched = [False], []
    monkeypatch.setattr(FusedKernel, "launch", lambda self, steps, running, *_: launched.append((self, len(running))))
    monkeypatch.setattr(launcher, "spread_config", lambda config, running, _: None if running > 3 else "other")
    monkeypatch.setattr(launcher, "soon_loaded", lambda config, device: there[0])
    rollout._launcher._spreads, rollout._launcher._kernels["other"] = True, other
    for left, is_there in ((5, True), (3, False), (2, True)):
        rollout._batch.running, there[0] = rollout._batch.running[:left], is_there
        rollout.advance(rollout.steps_done + 1)
    assert launched == [(usual, 5), (usual, 3), (other, 2)]


def test_a_launcher_by_itself_has_one_kernel_a_configuration_and_launches_what_the_batch_needs():
    one = Launcher(CONFIG, wp.get_device("cpu"), 1)
    assert one.kernel() is one.kernel() is one.kernel_for(1)
    one.read_excitations()
    assert one.config == CONFIG  # which has no muscles
    assert one.config_from_outside(True, False) == CONFIG
    assert one.config_from_outside(False, True).kind.controller == driven_from_outside(CONFIG.kind.controller)
    muscles = Launcher(CONFIG.compiling(muscles=muscle_kind(MuscleModel())._replace(timed=False)), "cpu", 1)
    outside = muscles.config_from_outside(True, False).kind.muscles
    assert (muscles.config.kind.muscles.timed, outside.given, outside.timed) == (False, True, True)
    muscles.read_excitations()
    assert (muscles.config.kind.muscles.timed, muscles.config.kind.muscles.given) == (True, False)


def test_a_gpu_gets_lanes_by_the_number_of_instances_and_code_for_what_the_scene_has_and_a_cpu_one_thread():
    scene = load("walk56")
    structure, gpu = structure_of(scene), SimpleNamespace(is_cpu=False, sm_count=132)
    few, many, asked = (
        kernel_config(scene, structure, n, gpu, k, NOTHING) for n, k in ((1, None), (65536, None), (1, 4))
    )
    assert [config.lanes for config in (few, many, asked)] == [16, 8, 4]
    assert {config.block_dim for config in (few, many, asked)} == {32}
    assert (many.kind.muscles.timed, many.kind.muscles.straight) == (False, True)
    cpu = kernel_config(scene, structure, 65536, wp.get_device("cpu"), 4, NOTHING)
    assert (cpu.lanes, cpu.block_dim, cpu.kind.muscles.timed, cpu.kind.muscles.straight) == (1, 1, True, False)
    assert cpu._replace(lanes=8, block_dim=32).compiling(muscles=many.kind.muscles) == many
    with pytest.raises(RolloutError, match="lanes must be"):
        kernel_config(scene, structure, 1, gpu, 3, NOTHING)


def test_long_paths_share_blocks_whose_lanes_next_to_one_another_are_of_as_many_instances():
    structure, gpu = structure_of(load("gait2392_walk")), SimpleNamespace(is_cpu=False, sm_count=132)
    scene = load("gait2392_walk")
    usual, asked = (kernel_config(scene, structure, 5120, gpu, lanes, NOTHING) for lanes in (None, 8))
    assert (usual.lanes, usual.block_dim, asked.lanes, asked.block_dim) == (16, 512, 8, 256)
    assert usual.instances_a_block == asked.instances_a_block == 32  # one for each thread of a warp
    assert usual.capacity >= len(structure.names.bodies)
    assert [usual.rows(n) for n in (1, 32, 33)] == [32, 32, 64]
    assert spread_config(usual, 1, 132) is None
    assert usual.resident(132) % (132 * 32) == 0
    crossings = len(structure.actuation.table.crossings)
    assert usual.kind.muscles.pulls_in_scratch  # which small size classes have no room for
    assert 3 * crossings <= (SECOND - CONTROL) * usual.capacity + SLOT_FLOATS * usual.slots
    assert not usual.kind.muscles.delayed
    wide = kernel_config(scene, structure, 5120, gpu, 32, NOTHING)
    assert (wide.lanes, wide.instances_a_block) == (32, 16)
    # Working sets that leave room for few instances, which then have more lanes:
    polynomials = usual.compiling(muscles=usual.kind.muscles._replace(paths=PathKind(monomials=1300)))
    many = large_blocks(polynomials, structure, None, 4, 65536, 132)
    assert (many.lanes, many.block_dim) == (32, 512)
    wraps = usual.compiling(muscles=usual.kind.muscles._replace(paths=PathKind(RouteKind(wraps=1))))
    around = large_blocks(wraps, structure, None, 4, 65536, 132)
    assert (around.lanes, around.block_dim) == (12, 384)  # which leaves as many registers as these need
    loops = wraps.compiling(skeleton=wraps.kind.skeleton._replace(constraints=3, entries=12))
    closed = large_blocks(loops, structure, None, 4, 65536, 132)
    assert (closed.lanes, closed.block_dim) == (8, 256)  # and more, where constraints push, too
    rounds = usual.compiling(muscles=usual.kind.muscles._replace(paths=PathKind(RouteKind(wraps=3))))
    apart = large_blocks(rounds, structure, None, 4, 65536, 132)
    assert (apart.lanes, apart.block_dim, apart.paths_apart) == (16, 512, True)  # paths have a kernel of their own
    assert not any(config.paths_apart for config in (usual, many, around, closed))
    larger = usual.compiling(muscles=usual.kind.muscles._replace(paths=PathKind(monomials=7000)))
    assert 32 <= large_blocks(larger, structure, None, 4, 65536, 132).block_dim < 256
    around_few = larger.compiling(
        muscles=larger.kind.muscles._replace(paths=PathKind(RouteKind(wraps=1), monomials=7000))
    )
    fewest = large_blocks(around_few, structure, None, 4, 65536, 132)
    assert (fewest.lanes, fewest.block_dim) == (96, 96 * fewest.instances_a_block)  # more than a warp has threads
    few, some = (kernel_config(scene, structure, n, gpu, None, NOTHING) for n in (1024, 2048))
    assert [(config.lanes, config.instances_a_block) for config in (few, some)] == [(32, 8), (32, 16)]
    assert few.resident(132) >= 1024  # which all fit at once with most lanes
    kinds = {config.kind.muscles for config in (few, some, asked, wide)}
    assert kinds == {usual.kind.muscles}  # so that results are the same
    assert not in_large_blocks(usual.compiling(collisions=True))  # which some instances test for while others do not
    assert not in_large_blocks(usual.compiling(controller=HELD))
    with pytest.raises(RolloutError, match="lanes must be"):
        kernel_config(scene, structure, 1, gpu, 12, NOTHING)


@pytest.mark.parametrize(("entries", "main"), [(100, ENTRIES), (4, NEAR)])
def test_what_followed_coordinates_leave_goes_to_main_memory_where_more_instances_fit_so(entries: int, main: int):
    scene, gpu = load("gait2392_walk"), SimpleNamespace(is_cpu=False, sm_count=132)
    structure = structure_of(scene)
    usual = kernel_config(scene, structure, 5120, gpu, None, NOTHING)
    skeleton = usual.kind.skeleton._replace(followed=4, entries=entries)
    config = large_blocks(usual.compiling(skeleton=skeleton), structure, None, 4, 65536, 132)
    assert config.kind.skeleton.main == main
    near = config.compiling(skeleton=skeleton)
    own = config.apart.floats * 128 if main > NEAR else config.work_floats  # 32 lie side by side
    assert config.buffer_floats(100) == own
    assert (near.large_blocks * near.instances_a_block < config.large_blocks * config.instances_a_block) is (
        main > NEAR
    )
    assert usual.kind.skeleton.main == NEAR


@pytest.mark.parametrize(
    ("bodies", "entries", "main", "together", "lanes"),
    [
        (16, 48, ENTRIES, 32, 12),
        (20, 60, LEAN, 32, 12),
        (41, 60, LEANER, 32, 16),
        (123, 186, LEANEST, 32, 16),
        (240, 186, ALL, 32, 16),
    ],
)
def test_large_characters_leave_part_of_their_working_sets_to_main_memory(
    bodies: int, entries: int, main: int, together: int, lanes: int
):
    """Where more instances fit so (the larger ones here, with more lanes), or as many with room for a cache."""
    scene, gpu = load("gait2392_walk"), SimpleNamespace(is_cpu=False, sm_count=132)
    usual = kernel_config(scene, structure_of(scene), 5120, gpu, None, NOTHING)
    actuation = SimpleNamespace(table=SimpleNamespace(crossings=range(10 * bodies)), muscles=range(bodies))
    structure = SimpleNamespace(names=SimpleNamespace(bodies=range(bodies)), actuation=actuation)
    skeleton = usual.kind.skeleton._replace(followed=5, entries=entries)
    wraps = usual.kind.muscles._replace(paths=PathKind(RouteKind(wraps=1)))
    kind = usual.compiling(skeleton=skeleton, muscles=wraps)
    config = large_blocks(kind, structure, None, 0, 65536, 132)
    assert config.kind.skeleton.main == main
    assert (config.instances_a_block, config.lanes, config.block_dim) == (together, lanes, together * lanes)
    near = config.compiling(skeleton=skeleton._replace(main=main - 1))
    assert config.large_blocks == 1
    assert near.large_blocks < 1 or near.block_bytes > 196 * 1024
    few = large_blocks(kind, structure, None, 0, 132, 132)
    assert few.kind.skeleton.main <= LEAN  # which is quicker where all of them run at once
    assert few.resident(132) >= 132
    polynomials = wraps._replace(paths=PathKind(RouteKind(wraps=1), monomials=10))
    other = large_blocks(usual.compiling(skeleton=skeleton, muscles=polynomials), structure, None, 0, 65536, 132)
    assert other.kind.skeleton.main <= ENTRIES  # monomials have no place there
    shared = wraps._replace(shared=3)
    other = large_blocks(usual.compiling(skeleton=skeleton, muscles=shared), structure, None, 0, 65536, 132)
    assert other.kind.skeleton.main <= LEAN  # nor have shares


def test_main_memory_for_many_instances_is_an_array_of_two_dimensions():
    """In one dimension Warp has fewer than 2^31 numbers: 413 000 instances of 400 entries would be too many."""
    scene = load("gait2392_walk")
    structure = structure_of(scene)
    config = kernel_config(scene, structure, 1, wp.get_device("cpu"), None, NOTHING)
    for main in (ENTRIES, NEAR):
        made = config.compiling(skeleton=config.kind.skeleton._replace(main=main, entries=6))
        kernel = FusedKernel(made, wp.get_device("cpu"), 1, 7)
        assert kernel._buffers[0].shape == ((13 * 6, 32) if main == ENTRIES else (made.work_floats, 1))


@pytest.mark.parametrize(("threads", "floats"), [(128, 8 * 1100), (64, 8 * 2300), (256, 16 * 1000)])
def test_registers_leave_room_for_as_many_blocks_as_shared_memory_does(threads: int, floats: int):
    blocks, registers = blocks_of(threads, floats), block_registers(threads, floats)
    assert blocks * (4 * floats + 1024) <= 228 * 1024
    assert 96 <= registers <= 255
    assert blocks * threads * registers <= 64 * 1024
    plain = muscle_kind(MuscleModel())
    wraps = plain._replace(paths=PathKind(RouteKind(wraps=2)), pulls_in_scratch=True)
    assert block_registers(threads, floats, wraps) >= max(168, registers)  # with fewer, wraps would spill
    assert blocks_of(threads, floats, wraps) <= blocks
    assert blocks_of(threads, floats, plain) * (4 * floats + 1024 + 4 * threads) <= 196 * 1024  # arms want the cache
    more = blocks + 1
    assert more * (4 * floats + 1024 + 4 * threads) > 228 * 1024 or more * threads * 96 > 64 * 1024


def test_lanes_are_as_many_as_the_memory_of_a_block_asks_for():
    biped, centipede = work_floats(15), work_floats(60)
    assert [usual_lanes(None, floats, 5120, 132) for floats in (biped, centipede)] == [8, 16]
    assert usual_lanes(4, biped, 5120, 132) == 4
    for wanted, floats in ((3, biped), (8, centipede), (None, work_floats(400))):
        with pytest.raises(RolloutError):
            usual_lanes(wanted, floats, 5120, 132)


def test_few_instances_have_more_lanes_so_that_no_multiprocessor_is_idle():
    biped = work_floats(15)
    assert [usual_lanes(None, biped, n, 132) for n in (1, 1024, 2560, 4096, 65536)] == [16, 16, 16, 8, 8]


def test_large_working_sets_have_more_lanes_so_that_a_multiprocessor_stays_full():
    """With 8 lanes, eight warps with four working sets of 1660 numbers fit its memory, with 16 there are sixteen."""
    with_coordinate_joints = [work_floats(bodies, True) for bodies in (15, 20, 25, 35)]
    assert [usual_lanes(None, floats, 65536, 132) for floats in with_coordinate_joints] == [8, 16, 16, 16]
