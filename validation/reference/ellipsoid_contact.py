# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact of two ellipsoids in high precision: penetration, curvature, Hertz force, torques, conservative law.

Nothing here follows the formulation of the library.  The penetration is found from the surface points and their Lagrange
multipliers (a 9 x 9 Karush-Kuhn-Tucker system), the curvatures from the Gaussian and mean curvature of the implicit surface,
the relative curvature from the four principal radii and the angle between the principal planes, the Hertz factors from
Legendre's complete elliptic integrals, and the conservative force and torques by differencing the stored energy with the
whole solution in the loop.
"""

import mpmath
import numpy as np
from mpmath import mp, mpf

DIGITS = 60  # working precision; results are good to DIGITS/2 or better, see README.md

# --------------------------------------------------------------------------------------------------------------------
# small linear algebra on lists


def dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def norm(u):
    return mpmath.sqrt(dot(u, u))


def matvec(m, v):
    return [dot(row, v) for row in m]


def matmul(m, n):
    return [[sum(m[r][k] * n[k][c] for k in range(3)) for c in range(3)] for r in range(3)]


def transpose(m):
    return [[m[c][r] for c in range(3)] for r in range(3)]


def solve(matrix, right):
    """Gaussian elimination with row scaling and partial pivoting."""
    count = len(right)
    rows = [list(matrix[r]) + [right[r]] for r in range(count)]
    scales = [max(abs(x) for x in row[:count]) for row in rows]
    for c in range(count):
        pivot = max(range(c, count), key=lambda r: abs(rows[r][c]) / scales[r])
        rows[c], rows[pivot] = rows[pivot], rows[c]
        scales[c], scales[pivot] = scales[pivot], scales[c]
        inverse = 1 / rows[c][c]
        for r in range(c + 1, count):
            factor = rows[r][c] * inverse
            if factor:
                row, top = rows[r], rows[c]
                for k in range(c + 1, count + 1):
                    row[k] -= factor * top[k]
    answer = [mpf(0)] * count
    for r in reversed(range(count)):
        answer[r] = (rows[r][count] - sum(rows[r][k] * answer[k] for k in range(r + 1, count))) / rows[r][r]
    return answer


# --------------------------------------------------------------------------------------------------------------------
# bodies


def rotation_from_quaternion(q):
    """Body to world, (w, x, y, z); exact for a quaternion of any length."""
    w, x, y, z = q
    s = 2 / (w * w + x * x + y * y + z * z)
    return [
        [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
    ]


def rotation_about(axis, angle):
    """Rotation by `angle` about the world axis number `axis`."""
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    m = [[mpf(int(r == k)) for k in range(3)] for r in range(3)]
    j, k = (axis + 1) % 3, (axis + 2) % 3
    m[j][j], m[j][k], m[k][j], m[k][k] = c, -s, s, c
    return m


class Body:
    """Centre, rotation (body to world), semi-axes; and the matrix Q of the implicit surface (p-x)^T Q (p-x) = 1."""

    def __init__(self, position, rotation, semi_axes):
        self.position = position
        self.rotation = rotation
        self.semi_axes = semi_axes
        weights = [1 / (a * a) for a in semi_axes]
        self.q = [
            [sum(rotation[r][k] * weights[k] * rotation[c][k] for k in range(3)) for c in range(3)] for r in range(3)
        ]

    @staticmethod
    def from_doubles(position, quaternion, semi_axes):
        """The doubles are taken as exact; the quaternion is normalised exactly."""
        return Body(
            [mpf(float(x)) for x in position],
            rotation_from_quaternion([mpf(float(x)) for x in quaternion]),
            [mpf(float(x)) for x in semi_axes],
        )

    def moved(self, axis, distance):
        position = list(self.position)
        position[axis] += distance
        return Body(position, self.rotation, self.semi_axes)

    def rotated(self, axis, angle):
        return Body(self.position, matmul(rotation_about(axis, angle), self.rotation), self.semi_axes)


# --------------------------------------------------------------------------------------------------------------------
# penetration: floating-point global search, then the KKT system in high precision


def _support_shapes(bodies):
    shapes = []
    for body in bodies:
        r = np.array([[float(x) for x in row] for row in body.rotation])
        shapes.append(r * np.array([float(a) for a in body.semi_axes]))  # R diag(a)
    return shapes


def search_normals(i, j, count=6000, keep=60, seed=1):
    """Local minima over unit normals of h_i + h_j - n.d in double precision, best first: [(value, normal)].

    Brute force: thousands of starts, spread over the sphere and crowded towards the flat sides of the bodies, the best of
    which descend by Newton steps with the absolute values of the Hessian's eigenvalues and step halving."""
    ti, tj = _support_shapes((i, j))
    d = np.array([float(b - a) for a, b in zip(i.position, j.position)])
    generator = np.random.default_rng(seed)
    u = generator.normal(size=(count, 3))
    third = count // 3
    for t, part in ((ti, slice(third, 2 * third)), (tj, slice(2 * third, count))):
        r = t / np.linalg.norm(t, axis=0)
        u[part] = (u[part] / np.linalg.norm(t, axis=0) ** generator.uniform(0.5, 2.5, size=(u[part].shape[0], 1))) @ r.T
    n = u / np.linalg.norm(u, axis=1)[:, None]

    def value(n):
        return np.linalg.norm(n @ ti, axis=1) + np.linalg.norm(n @ tj, axis=1) - n @ d

    f = value(n)
    order = np.argsort(f)
    chosen = np.concatenate([order[: keep // 2], order[keep // 2 :: max(1, (count - keep // 2) // (keep // 2))]])
    n, f = n[chosen], f[chosen]
    for _ in range(60):
        gradient, hessian = -np.broadcast_to(d, n.shape).copy(), np.zeros((len(n), 3, 3))
        for t in (ti, tj):
            z = n @ t
            h = np.linalg.norm(z, axis=1)
            s = (z / h[:, None]) @ t.T
            gradient += s
            hessian += (t @ t.T)[None] / h[:, None, None] - s[:, :, None] * s[:, None, :] / h[:, None, None]
        helper = np.eye(3)[np.argmin(np.abs(n), axis=1)]
        t1 = np.cross(n, helper)
        t1 /= np.linalg.norm(t1, axis=1)[:, None]
        t2 = np.cross(n, t1)
        basis = np.stack([t1, t2], axis=2)
        g = np.einsum("nik,ni->nk", basis, gradient)
        hess = np.einsum("nik,nij,njl->nkl", basis, hessian, basis) - f[:, None, None] * np.eye(2)
        values, vectors = np.linalg.eigh(hess)
        values = np.maximum(np.abs(values), 1e-13 * np.abs(values).max(axis=1)[:, None])
        y = -np.einsum("nkl,nl,nml,nm->nk", vectors, 1 / values, vectors, g)
        length = np.linalg.norm(y, axis=1)
        y *= np.minimum(1, 0.5 / np.maximum(length, 1e-300))[:, None]
        step = np.einsum("nik,nk->ni", basis, y)
        scale = np.ones(len(n))
        best_n, best_f = n.copy(), f.copy()
        open_ = np.ones(len(n), bool)
        for _ in range(30):
            trial = n + scale[:, None] * step
            trial /= np.linalg.norm(trial, axis=1)[:, None]
            ft = value(trial)
            good = open_ & (ft <= f + 1e-16 * np.abs(d).max())
            best_n[good], best_f[good] = trial[good], ft[good]
            open_ &= ~good
            if not open_.any():
                break
            scale[open_] *= 0.5
        n, f = best_n, best_f
        if length.max() < 1e-13:
            break
    answer = []
    for k in np.argsort(f):
        if not any(np.linalg.norm(n[k] - other) < 1e-5 for _, other in answer):
            answer.append((float(f[k]), n[k]))
    return answer


def witness_start(i, j, normal):
    """Start of the KKT iteration from a unit normal in doubles: (p_i, p_j, mu_i, mu_j, delta)."""
    unknowns, multipliers = [], []
    for body, sign in ((i, 1), (j, -1)):
        t = _support_shapes((body,))[0]
        z = sign * normal @ t
        h = np.linalg.norm(z)
        point = t @ z / h
        unknowns += [mpf(float(x)) + c for x, c in zip(point, body.position)]
        multipliers.append(mpf(float(h)))  # |Q (p-x)| = 1/h
    delta = dot([a - b for a, b in zip(unknowns[:3], unknowns[3:])], [mpf(float(x)) for x in normal])
    return unknowns + multipliers + [delta]


def solve_kkt(i, j, start, max_steps=60):
    """Newton on

        p_i - p_j = delta n,   n = mu_i Q_i (p_i - x_i) = -mu_j Q_j (p_j - x_j),   |n| = 1,   both points on their surfaces.

    Nine unknowns p_i, p_j, mu_i, mu_j, delta; regular at first touch, where the two points meet."""
    x = list(start)
    size = max(max(i.semi_axes), max(j.semi_axes))
    target = mpf(10) ** (-(mp.dps - 12))
    previous = None
    for _ in range(max_steps):
        ri = [x[k] - i.position[k] for k in range(3)]
        rj = [x[3 + k] - j.position[k] for k in range(3)]
        gi, gj = matvec(i.q, ri), matvec(j.q, rj)
        mu_i, mu_j, delta = x[6], x[7], x[8]
        right, matrix = [], []
        for k in range(3):
            right.append(x[k] - x[3 + k] - delta * mu_i * gi[k])
            row = [-delta * mu_i * i.q[k][c] for c in range(3)] + [mpf(0)] * 3 + [-delta * gi[k], mpf(0), -mu_i * gi[k]]
            row[k] += 1
            row[3 + k] -= 1
            matrix.append(row)
        for k in range(3):
            right.append(mu_i * gi[k] + mu_j * gj[k])
            matrix.append([mu_i * q for q in i.q[k]] + [mu_j * q for q in j.q[k]] + [gi[k], gj[k], mpf(0)])
        right.append((dot(ri, gi) - 1) / 2)
        matrix.append(gi + [mpf(0)] * 6)
        right.append((dot(rj, gj) - 1) / 2)
        matrix.append([mpf(0)] * 3 + gj + [mpf(0)] * 3)
        qg = matvec(i.q, gi)
        right.append((mu_i * mu_i * dot(gi, gi) - 1) / 2)
        matrix.append([mu_i * mu_i * c for c in qg] + [mpf(0)] * 3 + [mu_i * dot(gi, gi), mpf(0), mpf(0)])
        step = solve(matrix, right)
        x = [a - b for a, b in zip(x, step)]
        change = max(abs(s) for s in step[:6] + step[8:]) / size
        # the last step of a quadratic iteration: what is left is its square
        if change < target or (previous is not None and change < mpf(10) ** (-mp.dps // 2 - 6) and previous < mpf("1e-9")):
            return x
        previous = change
    raise ArithmeticError("KKT iteration did not converge, last change %s" % mpmath.nstr(change, 5))


class Contact:
    """Geometry of the contact: delta, unit normal from i to j, witness points, principal curvatures, A <= B."""

    def __init__(self, i, j, unknowns):
        self.unknowns = unknowns
        self.witness_i, self.witness_j = unknowns[:3], unknowns[3:6]
        self.delta = unknowns[8]
        self.normal = [unknowns[6] * g for g in matvec(i.q, [a - b for a, b in zip(self.witness_i, i.position)])]
        self.curvatures_i, self.direction_i = principal_curvatures(i, self.witness_i)
        self.curvatures_j, self.direction_j = principal_curvatures(j, self.witness_j)
        # Euler: from the four principal curvatures and the angle between the principal planes
        sum_ = (sum(self.curvatures_i) + sum(self.curvatures_j)) / 2
        di = self.curvatures_i[0] - self.curvatures_i[1]
        dj = self.curvatures_j[0] - self.curvatures_j[1]
        cosine = dot(self.direction_i, self.direction_j)
        cos2 = 2 * cosine * cosine - 1
        difference = mpmath.sqrt(abs(di * di + dj * dj + 2 * di * dj * cos2)) / 2
        self.b = (sum_ + difference) / 2
        self.a = (sum_ - difference) / 2


def principal_curvatures(body, point):
    """(kappa_1 >= kappa_2), and the world direction of kappa_1, from the Gaussian and mean curvature at a surface point."""
    r = [p - c for p, c in zip(point, body.position)]
    local = matvec(transpose(body.rotation), r)
    a2 = [a * a for a in body.semi_axes]
    s = sum(x * x / (a * a) for x, a in zip(local, a2))
    product = a2[0] * a2[1] * a2[2]
    gauss = 1 / (product * s * s)
    mean = (sum(a2) - dot(local, local)) / (2 * product * s * mpmath.sqrt(s))
    root = mpmath.sqrt(max(mean * mean - gauss, mpf(0)))
    kappa = (mean + root, mean - root)
    # direction: the tangent vector t with II(t, t) = kappa_1, by the angle in a tangent frame
    gradient = [x / a for x, a in zip(local, a2)]
    length = mpmath.sqrt(s)
    n = [g / length for g in gradient]
    axis = min(range(3), key=lambda k: abs(n[k]))
    helper = [mpf(int(k == axis)) for k in range(3)]
    t1 = cross(n, helper)
    t1 = [x / norm(t1) for x in t1]
    t2 = cross(n, t1)

    def second(u, v):
        return sum(x * y / a for x, y, a in zip(u, v, a2)) / length

    angle = mpmath.atan2(2 * second(t1, t2), second(t1, t1) - second(t2, t2)) / 2
    c, s_ = mpmath.cos(angle), mpmath.sin(angle)
    direction = matvec(body.rotation, [c * x + s_ * y for x, y in zip(t1, t2)])
    return kappa, direction


# --------------------------------------------------------------------------------------------------------------------
# Hertz


class HertzFactors:
    """Hertz's elliptical contact at relative curvatures B/A = ratio >= 1: b/a, F1, F2, phi = F2^(-3/2), K, E, Bl/K."""

    def __init__(self, ratio, start=None):
        ratio = mpf(ratio)
        if ratio < 1:
            raise ValueError("ratio of relative curvatures below one")
        with mp.extradps(25):
            # near a circle the differences E/k^2 - K and K - E lose as many digits as 1 - k has zeros
            log_ratio = mpmath.log(ratio)
            if log_ratio < mpf("1e-10"):  # nearly circles, where the integrals cancel: F1, F2 are right to the fourth power of this
                self.axis_ratio = mpmath.exp(-2 * log_ratio / 3)
                m = -mpmath.expm1(-4 * log_ratio / 3)
                self.f1 = self.f2 = 1 - log_ratio**2 / 72
                self.k, self.e = mpmath.pi / 2 * (1 + m / 4), mpmath.pi / 2 * (1 - m / 4)
                self.beta_major = mpf(1) / 2 - m / 16
            else:
                log_k = self._solve(ratio, start)
                k = mpmath.exp(log_k)
                m = -mpmath.expm1(2 * log_k)
                big_k, big_e = mpmath.ellipk(m), mpmath.ellipe(m)
                p, q = big_e / k**2 - big_k, big_k - big_e
                self.axis_ratio = k
                self.f1 = (4 / (mpmath.pi * m) * k ** mpf("1.5") * mpmath.sqrt(p * q)) ** (mpf(1) / 3)
                self.f2 = 2 / mpmath.pi * mpmath.sqrt(k) * big_k / self.f1
                self.k, self.e = big_k, big_e
                self.beta_major = (big_e - k**2 * big_k) / (m * big_k)  # Bl = (E - k^2 K)/m
            self.phi = self.f2 ** mpf("-1.5")

    @staticmethod
    def _solve(ratio, start):
        def residual(log_k):
            k2 = mpmath.exp(2 * log_k)
            m = -mpmath.expm1(2 * log_k)
            big_k, big_e = mpmath.ellipk(m), mpmath.ellipe(m)
            return mpmath.log((big_e / k2 - big_k) / (big_k - big_e)) - mpmath.log(ratio)

        if start is None:
            # b/a lies between (A/B) and (A/B)^(1/2); halve in the logarithm until secant steps are safe
            low, high = -mpmath.log(ratio), -mpmath.log(ratio) / 2
            for _ in range(12):
                middle = (low + high) / 2
                low, high = (low, middle) if residual(middle) < 0 else (middle, high)
            start = low
        else:
            high = start * (1 + mpf("1e-12"))
        x0, x1 = start, high
        r0, r1 = residual(x0), residual(x1)
        for _ in range(60):
            if r1 == r0 or r1 == 0:
                return x1
            x2 = x1 - r1 * (x1 - x0) / (r1 - r0)
            x0, r0, x1, r1 = x1, r1, x2, residual(x2)
            if abs(x1 - x0) < abs(x1) * mpf(10) ** (-(mp.dps - 22)):
                return x1
        raise ArithmeticError("Hertz axis ratio did not converge at B/A = %s" % mpmath.nstr(ratio, 20))


def contact_modulus(material_i, material_j):
    (ei, ni), (ej, nj) = material_i, material_j
    return 1 / ((1 - ni * ni) / ei + (1 - nj * nj) / ej)


def hertz_force(contact, modulus, start=None):
    """(normal force, factors) of Eq. (1)."""
    factors = HertzFactors(max(contact.b / contact.a, mpf(1)), start)
    radius = 1 / (2 * mpmath.sqrt(contact.a * contact.b))
    return mpf(4) / 3 * modulus * mpmath.sqrt(radius) * contact.delta ** mpf("1.5") * factors.phi, factors


# --------------------------------------------------------------------------------------------------------------------
# the two laws


def find_contact(i, j, seed=1):
    """Deepest common normal; None when the two best minima are too close for double precision to tell them apart."""
    minima = search_normals(i, j, seed=seed)
    size = float(max(max(i.semi_axes), max(j.semi_axes)))
    if len(minima) > 1 and minima[1][0] - minima[0][0] < 1e-9 * size:
        solved = [Contact(i, j, solve_kkt(i, j, witness_start(i, j, n))) for _, n in minima[:2]]
        apart = max(abs(a - b) for a, b in zip(solved[0].normal, solved[1].normal))
        if apart > mpf("1e-20"):
            return None
        return solved[0]
    return Contact(i, j, solve_kkt(i, j, witness_start(i, j, minima[0][1])))


def plain_force(i, j, contact, material_i, material_j):
    """Hertz force along the normal at the contact point: (contact point, force on j, torque on i, torque on j)."""
    force, _ = hertz_force(contact, contact_modulus(material_i, material_j))
    compliance = [(1 - nu * nu) / e for e, nu in (material_i, material_j)]
    share = compliance[0] / (compliance[0] + compliance[1])
    point = [p - share * contact.delta * n for p, n in zip(contact.witness_i, contact.normal)]
    vector = [force * n for n in contact.normal]
    torque_i = cross([p - x for p, x in zip(point, i.position)], [-f for f in vector])
    torque_j = cross([p - x for p, x in zip(point, j.position)], vector)
    return point, vector, torque_i, torque_j


def conservative_force(i, j, contact, material_i, material_j):
    """-dU/d(position, rotation) of U = (2/5) F_H delta by central differences: (force on i, on j, torque on i, on j)."""
    modulus = contact_modulus(material_i, material_j)
    _, factors = hertz_force(contact, modulus)
    log_k = mpmath.log(factors.axis_ratio) if factors.axis_ratio < 1 else None
    h = contact.delta * mpf(10) ** (-(mp.dps // 4))

    def energy(body_i, body_j):
        displaced = Contact(body_i, body_j, solve_kkt(body_i, body_j, contact.unknowns))
        return mpf(2) / 5 * hertz_force(displaced, modulus, log_k)[0] * displaced.delta

    def gradient(move):
        return [(energy(*move(k, -1)) - energy(*move(k, 1))) / (2 * h) for k in range(3)]

    angle = h / max(max(i.semi_axes), max(j.semi_axes))
    force_i = gradient(lambda k, s: (i.moved(k, s * h), j))
    force_j = gradient(lambda k, s: (i, j.moved(k, s * h)))
    torque_i = [t * (h / angle) for t in gradient(lambda k, s: (i.rotated(k, s * angle), j))]
    torque_j = [t * (h / angle) for t in gradient(lambda k, s: (i, j.rotated(k, s * angle)))]
    return force_i, force_j, torque_i, torque_j
