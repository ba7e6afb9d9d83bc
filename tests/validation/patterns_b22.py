"""B2 of many patterns of charges on one protein, from poses that all of them share (used by residual_b22.py).

The surface is the same for all patterns, so contact distances and distances of charges are computed once. With the signs s of the sites,
and one for the charges that do not change, the energy of two copies is U = s M s for every pattern, with one matrix M for each pose.
Rays are drawn as in `pair`: a direction and a rotation, first uniform ones, then near those that decide B2 of any pattern.
"""

import numpy as np
from scipy.spatial import cKDTree

BJERRUM_ANGSTROM, DEBYE_ANGSTROM = 7.157540086118503, 9.607772798732082
"""Water at 298.15 K with 100 mM salt, as `pair` prints them."""
CELL_ANGSTROM, MARGIN_ANGSTROM, NEAR_ANGSTROM = 0.5, 6.0, 3.0
"""Grid of distances; below the last they are interpolated."""
KNOTS_ANGSTROM = np.array([0, 0.15, 0.35, 0.6, 0.9, 1.3, 1.8, 2.4, 3.1, 4, 5, 6.5, 8.5, 11, 14, 18, 23, 29, 37, 47, 60.0])
"""Ends of the intervals beyond contact; one random point stands for each."""
CONTACT_ANGSTROM = 0.02
WIDTHS_RAD = (0.4, 0.2)
CENTRES = 2048


class Surface:
    """Distances to a surface, by interpolation, and the atoms that can touch another body."""

    def __init__(self, vertices, triangles, atoms, radii):
        corners = vertices[triangles]
        points = np.vstack([vertices, corners.mean(axis=1), (corners[:, 0] + corners[:, 1]) / 2])
        tree = cKDTree(points)
        # The origin is between the extremes of the surface.
        self.low = (vertices.min(axis=0) - MARGIN_ANGSTROM).astype(np.float32)
        self.counts = np.ceil((vertices.max(axis=0) + MARGIN_ANGSTROM - self.low) / CELL_ANGSTROM).astype(np.int32) + 1
        self.high = (self.low + CELL_ANGSTROM * (self.counts - 1)).astype(np.float32)
        grid = np.indices(self.counts).reshape(3, -1).T * CELL_ANGSTROM + self.low
        self.distances = tree.query(grid, distance_upper_bound=40.0)[0].astype(np.float32)
        near = tree.query(atoms)[0] < radii + 0.3
        self.atoms, self.radii = atoms[near].astype(np.float32), radii[near].astype(np.float32)

    def distance(self, points):
        """Distances of points to the surface, Å, to a few hundredths near it; elsewhere lower bounds."""
        inside = np.clip(points, self.low, self.high - 1e-3)
        scaled = (inside - self.low) / np.float32(CELL_ANGSTROM)
        cell = np.minimum(scaled.astype(np.int32), self.counts - 2)
        strides = np.array([self.counts[1] * self.counts[2], self.counts[2], 1], np.int32)
        first = cell @ strides
        # A corner of the cell is nearer than its diagonal.
        value = self.distances[first] - np.float32(CELL_ANGSTROM * 3**0.5)
        near = np.flatnonzero(value < NEAR_ANGSTROM)
        x, y, z = (scaled[near] - cell[near]).T
        first, fine = first[near], np.zeros(len(near), np.float32)
        for corner in range(8):
            i, j, k = corner >> 2 & 1, corner >> 1 & 1, corner & 1
            weight = (x if i else 1 - x) * (y if j else 1 - y) * (z if k else 1 - z)
            fine += weight * self.distances[first + int(strides @ (i, j, k))]
        value[near] = fine
        # Beyond the grid the surface is at least the margin farther away.
        beyond = np.abs(points - inside).max(axis=1)
        return np.where(beyond > 0.01, np.maximum(beyond + MARGIN_ANGSTROM, value - 2 * beyond), value)


