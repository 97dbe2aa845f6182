"""A yardstick: the loop of plain_loop.cpp in Taichi (pip install taichi).

Usage: python3 taichi_loop.py CELLS STEPS SAMPLES [mixed]

Takes OMP_NUM_THREADS threads. Same problem, same output: a weakly compressible
fluid falls, in double precision, without a sort.
"""
import os

import problem
import taichi as ti

cells, steps, samples, mixed = problem.arguments(__doc__)
ti.init(arch=ti.cpu, default_fp=ti.f64, log_level=ti.ERROR,
        cpu_max_num_threads=int(os.environ.get("OMP_NUM_THREADS", "1")))

n = cells
h = 1 / n
dt = problem.time_step(n)
places, mass = problem.block(n, mixed)
count = len(places)
x = ti.Vector.field(2, float, count)
v = ti.Vector.field(2, float, count)
C = ti.Matrix.field(2, 2, float, count)
J = ti.field(float, count)
grid_v = ti.Vector.field(2, float, (n, n))
grid_m = ti.field(float, (n, n))
x.from_numpy(places)
J.fill(1)


@ti.func
def weights(f):
    return [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1) ** 2, 0.5 * (f - 0.5) ** 2]


@ti.kernel
def to_grid():
    for p in x:
        base = (x[p] * n - 0.5).cast(int)
        f = x[p] * n - base
        w = weights(f)
        stress = -dt * 4 * problem.STIFFNESS * mass * (J[p] - 1) * n * n
        A = ti.Matrix([[stress, 0.0], [0.0, stress]]) + mass * C[p]
        for i, j in ti.static(ti.ndrange(3, 3)):
            dx = (ti.Vector([i, j]) - f) * h
            weight = w[i].x * w[j].y
            node = base + ti.Vector([i, j])
            grid_v[node] += weight * (mass * v[p] + A @ dx)
            grid_m[node] += weight * mass


@ti.kernel
def clear():
    for node in ti.grouped(grid_m):
        grid_v[node] = [0.0, 0.0]
        grid_m[node] = 0.0


@ti.kernel
def advance_nodes():
    for node in ti.grouped(grid_m):
        if grid_m[node] > 0:
            grid_v[node] /= grid_m[node]
        grid_v[node].y -= dt * problem.GRAVITY
        for d in ti.static(range(2)):
            if node[d] < 3:
                grid_v[node][d] = ti.max(grid_v[node][d], 0.0)
            if node[d] > n - 3:
                grid_v[node][d] = ti.min(grid_v[node][d], 0.0)


@ti.kernel
def to_particles():
    for p in x:
        base = (x[p] * n - 0.5).cast(int)
        f = x[p] * n - base
        w = weights(f)
        new_v = ti.Vector.zero(float, 2)
        new_C = ti.Matrix.zero(float, 2, 2)
        for i, j in ti.static(ti.ndrange(3, 3)):
            dx = (ti.Vector([i, j]) - f) * h
            u = w[i].x * w[j].y * grid_v[base + ti.Vector([i, j])]
            new_v += u
            new_C += 4.0 * n * n * u.outer_product(dx)
        v[p] = new_v
        C[p] = new_C
        x[p] += dt * new_v
        J[p] *= 1 + dt * new_C.trace()


def run(number):
    for _ in range(number):
        clear()
        to_grid()
        advance_nodes()
        to_particles()
    ti.sync()


problem.measure(run, lambda: x.to_numpy(), count, steps, samples)
