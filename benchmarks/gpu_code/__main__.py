"""What nvcc makes of a time step: registers, local memory, loads and atomics.

Usage: python3 benchmarks/gpu_code [--build DIR] [--cuobjdump PATH] [--docs]

Reads the executable of a build for CUDA (build/cuda) with NVIDIA's cuobjdump, which
needs no GPU: it comes with the CUDA toolkit, or from PyPI as nvidia-cuda-cuobjdump
and nvidia-cuda-nvdisasm. A build of some dimensions and bases will do, and takes
minutes:

    tools/setup --preset cuda
    cmake --preset cuda -B build/cuda -D Machpoint_DIMENSIONS="2;3" \\
        -D Machpoint_BASES=quadratic -D Machpoint_ENABLE_MPI=OFF \\
        -D Machpoint_ENABLE_HDF5=OFF -D Machpoint_ENABLE_TESTS=OFF
    cmake --build build/cuda --target machpoint

Prints the kernels of a step; --docs also writes docs/performance.md. Exit code: 1
if one of these keeps data in local memory, which is memory and not a register, or
computes with doubles in a build in single precision. A kernel that has all registers
that its launch bounds give it (RangeOf in core/types.hpp) may keep some numbers there:
that was measured to pay.
"""
import collections
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "performance")]

import options
import page
from kernel_names import STEP, function_of

# Opcodes that compute with doubles, or make or take them.
DOUBLES = r"D(ADD|MUL|FMA|SETP|MNMX)|[FI]2F\.F64|F2[FI]\..*F64|MUFU\.\w+64H"
# Of a Hopper's multiprocessor (CUDA C++ Programming Guide, compute capability
# 9.0): warps, its four parts, registers of a part, and how many a warp takes.
WARPS, PARTS, REGISTERS, UNIT = 64, 4, 16384, 256
# Registers that launch bounds give a thread, and bytes that may not fit them.
BOUNDED, SPILLED = (128, 168), 256

Code = collections.namedtuple("Code", "registers local instructions")