def contact_distances(surface, directions, rotations):
    """Distances of the origins at first contact from outside, Å: body 2 is at r d, turned by R.

    The atoms of one body approach the surface of the other. Each step is the smallest gap, so nothing is passed over.
    """
    count = len(directions)
    directions = directions.astype(np.float32)
    r = np.full(count, 2 * np.linalg.norm(surface.atoms, axis=1).max() + 2 * surface.radii.max(), np.float32)
    turned = np.einsum("nij,aj->nai", rotations.astype(np.float32), surface.atoms)
    moving = np.arange(count)
    for _ in range(80):
        if not len(moving):
            break
        second = turned[moving] + (r[moving, None] * directions[moving])[:, None]
        distances = surface.distance(second.reshape(-1, 3)).reshape(second.shape[:2])
        gap = (distances - surface.radii).min(axis=1)
        r[moving] = np.maximum(r[moving] - np.maximum(gap, 0), 0)
        moving = moving[(gap > CONTACT_ANGSTROM) & (r[moving] > 0)]
    return r.astype(float)


def matrices_of(quaternions):
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def unit(random, count, dimension):
    drawn = random.normal(size=(count, dimension))
    return drawn / np.linalg.norm(drawn, axis=1)[:, None]


def product(a, b):
    """Products of quaternions."""
    w, v = a[:, 0] * b[:, 0] - (a[:, 1:] * b[:, 1:]).sum(axis=1), np.cross(a[:, 1:], b[:, 1:])
    return np.column_stack([w, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + v])


class Caps:
    """A density of orientations relative to the uniform one: caps of one width about centres."""

    def __init__(self, directions, quaternions, width_rad):
        self.directions, self.quaternions, self.width = directions, quaternions, width_rad
        # Shares of all directions and of all rotations.
        self.share = (1 - np.cos(width_rad)) / 2 * (width_rad - np.sin(width_rad)) / np.pi

    def draw(self, random, count):
        chosen = random.integers(0, len(self.directions), count)
        d = self.directions[chosen]
        cosine = 1 - random.random(count) * (1 - np.cos(self.width))
        across = np.cross(d, unit(random, count, 3))
        across /= np.linalg.norm(across, axis=1)[:, None]
        directions = cosine[:, None] * d + np.sqrt(1 - cosine**2)[:, None] * across
        # The angle of a uniform rotation has the density 1 - cos.
        grid = np.linspace(0, self.width, 1000)
        angles = np.interp(random.random(count) * (grid - np.sin(grid))[-1], grid - np.sin(grid), grid)
        turns = np.column_stack([np.cos(angles / 2), np.sin(angles / 2)[:, None] * unit(random, count, 3)])
        return directions, product(turns, self.quaternions[chosen])

    def density(self, directions, quaternions):
        inside = np.zeros(len(directions))
        for begin in range(0, len(directions), 1024):
            part = slice(begin, begin + 1024)
            near = directions[part] @ self.directions.T > np.cos(self.width)
            near &= np.abs(quaternions[part] @ self.quaternions.T) > np.cos(self.width / 2)
            inside[part] = near.mean(axis=1)
        return inside / self.share


def soft_parts(contacts, directions, rotations, groups, signs, random):
    """The integral of (exp(-U) - 1) r² over r beyond contact for each ray and pattern, Å³.

    `groups` has positions and weights of the charges and the site of each; site 0 keeps its sign.
    """
    positions, weights, sites = groups
    positions, rotations = positions.astype(np.float32), rotations.astype(np.float32)
    count, patterns = signs.shape[1], len(signs)
    upper = np.triu_indices(count)
    products = (signs[:, :, None] * signs[:, None])[:, upper[0], upper[1]]
    products = products.T.astype(np.float32)
    one_hot = (sites[:, None] == np.arange(count)).astype(np.float32) * weights[:, None].astype(np.float32)
    soft = np.zeros((len(contacts), patterns))
    for begin in range(0, len(contacts), 128):
        part = slice(begin, begin + 128)
        turned = np.einsum("nij,aj->nai", rotations[part], positions)
        rays = len(turned)
        for low, high in zip(KNOTS_ANGSTROM[:-1], KNOTS_ANGSTROM[1:]):
            r = contacts[part] + low + (high - low) * random.random(rays)
            second = turned + (r[:, None] * directions[part]).astype(np.float32)[:, None]
            square = (positions**2).sum(axis=1)[None, :, None] + (second**2).sum(axis=2)[:, None] - 2 * np.einsum("ak,nbk->nab", positions, second)
            distance = np.sqrt(np.maximum(square, 0.01))
            v = np.exp(-distance / np.float32(DEBYE_ANGSTROM)) / distance
            m = np.float32(BJERRUM_ANGSTROM) * np.einsum("ac,nab,bd->ncd", one_hot, v, one_hot, optimize=True)
            m = m + np.swapaxes(m, 1, 2)
            m[:, np.arange(count), np.arange(count)] /= 2
            energy = m[:, upper[0], upper[1]].astype(np.float32) @ products
            soft[part] += np.expm1(-energy) * (r**2 * (high - low))[:, None]
    return soft


