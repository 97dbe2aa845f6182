"""A yardstick: the loop of plain_loop.cpp in NVIDIA Warp (pip install warp-lang).

Usage: python3 warp_loop.py CELLS STEPS SAMPLES [mixed]

On the CPU Warp takes one thread. Same problem, same output: a weakly
compressible fluid falls, in double precision, without a sort.
"""
import problem
import warp as wp

cells, steps, samples, mixed = problem.arguments(__doc__)
wp.config.quiet = True
wp.init()

places, particle_mass = problem.block(cells, mixed)
count = len(places)
n = wp.constant(cells)
cells_real = wp.constant(wp.float64(cells))
h = wp.constant(wp.float64(1 / cells))
dt = wp.constant(wp.float64(problem.time_step(cells)))
mass = wp.constant(wp.float64(particle_mass))
push = wp.constant(wp.float64(-problem.time_step(cells) * 4 *
                              problem.STIFFNESS * particle_mass * cells ** 2))
fall = wp.constant(wp.float64(problem.time_step(cells) * problem.GRAVITY))
slope = wp.constant(wp.float64(4 * cells ** 2))
half = wp.constant(wp.float64(0.5))
three_halves = wp.constant(wp.float64(1.5))
three_quarters = wp.constant(wp.float64(0.75))


@wp.func
def weights(f: wp.float64):
    g = f - wp.float64(1.0)
    return wp.vec3d(half * (three_halves - f) * (three_halves - f),
                    three_quarters - g * g,
                    half * (f - half) * (f - half))


@wp.func
def distances(f: wp.float64):
    return h * wp.vec3d(-f, wp.float64(1.0) - f, wp.float64(2.0) - f)


@wp.kernel
def to_grid(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d),
            C: wp.array(dtype=wp.mat22d), J: wp.array(dtype=wp.float64),
            grid_v: wp.array2d(dtype=wp.vec2d),
            grid_m: wp.array2d(dtype=wp.float64)):
    p = wp.tid()
    place = x[p] * cells_real
    i0 = int(place[0] - half)
    j0 = int(place[1] - half)
    f = place - wp.vec2d(wp.float64(i0), wp.float64(j0))
    wx = weights(f[0])
    wy = weights(f[1])
    x_to = distances(f[0])
    y_to = distances(f[1])
    stress = push * (J[p] - wp.float64(1.0))
    A = stress * wp.identity(n=2, dtype=wp.float64) + mass * C[p]
    momentum = mass * v[p]
    for i in range(3):
        for j in range(3):
            dx = wp.vec2d(x_to[i], y_to[j])
            weight = wx[i] * wy[j]
            wp.atomic_add(grid_v, i0 + i, j0 + j, weight * (momentum + A * dx))
            wp.atomic_add(grid_m, i0 + i, j0 + j, weight * mass)


@wp.kernel
def advance_nodes(grid_v: wp.array2d(dtype=wp.vec2d),
                  grid_m: wp.array2d(dtype=wp.float64)):
    i, j = wp.tid()
    u = grid_v[i, j]
    if grid_m[i, j] > wp.float64(0.0):
        u = u / grid_m[i, j]
    vx = u[0]
    vy = u[1] - fall
    if i < 3:
        vx = wp.max(vx, wp.float64(0.0))
    if i > n - 3:
        vx = wp.min(vx, wp.float64(0.0))
    if j < 3:
        vy = wp.max(vy, wp.float64(0.0))
    if j > n - 3:
        vy = wp.min(vy, wp.float64(0.0))
    grid_v[i, j] = wp.vec2d(vx, vy)


@wp.kernel
def to_particles(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d),
                 C: wp.array(dtype=wp.mat22d), J: wp.array(dtype=wp.float64),
                 grid_v: wp.array2d(dtype=wp.vec2d)):
    p = wp.tid()
    place = x[p] * cells_real
    i0 = int(place[0] - half)
    j0 = int(place[1] - half)
    f = place - wp.vec2d(wp.float64(i0), wp.float64(j0))
    wx = weights(f[0])
    wy = weights(f[1])
    x_to = distances(f[0])
    y_to = distances(f[1])
    new_v = wp.vec2d()
    new_C = wp.mat22d()
    for i in range(3):
        for j in range(3):
            dx = wp.vec2d(x_to[i], y_to[j])
            u = wx[i] * wy[j] * grid_v[i0 + i, j0 + j]
            new_v = new_v + u
            new_C = new_C + wp.outer(u, dx)
    new_C = slope * new_C
    v[p] = new_v
    C[p] = new_C
    x[p] = x[p] + dt * new_v
    J[p] = J[p] * (wp.float64(1.0) + dt * wp.trace(new_C))


device = "cpu"
x = wp.array(places, dtype=wp.vec2d, device=device)
v = wp.zeros(count, dtype=wp.vec2d, device=device)
C = wp.zeros(count, dtype=wp.mat22d, device=device)
J = wp.full(count, 1.0, dtype=wp.float64, device=device)
grid_v = wp.zeros((cells, cells), dtype=wp.vec2d, device=device)
grid_m = wp.zeros((cells, cells), dtype=wp.float64, device=device)
# No gradients are wanted, and their code would double the compile time.
wp.set_module_options({"enable_backward": False})


def run(number):
    for _ in range(number):
        grid_v.zero_()
        grid_m.zero_()
        wp.launch(to_grid, count, [x, v, C, J, grid_v, grid_m], device=device)
        wp.launch(advance_nodes, (cells, cells), [grid_v, grid_m],
                  device=device)
        wp.launch(to_particles, count, [x, v, C, J, grid_v], device=device)


problem.measure(run, x.numpy, count, steps, samples)
