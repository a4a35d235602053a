"""Skinning on the CPU: linear blending and dual quaternions, on whole vertex arrays. Pure functions, float64.

    world_from_joint, inverse_bind ─ joint_matrices ─> M f8[j,4,4] (world from mesh, per joint)
    linear            v' = (sum w M) v
    dual quaternions  v' = (rigid part blended as dual quaternions, scale blended apart) v

The truth that the GPU's skinning is tested against.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math import quat
from engine.math.transform import compose, decompose

F8 = NDArray[np.float64]


def joint_matrices(world_from_joint: ArrayLike, inverse_bind: ArrayLike) -> F8:
    """world_from_joint @ inverse_bind, f8[j,4,4]: where each joint takes a point of the bound mesh."""
    result: F8 = np.asarray(world_from_joint, np.float64) @ np.asarray(inverse_bind, np.float64)
    return result


def influences(streams: dict[str, NDArray[np.generic]]) -> tuple[NDArray[np.int64], F8]:
    """Joints i8[n,4|8] and weights f8[n,4|8], summing to 1, of a mesh's streams."""
    names = [""] + (["1"] if "joints1" in streams else [])
    joints = np.concatenate([streams[f"joints{k}"].astype(np.int64) for k in names], axis=1)
    weights = np.concatenate([streams[f"weights{k}"].astype(np.float64) for k in names], axis=1) / 65535.0
    return joints, weights


def vertex_matrices(joints: ArrayLike, weights: ArrayLike, matrices: F8) -> F8:
    """The weighted sum of joint matrices, f8[n,4,4], for joints [n,k] and weights [n,k]."""
    joints, weights = np.asarray(joints), np.asarray(weights, np.float64)
    result = np.zeros((len(joints), 4, 4))
    for column in range(joints.shape[1]):
        result += weights[:, column, None, None] * matrices[joints[:, column]]
    return result


def vertex_matrices_dual_quaternion(joints: ArrayLike, weights: ArrayLike, matrices: F8) -> F8:
    """As `vertex_matrices`, with rotations and translations blended as dual quaternions, f8[n,4,4].

    Kavan, Collins, Zara, O'Sullivan, "Geometric Skinning with Approximate Dual Quaternion Blending" (2008), eq. 15 and
    section 4.2: scales are blended linearly and applied first. Antipodal quaternions are turned to the side of each
    vertex's first influence. Shear is lost.
    """
    joints, weights = np.asarray(joints), np.asarray(weights, np.float64)
    translation, rotation, scale = decompose(matrices)
    # the dual part of a rigid motion: (t, 0) q / 2
    pure = np.concatenate([translation, np.zeros((len(translation), 1))], axis=1)
    dual = 0.5 * quat.multiply(pure, rotation)
    count = len(joints)
    real, imaginary, size = np.zeros((count, 4)), np.zeros((count, 4)), np.zeros((count, 3))
    pivot = rotation[joints[:, 0]]
    for column in range(joints.shape[1]):
        joint, weight = joints[:, column], weights[:, column, None]
        q = rotation[joint]
        side = np.where(np.sum(q * pivot, axis=1, keepdims=True) < 0.0, -1.0, 1.0) * weight
        real += side * q
        imaginary += side * dual[joint]
        size += weight * scale[joint]
    length = np.linalg.norm(real, axis=1, keepdims=True)
    safe = np.where(length > 0.0, length, 1.0)
    real, imaginary = real / safe, imaginary / safe
    moved = 2.0 * quat.multiply(imaginary, quat.conjugate(real))
    return compose(moved[:, :3], quat.normalize(real), size)


def transform_points(matrices: ArrayLike, points: ArrayLike) -> F8:
    """M p for matrices [n,4,4] or [4,4] and points [n,3], f8[n,3]."""
    m, p = np.asarray(matrices, np.float64), np.asarray(points, np.float64)
    result: F8 = (m[..., :3, :3] @ p[..., None])[..., 0] + m[..., :3, 3]
    return result


def transform_normals(matrices: ArrayLike, normals: ArrayLike) -> F8:
    """Unit normals f8[n,3] of a surface moved by matrices [n,4,4] or [4,4]: by the cofactors, outward under mirrors."""
    from engine.math.transform import cofactor

    m = np.asarray(matrices, np.float64)[..., :3, :3]
    sign = np.where(np.linalg.det(m) < 0.0, -1.0, 1.0)[..., None]
    moved = sign * (cofactor(m) @ np.asarray(normals, np.float64)[..., None])[..., 0]
    length = np.linalg.norm(moved, axis=-1, keepdims=True)
    result: F8 = moved / np.where(length > 0.0, length, 1.0)
    return result