def second_virials(surface, groups, signs, seed, rays, progress=lambda text: print(text, flush=True)):
    """Of each pattern: the part of B2 that is due to the charges, Å³, and its standard error; and the hard part of B2, Å³.

    A pilot of two steps finds what decides B2. Fresh rays from uniform ones and caps of two widths about that give the answer: no ray is
    judged by a density that was made from it.
    """
    random = np.random.default_rng(seed)

    def drawn(proposals, sizes):
        parts = [
            (unit(random, size, 3), unit(random, size, 4)) if proposal is None else proposal.draw(random, size)
            for proposal, size in zip(proposals, sizes)
        ]
        directions, quaternions = (np.vstack(part) for part in zip(*parts))
        contacts = contact_distances_in_parts(surface, directions, quaternions)
        soft = soft_parts(contacts, directions, matrices_of(quaternions), groups, signs, random)
        progress(f"  {len(soft)} rays")
        return directions, quaternions, contacts, soft, mixture(proposals, sizes, directions, quaternions)

    def centres(directions, quaternions, soft, density):
        """Orientations in proportion to what they contribute to B2 of any pattern, by systematic resampling."""
        share = np.abs(soft) / density[:, None]
        weight = (share / share.sum(axis=0)).sum(axis=1)
        steps = (np.arange(CENTRES) + random.random()) / CENTRES
        chosen = np.searchsorted(np.cumsum(weight) / weight.sum(), steps).clip(max=len(weight) - 1)
        return directions[chosen], quaternions[chosen]

    directions, quaternions, contacts, soft, density = drawn([None], [rays // 2])
    hard = [contacts**3]
    wide = Caps(*centres(directions, quaternions, soft, density), WIDTHS_RAD[0])
    directions, quaternions, _, soft, density = drawn([None, wide], [rays // 8, rays // 2])
    best = centres(directions, quaternions, soft, density)
    proposals, sizes = [None, *(Caps(*best, width) for width in WIDTHS_RAD)], [rays // 2, rays // 4, rays // 4]
    _, _, contacts, soft, density = drawn(proposals, sizes)
    hard.append(contacts[: sizes[0]] ** 3)
    terms = -2 * np.pi * soft / density[:, None]
    # Each proposal has a fixed number of rays, so errors are those within proposals.
    variance, begin = 0.0, 0
    for size in sizes:
        variance, begin = variance + size * terms[begin : begin + size].var(axis=0), begin + size
    return terms.mean(axis=0), np.sqrt(variance) / sum(sizes), 2 * np.pi / 3 * np.concatenate(hard).mean()


def contact_distances_in_parts(surface, directions, quaternions, part=256):
    rotations = matrices_of(quaternions)
    found = [contact_distances(surface, directions[at : at + part], rotations[at : at + part]) for at in range(0, len(directions), part)]
    return np.concatenate(found)


def mixture(proposals, sizes, directions, quaternions):
    """The density of the draws so far relative to the uniform one, for each orientation."""
    total = np.zeros(len(directions))
    for proposal, size in zip(proposals, sizes):
        total += size * (1.0 if proposal is None else proposal.density(directions, quaternions))
    return total / sum(sizes)
