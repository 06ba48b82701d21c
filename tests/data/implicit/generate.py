"""The implicit time step of a truss robot in plain NumPy, and the reference cases of this folder.

`python3 generate.py` writes the cases as JSON beside this file, `python3 generate.py NAME...` only these cases;
`README.md` describes the algorithm and the files. The program is independent of the Rust code. SI units, float64; shapes
are [nodes, D] and [edges, D], where D is 2 in the plane and 3 in space. Everything also works with complex numbers, for
complex-step derivatives: choices look at real parts only.
"""
import itertools
import json
import pathlib
import sys

import numpy as np

STICKIEST = 1e8  # bounds the drag of friction: this many times the trace of the node's block of the matrix
REST = 1e-6  # a node that meets the ground rests there if it moves along the ground more slowly than this, m/s


class Dual:
    """A value with its slopes: the derivatives by the length and by the rate of a bar."""
    __array_ufunc__ = None

    def __init__(self, value, slopes=0.0):
        self.value, self.slopes = value, slopes

    def __add__(self, other):
        other = other if isinstance(other, Dual) else Dual(other)
        return Dual(self.value + other.value, self.slopes + other.slopes)

    def __mul__(self, other):
        other = other if isinstance(other, Dual) else Dual(other)
        return Dual(self.value * other.value, self.slopes * other.value + self.value * other.slopes)

    def __sub__(self, other):
        return self + other * -1.0

    __rmul__ = __mul__

    def positive(self):
        return self * np.where(np.real(self.value) > 0, 1.0, 0.0)


def positive(x):
    return np.where(np.real(x) > 0, x, 0.0)


def size(x):
    return np.where(np.real(x) < 0, -x, x)


def bounded(x, least, most):
    return np.where(x.real <= least, least, np.where(x.real >= most, most, x))


def dot(a, b):
    return (a * b).sum(-1)


def length(a):
    """The lengths of vectors; their derivative is 0 at the zero vector."""
    square = dot(a, a)
    rests = square.real == 0
    return np.where(rests, 0.0, np.sqrt(np.where(rests, 1.0, square)))


def outer(a):
    return a[:, :, None] * a[:, None, :]


def upright(forward, up, dimension):
    return np.array([forward, up] if dimension == 2 else [forward, 0.0, up])


def along(matrices, vectors):
    return np.einsum("nab,nb->na", matrices, vectors)


class Ground:
    """Straight segments in the ground's frame: level before the first point of the profile and after the last. In space it
    is a plane."""

    def __init__(self, points=(), dimension=2):
        points = [np.array(p, float) for p in points]
        level = np.array([1.0, 0.0])
        ends = [(points[0], level, points[0][0])] if points else [(np.zeros(2), level, np.inf)]
        ends += [(a, (b - a) / np.hypot(*(b - a)), b[0]) for a, b in zip(points, points[1:])]
        ends += [(points[-1], level, np.inf)] if points else []
        self.point, self.tangent = np.array([e[0] for e in ends]), np.array([e[1] for e in ends])
        self.normal = np.stack([-self.tangent[:, 1], self.tangent[:, 0]], -1)
        if dimension == 3:
            self.normal, self.point = np.insert(self.normal, 1, 0.0, 1), np.insert(self.point, 1, 0.0, 1)
        self.end = np.array([e[2] for e in ends])

    def height(self, x, segment):
        return dot(self.normal[segment], x - self.point[segment])

    def meet(self, x, v, left, but):
        """The first segment that each node meets within the time `left`, except number `but`; -1 for none. Also the
        earliest and latest possible time of impact."""
        x, v = x.real, v.real
        speed = np.where(np.abs(v[:, 0]) < 1e-30, 1e-30, v[:, 0])
        met, first_met, last_met = np.full(len(x), -1), left.copy(), left.copy()
        enters = -np.inf * speed
        for k in range(len(self.point)):
            leaves = (self.end[k] - x[:, 0]) / speed
            first = np.maximum(np.minimum(enters, leaves), 0.0)
            last = np.minimum(np.maximum(enters, leaves), left)
            enters = leaves
            out = dot(self.normal[k], v)
            hit = (self.height(x, k) + last * out < 0) & (out < 0) & (first < last) & (first < first_met) & (but != k)
            met, first_met = np.where(hit, k, met), np.where(hit, first, first_met)
            last_met = np.where(hit, last, last_met)
        return met, np.maximum(first_met - 1e-3 * left, 0.0), last_met


