"""Alteration of a member: factors of its mass, stiffness and damping, shear, and joints at its ends."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.structure_settings import ELEMENT

ROTATION_ROWS = (2, 5)  # theta of each end among (u, v, theta) of both


@dataclass(frozen=True)
class Alteration:
    """Factors of a member's matrices, added shear flexibility and rotary inertia, and end joints."""

    mass: float = 1.0
    axial: float = 1.0
    bending: float = 1.0
    loss: float = 1.0  # factor of the damping in proportion to stiffness
    shear: float = 0.0  # added fraction of shear flexibility and rotary inertia
    joints: tuple[float, float] = (0.0, 0.0)  # rad/(N m), of a rotational spring at each end; 0 is rigid
    consistent_mass: float = 1.0  # share of the joints' kinks and of the shear that the mass matrix has

    def combined_with(self, alteration: "Alteration") -> "Alteration":
        """Return both alterations combined: factors multiply, flexibilities of springs in series add.

        Of two shares of the mass matrix the smaller one holds.
        """
        return Alteration(
            self.mass * alteration.mass,
            self.axial * alteration.axial,
            self.bending * alteration.bending,
            self.loss * alteration.loss,
            self.shear + alteration.shear,
            (self.joints[0] + alteration.joints[0], self.joints[1] + alteration.joints[1]),
            min(self.consistent_mass, alteration.consistent_mass),
        )


@dataclass(frozen=True, eq=False)
class JointedMember:
    """Matrices of a member joined to its nodes by rotational springs: (w + k, w + k), k joint rotations last.

    Joint rotations are scaled by the square root of their flexibility: a rigid joint is a regular limit.
    """

    mass: FloatArray
    stiffness: FloatArray
    inner: int  # k, joint rotations that are coordinates of their own


def with_joints(
    mass: FloatArray, stiffness: FloatArray, joints: tuple[float, float], consistent_mass: float = 1.0
) -> JointedMember:
    """Return a member, (w, w) each, with rotational springs between its ends and its nodes.

    With delta the joint rotation and g its unit vector among the member's coordinates u, the strain energy
    is (u + g delta)^T K (u + g delta) / 2 + delta^2 / (2 flexibility); kinetic energy likewise.

    Parameters
    ----------
    consistent_mass
        Share of delta in the kinetic energy; below 1 the joint rotation is condensed statically.
    """
    inner, width = [], len(mass)
    for row, flexibility in zip(ROTATION_ROWS, joints, strict=True):
        stiffness_ratio = flexibility * stiffness[row, row]
        if stiffness_ratio == 0:
            continue
        if stiffness_ratio > ELEMENT.rigid_joint_flexibility and consistent_mass == 1:
            inner.append((row, flexibility))
            continue
        # Static condensation: a coordinate of its own would only add a mode at a very high frequency.
        static_motion = np.eye(width)
        static_motion[row] -= consistent_mass * flexibility * stiffness[row] / (1 + stiffness_ratio)
        mass = static_motion.T @ mass @ static_motion
        stiffness = stiffness - flexibility * np.outer(stiffness[row], stiffness[row]) / (1 + stiffness_ratio)
    expansion = np.eye(width, width + len(inner))
    springs = np.zeros(width + len(inner))
    for k, (row, flexibility) in enumerate(inner, start=width):
        expansion[row, k] = np.sqrt(flexibility)
        springs[k] = 1.0
    projection = expansion.T
    return JointedMember(
        projection @ mass @ expansion, projection @ stiffness @ expansion + np.diag(springs), len(inner)
    )


def orthonormal_span(blocks: list[FloatArray]) -> FloatArray:
    """Return an orthonormal basis (n, r) of the joint column space of matrices (n, .)."""
    normalised = [block / size for block in blocks if (size := np.abs(block).max(initial=0.0)) > 0]
    if not normalised:
        return np.zeros((len(blocks[0]), 0))
    u, s, _ = np.linalg.svd(np.hstack(normalised), full_matrices=False)
    return np.asarray(u[:, s > PRODUCT_ROUNDING * s[0]])
