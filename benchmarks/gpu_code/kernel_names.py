"""Which function of Machpoint a kernel is of, by its name in a CUDA executable."""
import re

# Functions whose kernels make up a step, over particles and then over nodes.
STEP = {
    "particlesToGrid": "P2G of `paper` and `apic`",
    "momentumToGrid": "second P2G of `paper`",
    "updateParticleVelocity": "FLIP of `paper`",
    "updateParticles": "G2P of `paper`",
    "gridToParticlesApic": "G2P of `apic`",
    "depositParticles": "P2G of `conservative`",
    "gatherParticles": "G2P of `conservative`",
    "depositShares": "P2G of conducted heat",
    "conductHeat": "G2P of conducted heat",
    "evaluateGas": "equation of state, survey",
    "gridVelocity": "velocities of nodes",
    "velocityAndBlend": "velocities of nodes, blend",
    "applyPressure": "pressure on nodes",
    "measureMotion": "faces, limiter",
    "stableTimeStep": "time step that holes allow",
}


def function_of(demangled):
    """What a kernel is of: (function, template arguments, number of the kernel in
    it), or None if it is none of Machpoint's."""
    start = re.search(r"(?:ParallelFor|ParallelScan\w*|CombinedFunctorReducer|"
                      r"CombinedReductionFunctorWrapper)<Machpoint::", demangled)
    if not start:
        return None
    # Of a lambda, the function around it; of a class, its own name.
    lambda_at = demangled.find("::{lambda(", start.end())
    if lambda_at >= 0:
        end = opening(demangled, demangled.rindex(")", 0, lambda_at), "()")
    else:
        end = re.compile(r"[,>(]|$").search(demangled, start.end()).start()
    arguments = ""
    if demangled[end - 1] == ">":
        begin = opening(demangled, end - 1, "<>")
        arguments = demangled[begin + 1:end - 1]
        end = begin
    name = re.search(r"\w+$", demangled[:end])[0]
    number = re.match(r"::\{lambda\(.*?\)#(\d+)\}", demangled[lambda_at:]
                      ) if lambda_at >= 0 else None
    return (name, re.sub(r"\w+::", "", arguments),
            int(number[1]) if number else 1)


def opening(text, end, pair):
    """Where the bracket opens that closes at `end`; pair: both of them."""
    depth = 0
    for k in range(end, -1, -1):
        depth += (text[k] == pair[1]) - (text[k] == pair[0])
        if depth == 0:
            return k
    raise ValueError(f"no {pair[0]} for the {pair[1]} at {end}: {text}")