class Robot:
    """Bars, masses, laws and ground. `strain` is the strain of the target length at full activation."""

    def __init__(self, edges, l0, k, strain, mass, dt, gravity=9.81, gamma=0.0, angle=0.0, mu=np.inf, ground=None,
                 softening=1e-12, cubic=0.0, damper=0.0, stop_at=0.35, stop_stiffness=0.0, dimension=2):
        self.dimension, self.eye = dimension, np.eye(dimension)
        self.i, self.j = np.array(edges).T
        self.l0, self.k, self.strain, self.m = np.asarray(l0), np.asarray(k), np.asarray(strain), np.asarray(mass)
        self.dt, self.decay, self.mu, self.softening = dt, np.exp(-gamma * dt), mu, softening
        self.cubic, self.damper, self.stop_at, self.stop_stiffness = cubic, damper, stop_at, stop_stiffness
        self.g = -gravity * upright(np.sin(angle), np.cos(angle), dimension)
        self.ground = Ground(dimension=dimension) if ground is None else ground  # False: no ground
        self.bumpers = self.pairs = None

    def rest(self, x):
        """Finds the pairs of a node and an edge that the bumpers keep apart, from the positions at rest."""
        shortest, pairs = self.l0.min(), []
        for edge, (i, j) in enumerate(zip(self.i, self.j)):
            for node in set(range(len(x))) - {i, j}:
                along = (x[node] - x[i]) @ (x[j] - x[i]) / ((x[j] - x[i]) @ (x[j] - x[i]))
                away = np.linalg.norm(x[node] - x[i] - np.clip(along, 0.0, 1.0) * (x[j] - x[i]))
                if 1e-3 * shortest <= away <= self.bumpers["reach"] * shortest:
                    pairs.append((node, edge, min(0.5 * away, self.bumpers["distance"] * shortest)))
        node, edge, self.clearance = map(np.array, zip(*pairs))
        self.pairs = node, edge

    def bumps(self, x):
        """The impulses of the bumpers on the nodes over dt, and the number of pairs that touch."""
        out = np.zeros_like(x)
        if not self.bumpers:
            return out, 0
        (node, edge), of_nodes = self.pairs, np.zeros(len(x), self.k.dtype)
        for ends in (self.i, self.j):
            np.add.at(of_nodes, ends, self.k)
        i, j, law, bar, at_node = self.i[edge], self.j[edge], self.bumpers["stiffness"], self.k[edge], of_nodes[node]
        d, to_node = x[j] - x[i], x[node] - x[i]
        share = bounded(dot(to_node, d) / (dot(d, d) + self.softening), 0.0, 1.0)
        apart = to_node - share[:, None] * d
        gap = np.sqrt(dot(apart, apart) + self.softening)
        depth = positive(self.clearance - gap)
        stiffness = law * bar * at_node / (law * (bar + at_node) + bar * at_node + 1e-24)
        push = (self.dt * stiffness * depth / gap)[:, None] * apart
        out = out + 0.0 * push.sum()
        np.add.at(out, node, push)
        np.subtract.at(out, i, (1.0 - share)[:, None] * push)
        np.subtract.at(out, j, share[:, None] * push)
        return out, int((depth.real > 0).sum())

    def tension(self, length, rate, activation):
        """Spring (Hooke or stiffening), damper and stops, with slopes."""
        length, rate = Dual(length, np.array([[1.0], [0.0]])), Dual(rate, np.array([[0.0], [1.0]]))
        change = length - self.l0 * (1.0 + self.strain * activation)
        force = self.k * change + self.k * self.cubic * change * change * change + self.k * self.damper * rate
        longer = length - self.l0 * (1.0 + self.stop_at)
        shorter = (length - self.l0 * (1.0 - self.stop_at)) * -1.0
        return force + self.strain / self.stop_at * self.stop_stiffness * (longer.positive() - shorter.positive())

    def bars(self, x, v, activation):
        d = x[self.j] - x[self.i]
        length = np.sqrt(dot(d, d) + self.softening)
        u = d / length[:, None]
        return u, length, self.tension(length, dot(u, v[self.j] - v[self.i]), activation)

    def gather(self, impulse):
        """Sums at nodes: an edge's impulse acts on its first node, and the opposite impulse on its second."""
        out = np.zeros((len(self.m), self.dimension), impulse.dtype)
        np.add.at(out, self.i, impulse)
        np.subtract.at(out, self.j, impulse)
        return out

    # ---------------------------------------------------------------- the explicit step (section 4)
    def respond(self, vt, vn):
        """The contact law: the velocity along the ground after an impact."""
        if np.isinf(self.mu):
            return 0.0 * vt
        if self.mu == 0:
            return vt
        speed = length(vt)
        return positive(1.0 - self.mu * size(vn) / np.where(speed.real == 0, 1.0, speed))[:, None] * vt

    def drift(self, x, v, own):
        """Moves the nodes for dt over the ground. Nodes ignore the segment `own` (-1: none)."""
        left = np.full(len(x), self.dt) + 0.0 * v[:, 0]
        for _ in range(2 if self.ground else 0):
            met, earliest, latest = self.ground.meet(x, v, left.real, own)
            own = np.where(met >= 0, met, own)
            touches, n = met >= 0, self.ground.normal[met]
            vn = dot(n, v)
            time = -self.ground.height(x, met) / np.where(touches, vn, -1.0)
            time = bounded(time, earliest, latest)
            x = np.where(touches[:, None], x + time[:, None] * v, x)
            left = np.where(touches, left - time, left)
            v = np.where(touches[:, None], self.respond(v - vn[:, None] * n, vn), v)
        if self.ground:
            v = np.where((self.ground.meet(x, v, left.real, own)[0] >= 0)[:, None], 0.0, v)
        return x + left[:, None] * v, v

    def explicit(self, x, v, activation):
        u, _, force = self.bars(x, v, activation)
        impulse = self.gather(self.dt * force.value[:, None] * u)
        return self.drift(x, self.decay * v + impulse / self.m[:, None] + self.dt * self.g, np.full(len(x), -1))

    # ---------------------------------------------------------------- the implicit step (README)
    def linearised(self, x, v0, activation, dt):
        """Per edge: the impulse over dt at (x, v0), and the slopes dt^2 K and dt D as positive semidefinite blocks."""
        u, length, force = self.bars(x, v0, activation)
        uu = outer(u)
        k, c = positive(force.slopes + 0.0 * length)
        across = positive(force.value) / length
        stiff = dt * dt * (k[:, None, None] * uu + across[:, None, None] * (self.eye - uu))
        return dt * force.value[:, None] * u, stiff, dt * c[:, None, None] * uu

    def held_solve(self, node, edge, residual, fixed):
        """The correction y with A y = -residual in the free directions and y = 0 in the held directions. A has a block
        per node plus the Laplacian of a block per edge. `fixed` projects onto the held directions of each node."""
        count, nodes = len(residual), np.arange(len(residual))
        size = self.dimension
        a = np.zeros((count, size, count, size), np.result_type(edge, node))
        a[nodes, :, nodes, :] += node
        for p, q, sign in ((self.i, self.i, 1), (self.j, self.j, 1), (self.i, self.j, -1), (self.j, self.i, -1)):
            np.add.at(a, (p, slice(None), q), sign * edge)
        free = self.eye - fixed
        a = np.einsum("nab,nbmc,mcd->namd", free, a, free)
        a[nodes, :, nodes, :] += fixed
        return np.linalg.solve(a.reshape(size * count, -1), along(free, -residual).reshape(-1)).reshape(count, size)

    def implicit(self, x, v, activation, passes=2, log=None):
        dt, m, count = self.dt, self.m[:, None], len(x)
        v0 = self.decay * v + dt * self.g
        kick, stiff, viscous = self.linearised(x, v0, activation, dt)
        bumped, touching = self.bumps(x)
        at, rate, base = 0.0 * v0, v0, x
        eye, between = self.eye, lambda w: w[self.j] - w[self.i]
        diagonal = (m[:, None] * eye + 0.0 * v0[:, :, None]).astype(np.result_type(v0, stiff))
        for ends in (self.i, self.j):
            np.add.at(diagonal, ends, stiff + viscous)
        stickiest = STICKIEST * np.trace(diagonal.real, axis1=1, axis2=2)

        def bars(w):
            return kick + along(stiff, between(w - at)) + along(viscous, between(w - rate))

        def residual(w):
            """The impulse that the bars do not explain if the nodes move with the velocity w."""
            return m * (w - v0) - self.gather(bars(w)) - bumped

        zero, none = 0.0 * v0[:, 0], np.full(count, -1)
        held, stick, segment = none > 0, none > 0, 0 * none
        impact, slip_to, drag, lam_n, lam_t, w, slid, fresh = zero, 0.0 * v0, zero, zero, 0.0 * v0, v0, zero, held
        n, ahead = np.zeros((count, self.dimension)), lambda w: w - dot(n, w)[:, None] * n
        for number in range(passes):
            if self.ground:
                # 1. Which nodes are held: those with a reaction that pushes, and those that now end in the ground.
                met = self.ground.meet(x, w, np.full(count, dt), none)[0]
                old = held & (lam_n.real > 0)
                new = (met >= 0) & ~held
                held, segment = old | new, np.where(new, met, segment)
                n = self.ground.normal[segment]
                height, vn, vt = self.ground.height(x, segment), dot(n, w), ahead(w)
                # 2. Friction: the velocity `slip_to` along the ground with which a node that stops at the impact moves
                # on average, and a drag towards it. Nodes at rest stick; the others slide in their first pass.
                time = bounded(-height / np.where(new, vn, -1.0), 0.0, dt)
                impact = np.where(new, time, impact)
                rests = new & (length(ahead(v)).real < REST) & (self.mu > 0)
                lands = (new | fresh) & ~stick & ~rests
                slip_to = np.where(lands[:, None], (impact / dt)[:, None] * vt, slip_to)
                fresh = new
                speed, brakes = length(vt - slip_to), length(lam_t)
                grip = self.mu * positive(lam_n) if self.mu < np.inf else zero
                slips = old & stick & (brakes.real > grip.real) & (self.mu < np.inf)
                slides = old & ~stick
                stick = (old & stick & ~slips) | rests
                drag = zero
                if self.mu < np.inf:
                    if number > 0:
                        grip = np.where(new, self.mu * self.m * size(vn) * (1.0 - time / dt), grip)
                    excess, slow = brakes - grip, speed.real < 1e-30
                    towards = lam_t / np.where(brakes.real == 0, 1.0, brakes)[:, None]
                    drag = np.where(slides | (new & (number > 0)), grip / np.where(slow, 1e-30, speed), drag)
                    drag = np.where(slips, grip * dot(towards, along(diagonal, towards)) / np.where(slips, excess, 1.0), drag)
                    drag = np.where(drag.real < stickiest, drag, stickiest)
                elif number > 0:
                    stick = held
                slid = np.where(slides, speed, 0.0)
                # 3. The held directions, their velocities, and the solve.
                wn, wt = np.where(held, -positive(height) / dt, vn), np.where(stick[:, None], slip_to, vt)
                w = wn[:, None] * n + wt
            flat = eye - outer(n)  # projects onto the ground
            fixed = held[:, None, None] * outer(n) + stick[:, None, None] * flat
            node = m[:, None] * eye + drag[:, None, None] * flat
            external = -drag[:, None] * (ahead(w) - slip_to)
            if number > 0:
                at = rate = last
                base = x + dt * last
                kick, stiff, viscous = self.linearised(base, last, activation, dt)
                bumped, touching = self.bumps(base)
            w = last = w + self.held_solve(node, stiff + viscous, residual(w) - external, fixed)
            reaction = residual(w)
            lam_n, lam_t = dot(n, reaction), ahead(reaction)
        # 4. The drift. Held nodes end on their segment; all others meet the ground as in the explicit step.
        x1, v1 = self.drift(x, w, np.where(held, segment, -1))
        again = np.abs(v1 - w).max(1) > 0
        if self.ground:
            stops = stick | (length(ahead(w) - slip_to).real < 0.5 * slid.real)
            resting = np.where(stops[:, None], 0.0, self.respond(ahead(w), dot(n, w)))
            v1 = np.where((held & ~again)[:, None], resting, v1)
        if log is not None:
            d = between(base)
            u = d / np.sqrt(dot(d, d) + self.softening)[:, None]
            tension = dot(u, bars(w)) / dt
            # An impulse does its work at the mean of the velocities before it and after it.
            net = -dot(bars(w), between(v + 0.5 * (w - v)))
            log.append(dict(reaction=held[:, None] * reaction, held=held, stick=stick, again=again & ~held, lam_n=held * lam_n, w=w,
                            bar=bars(w), tension=tension, work=positive(net), net=net, touching=np.array(touching)))
        return x1, v1


