"""Matrices of Laplacians on jittered clouds, as the solvers meet them; made without the library.

cloud_matrix(cells, dim, jitter, radius) -> scipy.sparse.csr_matrix of -lap by weighted least squares
of degree 2 on the unit cube, Dirichlet points (the boundary) eliminated, points in lattice order.
write(path, matrix) -> the file that bench_solve reads.
"""
import itertools

import numpy as np
import scipy.sparse
from scipy.spatial import cKDTree


def cloud(cells, dim, jitter, seed=7):
    """Points [n][dim], x fastest, and which are inside; boundary points are not jittered."""
    axis = np.arange(cells + 1) / cells
    grid = np.meshgrid(*[axis] * dim, indexing="ij")
    points = np.stack([g.ravel() for g in reversed(grid)], axis=1)
    inside = np.all((points > 0) & (points < 1), axis=1)
    random = np.random.default_rng(seed)
    shift = random.uniform(-jitter, jitter, points.shape) / cells
    points[inside] += shift[inside]
    return points, inside


def stencils(points, centres, radius):
    """Weights [m][k] of lap at `centres` over neighbours [m][k] (padded with weight 0)."""
    dim = points.shape[1]
    count = {1: 8, 2: 28, 3: 80}[dim]
    distance, neighbour = cKDTree(points).query(points[centres], k=count + 1)
    distance, neighbour = distance[:, 1:], neighbour[:, 1:]
    weight = np.where(distance < radius, (1 - np.minimum(distance / radius, 1)) ** 2, 0)
    neighbour = np.where(distance < radius, neighbour, centres[:, None])
    r = (points[neighbour] - points[centres][:, None, :]) / radius
    pairs = list(itertools.combinations_with_replacement(range(dim), 2))
    basis = np.concatenate([r, np.stack([r[..., a] * r[..., b] for a, b in pairs], axis=-1)], axis=2)
    weighted = basis * weight[..., None]
    wanted = np.array([0.0] * dim + [2.0 if a == b else 0.0 for a, b in pairs]) / radius**2
    rows = np.linalg.solve(np.einsum("mki,mkj->mij", weighted, basis), wanted[None, :, None])
    return neighbour, np.einsum("mki,mi->mk", weighted, rows[..., 0])


def cloud_matrix(cells, dim, jitter=0.3, radius=2.1):
    points, inside = cloud(cells, dim, jitter)
    centres = np.flatnonzero(inside)
    neighbour, weight = stencils(points, centres, radius / cells)
    unknown = np.full(len(points), -1)
    unknown[centres] = np.arange(len(centres))
    i = np.repeat(np.arange(len(centres)), neighbour.shape[1])
    j, v = unknown[neighbour.ravel()], weight.ravel()
    keep = (j >= 0) & (v != 0)
    n = len(centres)
    a = scipy.sparse.coo_matrix((-v[keep], (i[keep], j[keep])), shape=(n, n))
    a = (a + scipy.sparse.diags(weight.sum(axis=1))).tocsr()
    a.sort_indices()
    return a


def write(path, a, b):
    with open(path, "wb") as f:
        np.array([a.shape[0], a.nnz], dtype=np.int64).tofile(f)
        a.indptr.astype(np.int64).tofile(f)
        a.indices.astype(np.int32).tofile(f)
        a.data.astype(np.float64).tofile(f)
        np.asarray(b, dtype=np.float64).tofile(f)
