"""Matrices of a structure with small dynamic systems attached to it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Self

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.attachment import (
    Attachment,
    attached_stiffness,
    damper,
    oscillator,
    point_mass,
    spring,
    stacked_columns,
)
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.settings import CACHE
from modallab.fe.system_matrices import SystemMatrices

ATTACHMENTS: CacheSlot[Attachment] = CacheSlot("attachments", CACHE.attachments)


@dataclass(frozen=True, eq=False)
class AttachedSystem(SystemMatrices):
    """Matrices that never change, and the masses, springs, dampers and oscillators attached to them."""

    attachments: tuple[Attachment, ...] = ()

    def attach(self, attachment: Attachment) -> Self:
        """Return the system with one more attachment."""
        return replace(self, attachments=(*self.attachments, attachment))

    def add_mass(self, node: int, mass: float) -> Self:
        """Return the system with a mass, kg, that moves with every translation of a node."""
        return self.add_masses((node,), mass)

    def add_masses(self, nodes: Sequence[int], mass: float) -> Self:
        """Return the system with the same mass, kg, at each of some nodes."""
        masses = [
            self._cached_attachment((node, mass), partial(self._mass, node, mass), self.dof_cache)
            for node in nodes
        ]
        return replace(self, attachments=(*self.attachments, *masses))

    def _cached_attachment(
        self, key: tuple[object, ...], make: Callable[[], Attachment], cache: Cache | None = None
    ) -> Attachment:
        """Return the cached attachment of a key, or make it: every run of a test attaches the same ones.

        Parameters
        ----------
        cache
            `dof_cache` where the attachment depends on the DoFs alone; None: `cache`.
        """
        capacity = min(CACHE.attachments, 1 + CACHE.attachment_rows // len(self.dofs))
        cache = self.cache if cache is None else cache
        return cache.compute(ATTACHMENTS, key, make, capacity=capacity)

    def _mass(self, node: int, mass: float) -> Attachment:
        return point_mass(self.selection(self.translations(node)), mass)

    def add_spring(self, dof: Dof, stiffness: float) -> Self:
        """Return the system with a spring, N/m (N m for a rotation), from a DoF to the ground."""
        return self._attach_at(dof, spring, stiffness)

    def add_damper(self, dof: Dof, viscous: float) -> Self:
        """Return the system with a viscous damper, N s/m (N m s for a rotation), from a DoF to the ground."""
        return self._attach_at(dof, damper, viscous)

    def add_oscillator(
        self, dof: Dof, mass: float, frequency: float, loss_factor: float, damping_ratio: float = 0.0
    ) -> Self:
        """Return the system with a mass, kg, on a damped spring attached to a DoF.

        Parameters
        ----------
        frequency
            Hz, of the mass on its spring when the DoF is fixed.
        loss_factor
            Of the spring.
        damping_ratio
            Of a viscous damper beside the spring.
        """
        return self._attach_at(dof, oscillator, mass, frequency, loss_factor, damping_ratio)

    def _attach_at(self, dof: Dof, make: Callable[..., Attachment], *numbers: float) -> Self:
        """Return the system with an attachment at a DoF, made from the DoF's column and some numbers."""
        key = (make, dof, numbers)
        attachment = self._cached_attachment(
            key, lambda: make(self.selection((dof,)), *numbers), self.dof_cache
        )
        return self.attach(attachment)

    @property
    def stacked_columns(self) -> FloatArray:
        """(n, R): the columns of all attachments side by side."""
        return stacked_columns(len(self.dofs), self.attachments)

    def attached_stiffness(self, omega: FloatArray) -> ComplexArray:
        """Return the dynamic stiffness of all attachments, (n_freq, R, R), block by block."""
        return attached_stiffness(self.attachments, omega)