# -------------------------------------------------------------------- cases
SCENE = dict(columns=3, rows=2, spacing=0.1, origin_x=0.1, drop=0.004, ground_height=0.1, alpha_deg=0.0, gravity=9.81,
             gamma=1.0, m_eps=1e-3, payload_mass=0.02, dt=0.002, contact="coulomb", mu=1.0, omega=20.0, n_cpg=2,
             goal=[2.0, 0.1], offset_scale=1.0, velocity_scale=0.3, beta=20.0, profile=[], stiffening=0.0,
             damper_time=0.0, stops_at=0.35, stops_stiffness=0.0, passes=2,
             library=dict(k=[1e-7, 400.0, 30.0], rho=[1e-8, 0.03, 0.1], a_max=[0.0, 0.0, 0.35]))
CASES = dict(
    flight=(dict(contact="none", drop=0.3), [0.3, 1.0], 6.0, "free flight with rotation"),
    drop_infinite=(dict(contact="infinite"), [0.2, -0.4], 1.0, "lands and sticks"),
    slide_mu0_4=(dict(mu=0.4, drop=0.002), [0.8, -0.2], 0.0, "lands, slides and is slowed down"),
    slope_15deg=(dict(mu=0.6, alpha_deg=15.0), [0.2, -0.4], 1.0, "lands on a slope"),
    damper_stops=(dict(damper_time=3e-4, stops_at=0.08, stops_stiffness=1300.0, stiffening=30.0), [0.5, -1.0], 2.0,
                  "all laws along bars; actuators reach their stops"),
    stiff_1e6=(dict(library=dict(k=[1e-7, 1e6, 30.0], rho=[1e-8, 0.03, 0.1], a_max=[0.0, 0.0, 0.35])),
               [0.3, -0.3], 1.0, "a stiff skeleton: 2500 times the stiffness that is stable with the explicit step"),
    three_passes=(dict(passes=3, mu=0.8), [0.4, -0.5], 1.0, "three passes"),
    profile=(dict(drop=0.029, profile=[[0.05, 0.0], [0.25, 0.02], [0.4, 0.0]]), [0.5, -0.4], 0.0, "four segments"),
    bumpers=(dict(contact="none", bumpers=dict(stiffness=2000.0, distance=0.9, reach=3),
                  library=dict(k=[1e-7, 4.0, 3.0], rho=[1e-8, 0.03, 0.1], a_max=[0.0, 0.0, 0.35])), [0.3, 1.0], 2.0,
             "a lattice whose nodes fly at each other, until nodes and bars push each other apart"),
)
SPACE = dict(dimension=3, body_diagonals=False, columns=2, depth=2, rows=2, origin_y=0.0, goal=[2.0, 0.3, 0.1])
CASES |= dict(
    space_flight=(dict(SPACE, contact="none", drop=0.3), [0.3, -0.2, 1.0], 6.0, "free flight with rotation, in space"),
    space_drop_infinite=(dict(SPACE, contact="infinite"), [0.2, 0.3, -0.4], 1.0, "lands and sticks, in space"),
    space_slide_mu0_4=(dict(SPACE, mu=0.4, drop=0.002), [0.6, 0.5, -0.2], 0.0, "slides obliquely and is slowed down"),
    space_slope_15deg=(dict(SPACE, mu=0.6, alpha_deg=15.0, columns=3), [0.2, 0.2, -0.4], 1.0, "lands on a slope, in space"),
    space_damper_stops=(dict(SPACE, damper_time=3e-4, stops_at=0.08, stops_stiffness=1300.0, stiffening=30.0),
                        [0.5, 0.4, -1.0], 2.0, "all laws along bars in space; actuators reach their stops"),
    space_stiff_1e6=(dict(SPACE, library=dict(k=[1e-7, 1e6, 30.0], rho=[1e-8, 0.03, 0.1], a_max=[0.0, 0.0, 0.35])),
                     [0.3, 0.2, -0.3], 1.0, "a stiff skeleton in space"),
    space_three_passes=(dict(SPACE, passes=3, mu=0.8), [0.4, -0.3, -0.5], 1.0, "three passes, in space"),
)
NAMES = ("z", "w1", "b1", "w2", "b2", "x0", "v0")


