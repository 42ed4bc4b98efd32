"""Which fused kernel a batch launches: with more lanes when few instances are left, with inputs from outside if any."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from threading import Thread
from typing import Any

from warpmuscle.core.arguments import as_integer
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels.memory.scratch import (
    ALL,
    ENTRIES,
    LEAN,
    LEANER,
    LEANEST,
    NEAR,
    PULLS_A_BODY,
    SLOT_FLOATS,
    capacity_of,
    slots_for,
)
from warpmuscle.kernels.recording.record import NOTHING, RecordKind
from warpmuscle.kernels.step import SHARED_BESIDE_CACHE, WARP
from warpmuscle.kernels.step_parts import StepKind
from warpmuscle.model.bodies import foot_slots
from warpmuscle.model.controllers.outside import driven_from_outside
from warpmuscle.model.muscles import compiled_kind
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.simulation.fused_kernel import GPU_BLOCK, FusedKernel, KernelConfig, is_loaded, resident_blocks
from warpmuscle.simulation.stepper import excited

GPU_LANES = 8
MOST_LANES = 16  # that are of use to a biped
BUSY_WARPS = 11  # of them keep a multiprocessor about as busy as more do
SIDE_BY_SIDE = 32, 16, 8  # instances of a large block: at most one for each thread of a warp ...
FEW_SIDE_BY_SIDE = 4, 1  # ... or, of large characters, fewer
LANES_OF_FEW = 96  # that each of these has at most if paths wrap; others have no more than there are threads in a warp
LARGE_BLOCK = 512  # threads of it ...
LARGE_BLOCK_OF_WRAPS = 384  # ... which leave each as many registers as paths around surfaces need ...
LARGE_BLOCK_OF_LOOPS = 256  # ... and with them what constraints leave to the root
LARGE_BLOCK_IN_MAIN_MEMORY = 512  # ... where lanes wait for main memory, which more of them hide
PATHS_APART = True  # whether a kernel of their own finds paths that take long
SHARED_BYTES = 48 * 1024  # of memory that a block may declare

_sought: set[tuple[Any, str]] = set()  # kernels on devices that were looked for in Warp's cache


class Launcher:
    """The fused kernels that a batch launches, made when they are launched first.

    Attributes:
        config: of the kernel that the batch usually launches.
    """

    def __init__(
        self, config: KernelConfig, device: Any, threads: int, spreads: bool = False, instances: int = 1
    ) -> None:
        """Prepare.

        Args:
            threads: of a CPU. spreads: give more lanes to an instance when few of them are left.
            instances: of the batch.
        """
        self.config = config
        self._device, self._threads, self._spreads, self._instances = device, threads, spreads, instances
        self._kernels: dict[KernelConfig, FusedKernel] = {}

    def kernel(self, config: KernelConfig | None = None) -> FusedKernel:
        """The kernel of a configuration; by default the one that the batch usually launches."""
        config = self.config if config is None else config
        if config not in self._kernels:
            self._kernels[config] = FusedKernel(config, self._device, self._threads, self._instances)
        return self._kernels[config]

    def kernel_for(self, running: int) -> FusedKernel:
        """The usual kernel, or one that is quicker for as few instances as still run, if it is loaded."""
        if self._spreads:
            spread = spread_config(self.config, running, self._device.sm_count)
            if spread is not None and soon_loaded(spread, self._device):
                return self.kernel(spread)
        return self.kernel()

    def read_excitations(self) -> None:
        """From now on launch kernels that read excitations over time."""
        muscles = self.config.kind.muscles
        if muscles is not None:
            many = self.config.block_dim > 1
            self.config = self.config.compiling(muscles=muscles._replace(timed=True, all_timed=many))

    def config_from_outside(self, excitations: bool, torques: bool) -> KernelConfig:
        """The configuration of a kernel that takes excitations (of muscles, if any), torques or both from outside."""
        config = excited(self.config) if excitations else self.config
        return config.compiling(controller=driven_from_outside(config.kind.controller)) if torques else config


def kernel_config(
    scene: Scene, structure: Structure, instances: int, device: Any, lanes: int | None, recorded: RecordKind
) -> KernelConfig:
    """What the step of a batch has compiled in.

    Args:
        lanes: of a GPU that share an instance; None for as many as are usual. recorded: what is asked to be recorded.

    Raises:
        RolloutError: an impossible number of lanes, or the character is too large for them, or for a GPU.
    """
    if lanes is not None:
        as_integer(lanes, "lanes", 1, WARP, error=RolloutError)
    capacity = capacity_of(len(structure.names.bodies))
    kind = StepKind(
        compiled_kind(scene, structure.names, structure.actuation, capacity, lean=not device.is_cpu),
        structure.objective, bool(structure.collision_pairs), bool(structure.kinematic.names), recorded,
        structure.controller, structure.skeleton, structure.force_kinds,
    )  # fmt: skip
    config = KernelConfig(capacity, 1, 1, kind)
    if device.is_cpu:
        return config
    if in_large_blocks(config):
        slots = len(foot_slots(scene, structure.names)[1])
        return large_blocks(config, structure, lanes, slots, instances, device.sm_count)
    return config._replace(
        lanes=usual_lanes(lanes, config.work_floats, instances, device.sm_count), block_dim=GPU_BLOCK
    )


def in_large_blocks(config: KernelConfig) -> bool:
    """Whether instances of a kind share blocks of several warps on a GPU, neighbours taking the same muscle or body.

    That is best where muscles' paths take long, in many ways. All instances of a block wait for one another, so none
    may have something to do that the others do not wait for.
    """
    tests = config.kind.collisions or any(force.touch or force.objects for force in config.kind.forces)
    uniform = not tests and not config.kind.controller.renews
    return config.kind.muscles is not None and config.kind.muscles.long_paths and uniform


def large_blocks(
    config: KernelConfig, structure: Structure, lanes: int | None, slots: int, instances: int, multiprocessors: int
) -> KernelConfig:
    """The configuration in blocks of several warps, with as many instances each as there is shared memory for.

    A warp is then the same lane of up to 32 instances, which follows one muscle's path, reads what is known of the
    muscle once for all of them, and finds what changes of them side by side. Fewer instances share a block, with more
    lanes each, where all of them fit at once so. Pulls of muscles are kept in the working set if as many instances fit
    with them, whatever lanes are asked for: results do not depend on these. What followed coordinates leave is kept in
    main memory if more instances fit so, and so is more of the working set, up to all of it, unless all instances run
    at once without; or if that leaves the first cache room.

    Args:
        slots: of the character's feet.

    Raises:
        RolloutError: an impossible number of lanes, or the character is too large for a GPU.
    """
    if lanes is not None and lanes & (lanes - 1):
        raise RolloutError(f"lanes must be one of 1, 2, 4, 8, 16, 32, not {lanes}")
    assert config.kind.muscles is not None
    config = config._replace(capacity=len(structure.names.bodies))  # no size class: each its own kernel
    if PATHS_APART and config.kind.muscles.may_be_apart:
        config = config.compiling(muscles=config.kind.muscles._replace(apart=True))
    found: list[KernelConfig] = []
    in_scratch = False
    for one, near in ways_of_memory(config):  # what takes least of it last
        if found and found[0].resident(multiprocessors) >= instances:
            break  # all run at once, and what is near is sooner there
        blocks = in_blocks(one, structure, slots, None, near)
        if blocks and (not found or is_better(blocks[0], found[0])):
            found, config, in_scratch = blocks, one, near
    if not found:
        raise RolloutError("the character has more bodies than a GPU block has memory for; simulate it on the CPU")
    if lanes is not None:
        found = in_blocks(config, structure, slots, lanes, in_scratch)
    if not found:
        raise RolloutError(f"lanes must be more than {lanes} for this character")
    fitting = [large for large in found if large.instances_a_block * multiprocessors >= instances]
    return (fitting or found[:1])[-1]


def ways_of_memory(config: KernelConfig) -> Iterator[tuple[KernelConfig, bool]]:
    """Ways to share out memory, and whether pulls of muscles are in the working set."""
    assert config.kind.muscles is not None
    skeleton, muscles = config.kind.skeleton, config.kind.muscles
    ways = [NEAR]
    if skeleton.open > 0:
        ways += [ENTRIES] if muscles.paths.monomials > 0 else [ENTRIES, LEAN]
        ways += [LEANER, LEANEST, ALL] if muscles.paths.monomials == 0 and muscles.shared == 0 else []
    for main in ways:
        with_pulls = muscles.may_be_in_scratch and main < LEANER
        for in_scratch in (True, False) if with_pulls else (False,):
            yield config.compiling(skeleton=skeleton._replace(main=main)), in_scratch


def is_better(one: KernelConfig, before: KernelConfig) -> bool:
    """Whether more instances fit a multiprocessor, or as many that leave its first cache room as others do not."""
    if one.resident(1) != before.resident(1):
        return one.resident(1) > before.resident(1)
    lean: bool = one.kind.skeleton.main >= LEAN > before.kind.skeleton.main
    return lean and one.block_bytes <= SHARED_BESIDE_CACHE < before.block_bytes


def in_blocks(
    config: KernelConfig, structure: Structure, slots: int, lanes: int | None, in_scratch: bool
) -> list[KernelConfig]:
    """The configurations in large blocks that fit a multiprocessor, with ever fewer instances a block.

    Args:
        lanes: None for as many as a block has room for. slots, in_scratch: see `with_room`.
    """
    assert config.kind.muscles is not None
    wraps, threads = config.kind.muscles.wraps, LARGE_BLOCK
    if wraps:
        threads = LARGE_BLOCK_OF_WRAPS
        if config.kind.skeleton.constraints > 0:
            threads = LARGE_BLOCK_OF_LOOPS
        elif config.kind.skeleton.main >= LEANER:
            threads = LARGE_BLOCK_IN_MAIN_MEMORY
    wide, lean = wraps or config.kind.muscles.apart, config.kind.skeleton.main >= LEAN
    for sizes in (SIDE_BY_SIDE, FEW_SIDE_BY_SIDE):
        found = []
        for together in sizes:
            few = together in FEW_SIDE_BY_SIDE or (lean and together == SIDE_BY_SIDE[-1])
            own = min(threads // together, LANES_OF_FEW if few and wide else WARP) if lanes is None else lanes
            large = config._replace(lanes=own, block_dim=max(own * together, 2 * WARP))
            found.append(with_room(large, structure, slots, in_scratch))
        found = [large for large in found if large.block_dim <= threads and large.large_blocks > 0]
        if found:
            return found
    return []


def with_room(config: KernelConfig, structure: Structure, slots: int, in_scratch: bool) -> KernelConfig:
    """The configuration with room for the muscles' pulls in its working set, or without.

    Args:
        slots: of the character's feet. in_scratch: whether pulls are to be in the working set.
    """
    muscles, capacity, crossings = config.kind.muscles, config.capacity, len(structure.actuation.table.crossings)
    assert muscles is not None
    pulls, monomials = 3 * crossings if in_scratch else 0, muscles.paths.monomials
    if muscles.shared > 0:  # shares come where pulls could go on
        slots = max(slots, -(-(len(structure.actuation.muscles) + monomials) // SLOT_FLOATS))
        capacity = max(capacity, -(-pulls // (3 * PULLS_A_BODY)))
    else:
        slots = slots_for(capacity, pulls + monomials, slots)
    config = config._replace(capacity=capacity, slots=slots)
    return config.compiling(muscles=muscles._replace(pulls_in_scratch=in_scratch))


def usual_lanes(lanes: int | None, floats: int, instances: int, multiprocessors: int) -> int:
    """Lanes an instance on a GPU: as asked for, or the usual number, or more.

    More where few instances would leave multiprocessors idle, and where a large character needs it: the working sets of
    the instances of a block, `floats` numbers each, share the block's memory, and those of all blocks the
    multiprocessor's. Results do not depend on it.
    """
    fitting = [n for n in (1, 2, 4, 8, 16, 32) if GPU_BLOCK // n * floats * 4 <= SHARED_BYTES]
    if not fitting:
        raise RolloutError("the character has more bodies than a GPU block has memory for; simulate it on the CPU")
    if lanes is None:
        idle = [n for n in fitting if n <= MOST_LANES and n * instances <= BUSY_WARPS * WARP * multiprocessors]
        least = max(GPU_LANES, fitting[0])
        some = [n for n in fitting if least <= n <= MOST_LANES] or [least]
        busy = max(some, key=lambda n: min(resident_blocks(GPU_BLOCK // n * floats), BUSY_WARPS))
        return max([busy, *idle])
    if lanes not in fitting:
        raise RolloutError(f"lanes must be one of {', '.join(map(str, fitting))} for this character, not {lanes}")
    return lanes


def spread_config(config: KernelConfig, running: int, multiprocessors: int) -> KernelConfig | None:
    """What a kernel is made of with more lanes for so few instances that still run; None if theirs is as good.

    It is the one that replays use, since nothing is recorded where nothing is asked for.
    """
    if config.several_warps:
        return None
    lanes = usual_lanes(None, config.work_floats, running, multiprocessors)
    if lanes <= config.lanes or config.kind.recorded not in (NOTHING, RecordKind()):
        return None
    return config._replace(lanes=lanes).compiling(recorded=RecordKind())


def soon_loaded(config: KernelConfig, device: Any) -> bool:
    """Whether a kernel is loaded; if it need not be compiled, that is begun now, in the background."""
    key = (config, str(device))
    if not is_loaded(config, device) and key not in _sought:
        _sought.add(key)
        Thread(target=_load_if_compiled, args=(config, device), name="kernel").start()
    return is_loaded(config, device)


def _load_if_compiled(config: KernelConfig, device: Any) -> None:
    """Load a kernel if Warp has it in its cache; whoever needs it says what is wrong with it."""
    with suppress(RolloutError):
        kernel = FusedKernel(config, device, threads=1)
        if not kernel.compiles:
            kernel.load()
