"""Coherence and auto spectra of a universal file that are complete for all FRFs."""

import re
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.frf import FrfSet
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_format import (
    AUTO_SPECTRUM,
    COHERENCE,
    DENSITY,
    FORCE,
    MOTIONS,
    MULTIPLE_COHERENCE,
    Function,
)

# Common units other than SI, which a file could contain without conversion factors.
_NOT_SI = re.compile(r"(?<![A-Za-z])(g|gn|mm|um|cm|in|inch|ft|mil|ips|lb|lbf|kN|mN|dB|V|mV)(?![A-Za-z])")


def same_axis(freq: FloatArray, reference: FloatArray) -> bool:
    """Return whether two axes are the same but for rounding."""
    return len(freq) == len(reference) and np.allclose(freq, reference, rtol=UNIVERSAL.axis_error, atol=0.0)


def not_si(label: str, units: tuple[float, float]) -> bool:
    """Return whether a label names units other than SI and the file has no conversion factors."""
    return units == (1.0, 1.0) and _NOT_SI.search(label) is not None


class Companions:
    """Selection of coherence and spectra of the FRFs, with notes on omitted ones."""

    def __init__(
        self,
        functions: Sequence[Function],
        frf_functions: Sequence[Function],
        frf: FrfSet,
        units: tuple[float, float] | None,
    ) -> None:
        self._functions = [f for f in functions if same_axis(f.freq, frf.freq)]
        runs = {(f.response, f.reference): f.run for f in frf_functions}
        self._runs = [[runs[output, source] for source in frf.inputs] for output in frf.outputs]
        self._outputs = [dof.point for dof in frf.outputs]
        self._inputs = [dof.point for dof in frf.inputs]
        self._motion, self._units = MOTIONS[frf.kind], units or (1.0, 1.0)
        self._units_stated = units is None
        self.notes: list[str] = []

    def coherence(self) -> FloatArray | None:
        """Return the coherence of each response, or of each FRF where a hammer roved."""
        ordinary = {
            (f.response.point, f.reference.point): f.data.real
            for f in self._functions
            if f.type == COHERENCE and f.response and f.reference
        }
        multiple = {
            (f.response.point,): f.data.real
            for f in self._functions
            if f.type == MULTIPLE_COHERENCE and f.response
        }
        if multiple and len(self._inputs) > 1:
            values = self._stacked("coherence", multiple, [[(output,)] for output in self._outputs])
        else:
            # Coherence with other references is ignored.
            ours = {key: curve for key, curve in ordinary.items() if key[1] in self._inputs}
            pairs = [[(output, source) for source in self._inputs] for output in self._outputs]
            values = self._stacked("coherence", ours, pairs)
        return values

    def response_spectrum(self) -> FloatArray | None:
        """Return the auto spectrum of each response, or in the run of each FRF, unit^2/Hz."""
        spectra = [f for f in self._densities(self._motion) if f.response]
        by_response = {f.response.point: f.data.real for f in spectra if f.response}
        if len(by_response) == len(spectra) or len(self._inputs) == 1:
            values = self._stacked("response spectra", by_response, [[output] for output in self._outputs])
        else:
            by_run = {(f.run, f.response.point): f.data.real for f in spectra if f.response}
            rows = zip(self._runs, self._outputs, strict=True)
            keys = [[(run, output) for run in runs] for runs, output in rows]
            values = self._stacked("response spectra", by_run, keys)
        return None if values is None else values / self._units[0] ** 2

    def force_spectrum(self) -> FloatArray | None:
        """Return the force's auto spectrum in the run of each FRF, (n_freq, n_out, n_in) N^2/Hz."""
        forces = [f for f in self._densities(FORCE) if f.response and f.response.point in self._inputs]
        by_run = {(f.run, f.response.point): f.data.real for f in forces if f.response}
        by_source = {f.response.point: f.data.real for f in forces if f.response}
        if len(by_source) == len(forces):  # all was measured at once
            values = self._stacked(
                "force spectra", by_source, [self._inputs for _ in self._outputs], keep_input_axis=True
            )
        elif len(by_run) < len(forces):
            self.notes.append("force spectra left out: which belongs to which response is not clear")
            return None
        else:
            keys = [list(zip(runs, self._inputs, strict=True)) for runs in self._runs]
            values = self._stacked("force spectra", by_run, keys, keep_input_axis=True)
        return None if values is None else values / self._units[1] ** 2

    def _densities(self, numerator: int) -> list[Function]:
        spectra = [
            f for f in self._functions if f.type in (AUTO_SPECTRUM, DENSITY) and f.numerator == numerator
        ]
        densities = [
            f
            for f in spectra
            if (f.type == DENSITY or "/Hz" in f.units[0])
            and (self._units_stated or not not_si(f.units[0], self._units))
        ]
        if len(densities) < len(spectra):
            self.notes.append("auto spectra left out: not per Hz and in SI units")
        return densities

    def _stacked(
        self,
        name: str,
        curves: Mapping[Any, FloatArray],
        keys: Sequence[Sequence[Hashable]],
        keep_input_axis: bool = False,
    ) -> FloatArray | None:
        """Return curves by response and input, a single input without axis unless `keep_input_axis`."""
        if not curves:
            return None
        if not all(key in curves for row in keys for key in row):
            self.notes.append(f"{name} left out: not there for every FRF")
            return None
        values = np.stack([np.stack([curves[key] for key in row], axis=-1) for row in keys], axis=1)
        return values if keep_input_axis or values.shape[2] > 1 else values[:, :, 0]