def dimension(scene):
    return scene.get("dimension", 2)


def lattice(scene):
    columns, rows, depth = scene["columns"], scene["rows"], scene.get("depth", 1)
    places = list(itertools.product(range(rows), range(depth), range(columns)))
    grid = [[scene["origin_x"] + c * scene["spacing"], a * scene["spacing"], scene["drop"] + r * scene["spacing"]]
            for r, a, c in places]
    if dimension(scene) == 3:
        # Neighbours along the axes, and over both diagonals of each face.
        steps = [step for step in itertools.product((0, 1), (-1, 0, 1), (-1, 0, 1))
                 if step > (0, 0, 0) and np.count_nonzero(step) <= 2]
        edges = [[i, places.index(other)] for i, place in enumerate(places) for step in steps
                 if (other := tuple(np.add(place, step))) in places]
        return np.array(grid) @ turned(scene) + upright(0.0, scene["ground_height"], 3), sorted(edges)
    edges = [[r * columns + c, (r + up) * columns + c + right] for r in range(rows) for c in range(columns)
             for right, up in ((1, 0), (0, 1), (1, 1), (-1, 1)) if 0 <= c + right < columns and r + up < rows]
    return np.delete(grid, 1, 1) @ turned(scene) + upright(0.0, scene["ground_height"], 2), edges