def warps(registers):
    """That a multiprocessor holds of threads with so many registers."""
    taken = -(-registers * 32 // UNIT) * UNIT
    return min(WARPS, PARTS * (REGISTERS // taken))


def spilled(code):
    """Bytes that a kernel may keep in local memory."""
    return SPILLED if code.registers in BOUNDED else 0


def resources(text):
    """{mangled name: (registers, bytes of local memory)} of
    cuobjdump --dump-resource-usage."""
    found = re.findall(r"Function (\S+):\s+REG:(\d+) STACK:(\d+)", text)
    return {name: (int(reg), int(stack)) for name, reg, stack in found}


def instructions(lines):
    """{mangled name: Counter of opcodes} of cuobjdump -sass."""
    counts, own = {}, None
    for line in lines:
        if name := re.match(r"\s*Function : (\S+)", line):
            own = counts.setdefault(name[1], collections.Counter())
        elif own is not None:
            code = re.match(r"\s*/\*[0-9a-f]{4,}\*/\s+(?:@!?U?P\w+\s+)?([A-Z][\w.]*)",
                            line)
            if code:
                own[code[1]] += 1
    return counts


def total(counts, pattern):
    return sum(n for code, n in counts.items() if re.match(pattern, code))


def read(executable, cuobjdump):
    """[(function, arguments, number, Code)] of the kernels of an executable."""
    found = subprocess.run([cuobjdump, "--dump-resource-usage", executable],
                           check=False, capture_output=True, text=True)
    if found.returncode != 0:
        sys.exit(f"{cuobjdump} cannot read {executable}: {found.stderr.strip()}")
    used = resources(found.stdout)
    with subprocess.Popen([cuobjdump, "-sass", executable], text=True,
                          stdout=subprocess.PIPE) as process:
        counts = instructions(process.stdout)
    readable = subprocess.run(["c++filt"], input="\n".join(used), check=True,
                              capture_output=True, text=True).stdout
    kernels = []
    for name, demangled in zip(used, readable.splitlines()):
        if function := function_of(demangled):
            kernels.append((*function, Code(*used[name],
                                            counts.get(name, {}))))
    return kernels


def row(function, arguments, number, code):
    """Of the table."""
    count = code.instructions
    return [STEP[function], f"`{arguments}`, {number}", code.registers,
            warps(code.registers), code.local, sum(count.values()),
            total(count, "LDG"), total(count, r"LDG\.E\.128"),
            total(count, "RED|ATOM")]


def section(kernels, precision="double"):
    """Table of the kernels of a step, a sentence on the others, and the kernels
    of a step that are wrong."""
    # Modules are built for all dimensions.
    built = {arguments for name, arguments, *_ in kernels
             if name == "gridVelocity"}
    step = [kernel for kernel in kernels if kernel[0] in STEP and
            "RoundedTerms" not in kernel[1] and
            built & set(kernel[1].split(", "))]
    if not step:
        sys.exit(f"no kernels called {', '.join(STEP)}")
    order = list(STEP)
    step.sort(key=lambda kernel: (order.index(kernel[0]), *kernel[1:3]))
    text = page.table(["", "template arguments, kernel", "registers",
                       f"warps of {WARPS}", "local memory, B", "instructions",
                       "loads", "of these 16 B", "atomics"],
                      [row(*kernel) for kernel in step])
    others = sorted({f"`{name}`" for name, arguments, _, code in kernels
                     if code.local > 0 and name not in STEP})
    text += ("\nOther kernels that keep data in local memory: " +
             (", ".join(others) if others else "none") + ".\n")
    wrong = [kernel for kernel in step if kernel[3].local > spilled(kernel[3]) or
             precision == "single" and
             total(kernel[3].instructions, DOUBLES) > 0]
    return text, wrong


def made_of(build):
    """Revision, compiler and flags of a build in words, and its precision."""
    unit = (build / "revision.cpp").read_text()
    cache = (build / "CMakeCache.txt").read_text()
    revision = re.search(r'"([0-9a-f]{7,})', unit)
    flags = re.search(r"^CMAKE_CXX_FLAGS_RELEASE:\w+=(.*)$", cache, re.M)
    precision = re.search(r"^Machpoint_PRECISION:\w+=(.*)$", cache, re.M)
    precision = precision[1] if precision else "double"
    return (f"Machpoint `{revision[1] if revision else 'unknown'}`, "
            f"{precision} precision, nvcc with `{flags[1]}`"), precision


def main():
    parser = options.parser(__doc__)
    parser.add_argument("--build", type=pathlib.Path,
                        default=page.ROOT / "build" / "cuda",
                        help="default: build/cuda")
    parser.add_argument("--cuobjdump", default="cuobjdump",
                        help="NVIDIA's; default: the one on the PATH")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/performance.md, too")
    arguments = parser.parse_args()
    if arguments.docs:
        page.require("gpu code")
    executable = arguments.build / "machpoint"
    for name in ("machpoint", "revision.cpp", "CMakeCache.txt"):
        if not (arguments.build / name).exists():
            parser.error(f"{arguments.build / name} is missing; see --build and the "
                         f"top of {os.path.relpath(__file__)}")
    if not shutil.which(arguments.cuobjdump):
        parser.error("no cuobjdump: put the CUDA toolkit's on the PATH, or pip "
                     "install nvidia-cuda-cuobjdump nvidia-cuda-nvdisasm and "
                     "name it with --cuobjdump")
    made, precision = made_of(arguments.build)
    kernels = read(executable, arguments.cuobjdump)
    if not any(code.instructions for *_, code in kernels):
        parser.error(f"{arguments.cuobjdump} showed no machine code of "
                     f"{executable}; it needs nvdisasm beside it or on the "
                     "PATH")
    if any(code.registers == 0 for *_, code in kernels):
        parser.error(f"{arguments.cuobjdump} tells no registers of the kernels of "
                     f"{executable}: build it with optimisation, as the preset does")
    text, wrong = section(kernels, precision)
    text = (f"{page.written_by('gpu_code', arguments.docs)}; {made}.\n\n"
            f"{text}")
    print(text)
    if arguments.docs:
        page.write("gpu code", text)
    for function, arguments, number, code in wrong:
        print(f"{function}<{arguments}>, {number}: {code.local} bytes of local "
              f"memory, {total(code.instructions, DOUBLES)} instructions of "
              "doubles")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
