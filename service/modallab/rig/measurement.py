"""Measurement: FRFs, coherence and spectra with the rig as declared."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, frozen
from modallab.core.assumption import Assumption
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.estimation.partial_coherence import partial_coherence
from modallab.rig.estimates import Estimates
from modallab.rig.setup import RigSetup
from modallab.rig.time_records import TimeRecords


@dataclass(frozen=True, eq=False)
class Measurement:
    """FRFs with coherence and auto spectra, and the rig as declared."""

    frf: FrfSet
    """Measured FRFs."""
    coherence: FloatArray | None
    """1, ordinary or multiple coherence (n_freq, n_out), (n_freq, n_out, n_in) with a roving hammer."""
    averages: float
    """1, effective number of independent averages."""
    setup: RigSetup
    """Rig as declared in the log book."""
    force_spectrum: FloatArray | None = None
    """N^2/Hz, force auto spectra (n_freq, n_out, n_in), each of the run of that response."""
    response_spectrum: FloatArray | None = None
    """unit^2/Hz, auto spectra of the motion of `frf.kind` (n_freq, n_out), (n_freq, n_out, n_in) with a
    roving hammer."""
    noise_floor: float | None = None
    """1, relative error of the FRFs as their owner states it, at or above the median."""
    input_condition: FloatArray | None = None
    """1, condition number of G_ff by line (n_freq,), with several simultaneous forces."""
    force_cross_spectra: ComplexArray | None = None
    """N^2/Hz, (n_freq, n_out, n_in, n_in), cross spectra G_jk = E[conj(F_j) F_k] of several simultaneous
    forces, each of the run of that response; the auto spectra on the diagonal."""
    seed: int | None = None
    """Seed of the random numbers; None: not simulated here."""
    route: str | None = None
    """Route of the simulation, see `Route`; None: imported."""
    libraries: Mapping[str, str] = field(default_factory=dict)
    """Versions of the numerical libraries, by name."""
    notes: tuple[str, ...] = ()
    """Remarks on systematic changes of the FRFs."""
    assumed: tuple[Assumption, ...] = ()
    """Assumptions about an imported test that neither its file nor its log book states."""
    averages_error: float | None = None
    """1, standard error of averages that are estimated; None: they are declared."""
    records: TimeRecords | None = None
    """Time records that were kept; None: there are none."""
    estimates: Estimates | None = None
    """Estimates after the first averages, as measured; None: none were kept."""

    def __post_init__(self) -> None:
        shape = self.frf.values.shape
        roved = self.setup.exciter.kind == "hammer" and shape[2] > 1
        response_shape = shape if roved else shape[:2]
        expected = {"coherence": response_shape, "force_spectrum": shape, "response_spectrum": response_shape}
        expected |= {"input_condition": shape[:1], "force_cross_spectra": (*shape, shape[2])}
        for name, array_shape in expected.items():
            value = getattr(self, name)
            if value is not None:
                dtype = complex if name == "force_cross_spectra" else float
                object.__setattr__(self, name, frozen(value, dtype, array_shape, name=name))
        if self.force_cross_spectra is not None:
            _check_cross_spectra(self.force_cross_spectra)
        if self.coherence is not None and not (
            (self.coherence >= 0).all() and (self.coherence <= 1 + COMPARISON_ROUNDING).all()
        ):
            raise InvalidInputError("coherence lies between 0 and 1", field="coherence")
        for name in ("force_spectrum", "response_spectrum"):
            value = getattr(self, name)
            if value is not None and (value < 0).any():
                raise InvalidInputError("an auto spectrum is not negative", field=name, allowed=bounds(0))
        if self.noise_floor is not None and not 0 < self.noise_floor <= 1:  # NaN fails too
            raise InvalidInputError(
                "a noise floor is a relative error",
                field="noise_floor",
                value=self.noise_floor,
                allowed=bounds(exclusive_minimum=0, maximum=1),
            )
        if not self.averages >= 1:
            raise InvalidInputError(
                "a measurement needs an average", field="averages", value=self.averages, allowed=bounds(1)
            )

    @property
    def simultaneous_forces(self) -> ComplexArray | None:
        """(n_freq, n_out, n_in, n_in), N^2/Hz, cross spectra of forces that act at once; None: they do not.

        Forces whose cross spectra were not measured are taken as uncorrelated; without auto spectra, as of
        equal power, 1 N^2/Hz.
        """
        shape, power = self.frf.values.shape, self.force_spectrum
        if self.setup.n_simultaneous == 1:
            return None
        if self.force_cross_spectra is not None:
            return self.force_cross_spectra
        power = np.ones(shape) if power is None else power
        return (power[..., None] * np.eye(shape[2])).astype(complex)

    @property
    def frf_coherence(self) -> FloatArray | None:
        """(n_freq, n_out, n_in), coherence of each FRF: the partial one where forces act simultaneously."""
        g2 = self.coherence
        if g2 is None or g2.ndim == 3:
            return g2
        return partial_coherence(self.frf.values, g2, self.simultaneous_forces)

    def to(self, kind: FrfKind) -> "Measurement":
        """Return the same measurement as another kind of FRF: itself where it is of that kind.

        FRFs take a factor i omega a step, the auto spectra of responses omega^2; forces and
        coherence stay. At 0 Hz nothing can be integrated: towards receptance that line is left out
        of every array, and a note says so.
        """
        steps = self.frf.kind.steps_to(kind)
        if steps == 0:
            return self
        if note := self.frf.left_out(kind):
            return replace(self.by_line(lambda array: array[1:]), notes=(*self.notes, *note)).to(kind)
        spectrum = self.response_spectrum
        if spectrum is not None:
            size = (2 * np.pi * self.frf.freq) ** (2 * steps)
            spectrum = spectrum * size.reshape(-1, *[1] * (spectrum.ndim - 1))
        return replace(self, frf=self.frf.to(kind), response_spectrum=spectrum)

    def at(self, lines: BoolArray | None) -> "Measurement":
        """Return the measurement at the lines of a mask (n_freq,); itself if there is none."""
        return self if lines is None else self.by_line(lambda array: array[lines])

    def by_line(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> "Measurement":
        """Return the measurement with every array that has a frequency axis changed alike."""
        names = ("coherence", "force_spectrum", "response_spectrum", "input_condition", "force_cross_spectra")
        arrays: dict[str, Any] = {n: change(array) for n in names if (array := getattr(self, n)) is not None}
        frf = replace(self.frf, freq=change(self.frf.freq), values=change(self.frf.values))
        return replace(self, frf=frf, **arrays)


def _check_cross_spectra(forces: ComplexArray) -> None:
    """Raise `InvalidInputError` unless matrices (.., n_in, n_in) are Hermitian, without negative power."""
    size = np.abs(forces).max(axis=(-2, -1)) + np.finfo(float).tiny
    asymmetry = np.abs(forces - forces.conj().swapaxes(-1, -2)).max(axis=(-2, -1))
    least = np.linalg.eigvalsh(forces)[..., 0]
    if (asymmetry > COMPARISON_ROUNDING * size).any() or (least < -COMPARISON_ROUNDING * size).any():
        raise InvalidInputError(
            "these are no cross spectra of forces",
            field="force_cross_spectra",
            allowed="Hermitian matrices E[conj(F_j) F_k] without negative eigenvalues",
        )