def turned(scene):
    """Row vectors in the ground's frame times this matrix are vectors in the world's frame."""
    angle, last = np.radians(scene["alpha_deg"]), dimension(scene) - 1
    turn = np.eye(last + 1)
    turn[0], turn[last] = upright(np.cos(angle), np.sin(angle), last + 1), upright(-np.sin(angle), np.cos(angle), last + 1)
    return turn


def rollout(scene, edges, l0, given, steps, kind="implicit", log=None):
    """The start and the states after each step, in the world's frame, and the robot."""
    library = scene["library"]
    mixture = np.exp(scene["beta"] * given["z"])
    mixture = mixture / mixture.sum(-1, keepdims=True)
    mass = np.full(len(given["x0"]), scene["m_eps"]) + 0.0 * mixture[0, 0]
    for end in np.array(edges).T:
        np.add.at(mass, end, 0.5 * l0 * (mixture @ library["rho"]))
    mass[0] += scene["payload_mass"]
    mu = dict(infinite=np.inf, coulomb=scene.get("mu"), none=0.0)[scene["contact"]]
    ground = False if scene["contact"] == "none" else Ground(scene.get("profile", ()), dimension(scene))
    robot = Robot(edges, l0, mixture @ library["k"], mixture[:, 2] * library["a_max"][2], mass, scene["dt"],
                  scene["gravity"], scene["gamma"], np.radians(scene["alpha_deg"]), mu, ground,
                  cubic=scene.get("stiffening", 0.0), damper=scene.get("damper_time", 0.0),
                  stop_at=scene.get("stops_at", 0.35), stop_stiffness=scene.get("stops_stiffness", 0.0),
                  dimension=dimension(scene))
    turn, origin = turned(scene), upright(0.0, scene["ground_height"], dimension(scene))
    robot.bumpers = scene.get("bumpers")
    if robot.bumpers:
        robot.rest((given["x0"].real - origin) @ turn.T)
    x, v = (given["x0"] - origin) @ turn.T, given["v0"] @ turn.T
    clock = 2.0 * np.pi * np.arange(scene["n_cpg"]) / scene["n_cpg"]
    states = [(given["x0"], given["v0"])]
    for step in range(steps):
        place = x @ turn + origin
        observed = np.concatenate([np.sin(scene["omega"] * step * scene["dt"] + clock), scene["goal"],
                                   scene["offset_scale"] * (place - place.mean(0)).ravel(),
                                   scene["velocity_scale"] * (v @ turn).ravel()])
        activation = np.tanh(given["w2"] @ np.tanh(given["w1"] @ observed + given["b1"]) + given["b2"])
        if kind == "explicit":
            x, v = robot.explicit(x, v, activation)
        else:
            x, v = robot.implicit(x, v, activation, scene["passes"], log)
        states.append((x @ turn + origin, v @ turn))
    return states, robot


