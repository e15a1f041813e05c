"""Measured and predicted FRFs and auto spectra of a diagnosis."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, frozen
from modallab.core.dof import Dof


@dataclass(frozen=True, eq=False)
class Spectra:
    """Compared auto spectra, one-sided, with the random error of their logarithm."""

    measured: FloatArray
    """unit^2/Hz, (n_freq, n_channel), measured auto spectra."""
    before: FloatArray
    """unit^2/Hz, (n_freq, n_channel), predicted without added effects."""
    after: FloatArray
    """unit^2/Hz, (n_freq, n_channel), predicted with the added effects."""
    random_error: FloatArray
    """(n_freq, n_channel), standard deviation of the logarithm of the measured spectra."""

    def __post_init__(self) -> None:
        for name in ("measured", "before", "after", "random_error"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), float, np.shape(self.measured), name=name)
            )


@dataclass(frozen=True, eq=False)
class FrfCurves:
    """Compared FRFs side by side, of one drive point after the other."""

    freq: FloatArray
    """Hz, (n_freq,)."""
    measured: ComplexArray
    """m/(s^2 N), (n_freq, n_frf)."""
    before: ComplexArray
    """m/(s^2 N), (n_freq, n_frf), predicted without added effects."""
    after: ComplexArray
    """m/(s^2 N), (n_freq, n_frf), predicted with the added effects."""
    random_error: FloatArray
    """(n_freq, n_frf), relative random error of |H|."""
    held_out: BoolArray
    """(n_frf,), True for FRFs that took no part in any fit."""
    outputs: tuple[Dof, ...]
    """Response of each FRF."""
    inputs: tuple[Dof, ...]
    """Drive point of each FRF."""

    def name(self, i: int) -> str:
        """Return response and drive point of an FRF."""
        return f"{self.outputs[i]} / {self.inputs[i]}"

    def at_lines(self, lines: IntArray) -> "FrfCurves":
        """Return the FRFs at some lines."""
        names = ("freq", "measured", "before", "after", "random_error")
        return replace(self, **{name: getattr(self, name)[lines] for name in names})


@dataclass(frozen=True, eq=False)
class DiagnosisCurves:
    """Compared FRFs, H1 estimates as inertance, and auto spectra where they were measured."""

    freq: FloatArray
    """Hz, (n_freq,), frequency lines."""
    measured: ComplexArray
    """m/(s^2 N), (n_freq, n_out, n_in), measured FRFs."""
    before: ComplexArray
    """m/(s^2 N), (n_freq, n_out, n_in), predicted without added effects."""
    after: ComplexArray
    """m/(s^2 N), (n_freq, n_out, n_in), predicted with the added effects."""
    random_error: FloatArray
    """(n_freq, n_out, n_in), relative random error of |H|."""
    held_out: BoolArray
    """(n_out,), True for responses that took no part in any fit; (n_out, n_in) with several drive points."""
    outputs: tuple[Dof, ...]
    """Measured responses."""
    inputs: tuple[Dof, ...]
    """Drive points."""
    predicted: ComplexArray | None = None
    """m/(s^2 N), (n_freq, n_predicted, n_in), FRFs predicted at DoFs that were not measured."""
    predicted_outputs: tuple[Dof, ...] = ()
    """DoFs of `predicted`."""
    force: Spectra | None = None
    """N^2/Hz, force spectrum of each run, or of each of several shakers."""
    incoherent: Spectra | None = None
    """(m/s^2)^2/Hz, part of each response spectrum that is not coherent with the force."""

    def __post_init__(self) -> None:
        shape = (len(self.freq), len(self.outputs), len(self.inputs))
        for name in ("measured", "before", "after"):
            object.__setattr__(self, name, frozen(getattr(self, name), complex, shape, name=name))
        object.__setattr__(self, "freq", frozen(self.freq, float, shape[:1], name="freq"))
        errors = frozen(self.random_error, float, shape, name="random_error")
        object.__setattr__(self, "random_error", errors)
        held_out_shape = shape[1:] if shape[2] > 1 else shape[1:2]
        object.__setattr__(self, "held_out", frozen(self.held_out, bool, held_out_shape, name="held_out"))
        if self.predicted is not None:
            predicted_shape = (shape[0], len(self.predicted_outputs), shape[2])
            predicted = frozen(self.predicted, complex, predicted_shape, name="predicted")
            object.__setattr__(self, "predicted", predicted)

    @cached_property
    def by_frf(self) -> FrfCurves:
        """The compared FRFs side by side."""
        n_out, n_in = len(self.outputs), len(self.inputs)
        measured, before, after = (
            array.swapaxes(1, 2).reshape(len(self.freq), -1)
            for array in (self.measured, self.before, self.after)
        )
        return FrfCurves(
            self.freq,
            measured,
            before,
            after,
            self.random_error.swapaxes(1, 2).reshape(len(self.freq), -1),
            self.held_out.T.ravel(),
            self.outputs * n_in,
            tuple(drive for drive in self.inputs for _ in range(n_out)),
        )
