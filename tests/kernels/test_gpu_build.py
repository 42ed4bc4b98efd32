"""What the fused step takes of a GPU, read from a build for one (sm_90) that needs none."""

import struct
from pathlib import Path
from typing import Literal

import pytest
import warp as wp

from warpmuscle.formats import load
from warpmuscle.kernels.memory.scratch import capacity_of
from warpmuscle.kernels.recording.record import NOTHING, RecordKind
from warpmuscle.kernels.step import MAX_REGISTERS, step_kernel
from warpmuscle.kernels.step_parts import StepKind
from warpmuscle.model.muscles import compiled_kind, driven
from warpmuscle.model.objective import objective_kind
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.launcher import GPU_BLOCK, GPU_LANES

pytestmark = pytest.mark.long  # they build for a GPU

SHARED_A_BLOCK = 233_472 // 12  # bytes: twelve blocks on a multiprocessor; 1 KiB of each is for the system
FRAME_SIZE, REGISTER_COUNT = 0x11, 0x2F  # attributes of functions in .nv.info


def sections(cubin: bytes) -> dict[str, bytes]:
    """What the sections of an ELF file of 64 bits hold, by name."""
    start, count, names = *struct.unpack_from("<Q", cubin, 0x28), *struct.unpack_from("<HH", cubin, 0x3C)
    table = [struct.unpack_from("<IIQQQQIIQQ", cubin, start + 64 * k) for k in range(count)]
    text = cubin[table[names][4] :]
    found = {}
    for name, kind, _, _, offset, size, *_ in table:
        holds = b"\0" * size if kind == 8 else cubin[offset : offset + size]  # 8: takes memory, but not the file's
        found[text[name : text.index(b"\0", name)].decode()] = holds
    return found


def attribute(info: bytes, wanted: int) -> int:
    """The greatest value of an attribute of functions in .nv.info, a list of attributes of which some have a size."""
    values, place = [], 0
    while place + 4 <= len(info):
        form, found, size = struct.unpack_from("<BBH", info, place)
        if form == 4 and found == wanted:
            values.append(struct.unpack_from("<I", info, place + 8)[0])
        place += 4 + (size if form == 4 else 0)
    return max(values)


Case = tuple[str, RecordKind, Literal["each", "least_effort"]]
CASES: list[Case] = [
    ("fwalk", NOTHING, "each"), ("walk56", NOTHING, "each"), ("walk56", RecordKind(), "each"),
    ("wang2012", NOTHING, "least_effort"),
]  # fmt: skip


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest) -> Case:
    """A scene, what is recorded of it, and whose torques its muscles give."""
    return request.param


@pytest.fixture(scope="module")
def build(case: Case, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Sections of the kernel that a GPU runs for it."""
    name, recorded, sharing = case
    scene = load(name, ignored=[])
    scene.muscle_model.sharing = sharing
    names = topology(scene.character)
    capacity = capacity_of(len(names.bodies))
    muscles = compiled_kind(scene, names, driven(scene, names), capacity, lean=True)
    objective = objective_kind(scene, muscles is not None)
    kernel = step_kernel(capacity, GPU_LANES, GPU_BLOCK, StepKind(muscles, objective, recorded=recorded))
    folder = tmp_path_factory.mktemp(name)
    try:
        wp.compile_aot_module(kernel.module, arch=90, module_dir=folder, use_ptx=False)
    except Exception as error:
        pytest.skip(f"this Warp compiles for no GPU: {error}")
    (cubin,) = Path(folder).glob("*.cubin")
    return sections(cubin.read_bytes())


def test_twelve_warps_fit_a_multiprocessor(build: dict[str, bytes]):
    """48 bipeds at once: registers and shared memory leave room for three warps in each of its quarters."""
    assert 64 < attribute(build[".nv.info"], REGISTER_COUNT) <= MAX_REGISTERS
    (shared,) = (len(holds) for name, holds in build.items() if name.startswith(".nv.shared.step"))
    assert 10_000 < shared <= SHARED_A_BLOCK


def test_nothing_spills_onto_the_stack(build: dict[str, bytes]):
    """Nor do the structures lie there, as they do where a function is called that the compiler does not inline."""
    assert attribute(build[".nv.info"], FRAME_SIZE) == 0


def test_the_step_fits_the_caches_of_instructions_as_it_did(case: Case, build: dict[str, bytes]):
    """Beyond 128 KiB a multiprocessor waits for instructions: with 11 200, for a third of the time of 1024 bipeds.

    Loops that the compiler unrolls, and strides that it does not know, are what makes them many.
    """
    if case[2] != "each":
        pytest.skip("with shared torques it does not fit")
    (text,) = (name for name in build if name.startswith(".text."))
    assert len(build[text]) < (7_800 if case[1] == NOTHING else 8_600) * 16