def loss(scene, states):
    return -dot(turned(scene)[0], states[-1][0][0])


# The tolerances of the tests, in the L2 norm. The largest errors that were found are 1e-13, in states and in gradients;
# they are rounding, which grows by about a thousand times in these rollouts (see `sensitivity`).
TOLERANCE = dict(algebraic=1e-12, early=1e-12, forward=1e-11, gradient=1e-11, gradient_z=1e-11)


def in_file(scene):
    """The scene with the keys that `cosmic` knows. `cosmic` needs settings of its projections that are not used here."""
    own = ("damper_time", "stops_at", "stops_stiffness", "stiffening", "bumpers")
    forces = [dict(damper=dict(time=scene["damper_time"]))] if scene["damper_time"] else []
    if scene["stops_stiffness"]:
        forces.append(dict(stops=dict(at=scene["stops_at"], stiffness=scene["stops_stiffness"])))
    if scene["stiffening"]:
        forces.append(dict(stiffening=dict(cubic=scene["stiffening"])))
    if "bumpers" in scene:
        forces.append(dict(bumpers=scene["bumpers"]))
    kept = {key: value for key, value in scene.items() if key not in own}
    return dict(kept, integrator="implicit", forces=forces, beta_stab=500.0, beta_ste=20.0, delta=1e-6)


def check_explicit(folder):
    """The explicit step of this program agrees with the reference cases in `folder`."""
    for path in sorted(folder.glob("*_*_*.json")):
        case = json.loads(path.read_text())
        if case["projection"] != "performance" or case["steps"] > 200:
            continue
        given = {name: np.array({**case, **case["controller"]}[name]) for name in NAMES}
        states, _ = rollout(case["scene"], case["edges"], np.array(case["l0"]), given, case["steps"], "explicit")
        error = max(np.abs(states[int(step)][0] - np.array(state["x"])).max()
                    for step, state in case["results"]["trajectory"].items())
        print(f"explicit step, {path.stem}: {error:.1e} m")
        assert error < 1e-10


def check_budget(scene, states, robot, log):
    """The works of bars, bumpers apart, gravity, drag and ground add up to the change of the kinetic energy in each step."""
    if scene.get("bumpers"):
        return
    turn, m, dt = turned(scene), robot.m[:, None], scene["dt"]
    for (_, before), (_, after), entry in zip(states, states[1:], log):
        v, end = before @ turn.T, after @ turn.T
        pushed = end if scene["contact"] == "none" else entry["w"]
        impulses = m * ((robot.decay - 1.0) * v + dt * robot.g) + entry["reaction"]
        works = entry["net"].sum() + (impulses * (v + pushed) / 2).sum() + (m * (end**2 - pushed**2) / 2).sum()
        assert abs((m * (end**2 - v**2) / 2).sum() - works) / dt < 1e-9


def write(name, changes, velocity, spin, note, seed, steps=40, hidden=2):
    scene, rng = {**SCENE, **changes}, np.random.default_rng(seed)
    positions, edges = lattice(scene)
    l0 = np.array([np.linalg.norm(positions[i] - positions[j]) for i, j in edges])
    inputs = scene["n_cpg"] + dimension(scene) * (1 + 2 * len(positions))
    around = [[0.0, 1.0], [-1.0, 0.0]] if dimension(scene) == 2 else [[0.0, 0.6, 1.0], [-0.6, 0.0, 0.3], [-1.0, -0.3, 0.0]]
    start = np.array(velocity) @ turned(scene) + spin * (positions - positions.mean(0)) @ around
    given = dict(z=rng.uniform(0.2, 0.5, (len(edges), 3)), w1=rng.uniform(-0.5, 0.5, (hidden, inputs)),
                 b1=rng.uniform(-0.2, 0.2, hidden), w2=rng.uniform(-0.8, 0.8, (len(edges), hidden)),
                 b2=rng.uniform(-0.3, 0.3, len(edges)), x0=positions + rng.uniform(-1e-3, 1e-3, positions.shape),
                 v0=start + rng.uniform(-0.05, 0.05, positions.shape))
    if "bumpers" in changes:
        given["v0"] = given["v0"] - (given["x0"] - given["x0"].mean(0)) * [25.0, 0.0]
    given = {key: np.round(value, 5) for key, value in given.items()}
    states, robot = rollout(scene, edges, l0, given, steps, log=(log := []))
    check_budget(scene, states, robot, log)
    run = lambda given: rollout(scene, edges, l0, given, steps)[0]

    def moved(size):
        shift = [size * rng.choice([-1.0, 1.0], positions.shape) for _ in range(3)]
        others = [run({**given, "x0": given["x0"] + s}) for s in shift]
        return max(float(np.abs(np.array(other) - states).max()) for other in others)

    def slope(key, index):
        changed = given[key].astype(complex)
        changed[index] += 1e-30j
        return loss(scene, run({**given, key: changed})).imag / 1e-30

    gradient = {key: np.array([slope(key, i) for i in np.ndindex(given[key].shape)]).reshape(given[key].shape)
                for key in NAMES}
    along_all = {key: rng.normal(size=given[key].shape) * (1e-3 if key in ("x0", "v0") else 1.0) for key in NAMES}
    ahead, behind = [loss(scene, run({k: given[k] + s * along_all[k] for k in NAMES})) for s in (1e-6, -1e-6)]
    difference, exact = (ahead - behind) / 2e-6, sum((gradient[k] * along_all[k]).sum() for k in NAMES)
    print(f"{name}: gradient along one direction {exact:.8e}, by differences {difference:.8e}")
    count = lambda f: int(sum(f(entry).sum() for entry in log))
    case = dict(name=name, note=note, scene=in_file(scene), edges=edges, l0=l0.tolist(), x0=given["x0"].tolist(),
                v0=given["v0"].tolist(), z=given["z"].tolist(),
                controller={key: given[key].tolist() for key in NAMES[1:5]}, steps=steps, projection="performance",
                al=dict(zip(("lambda", "tau", "thresholds"), [[0.0] * 4] * 3)), tolerance=TOLERANCE,
                sensitivity={"1e-12": moved(1e-12), "1e-7": moved(1e-7)},
                coverage=dict(held=count(lambda e: e["held"]), stick=count(lambda e: e["stick"]),
                              pulls=count(lambda e: e["lam_n"] < 0), again=count(lambda e: e["again"]),
                              touching=count(lambda e: e["touching"]), reaction_last=log[-1]["lam_n"].tolist(),
                              tension_last=log[-1]["tension"].tolist(),
                              **{key: sum(e[key] for e in log).tolist() for key in ("work", "net")}),
                results=dict(node_mass=robot.m.tolist(),
                             trajectory={str(k): dict(x=states[k][0].tolist(), v=states[k][1].tolist())
                                         for k in (0, 1, 2, 3, 10, 20, 30, steps)},
                             l_disp=float(loss(scene, states)),
                             grad_l_disp={key: gradient[key].tolist() for key in NAMES}))
    print("   ", case["coverage"], case["sensitivity"])
    (pathlib.Path(__file__).parent / f"{name}.json").write_text(json.dumps(case) + "\n")


if __name__ == "__main__":
    check_explicit(pathlib.Path(__file__).parent.parent / "reference")
    for seed, (name, (changes, velocity, spin, note)) in enumerate(CASES.items()):
        if name not in (sys.argv[1:] or CASES):
            continue
        write(name, changes, velocity, spin, note, seed)
