"""Modal models: arrays, tables and pictures."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab_client import _frames, _plots, _tables
from modallab_client._numbers import rounded
from modallab_client._read import read_as
from modallab_client._shapes import ShapePictures
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import DoubtfulMode, ModalModel, Mode, Spread


@dataclass(frozen=True, eq=False, kw_only=True)
class FrequencyInconsistencyMethods:
    """Frequency shifts of each FRF."""

    shift: FloatArray = field(repr=False)
    """Hz, (n_modes, n_frf) from the unweighted mean of each mode; NaN where an FRF does not show it."""
    shift_error: FloatArray = field(repr=False)
    """Hz, (n_modes, n_frf) standard errors."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ModalModelMethods(ShapePictures):
    """Shapes, constants of each FRF, a table and a picture."""

    shapes: ComplexArray = field(repr=False)
    """(n_dof, n_modes) 1/sqrt(kg)."""
    modal_constants: ComplexArray | None = field(repr=False, default=None)
    """1/kg, (n_modes, n_frf) in the order of `frfs`; None for modes that were not extracted from FRFs."""
    fitted_frequencies: FloatArray | None = field(repr=False, default=None)
    """Hz, (n_modes, n_frf); NaN where an FRF does not show the mode."""
    fitted_loss_factors: FloatArray | None = field(repr=False, default=None)
    """(n_modes, n_frf)."""
    shape_errors: FloatArray | None = field(repr=False, default=None)
    """1/sqrt(kg), (n_dof, n_modes) standard errors of the magnitudes."""
    modal_constant_errors: FloatArray | None = field(repr=False, default=None)
    """1/kg, (n_modes, n_frf) standard error of the real and of the imaginary part."""
    if TYPE_CHECKING:
        id: str
        method: str
        modes: tuple[Mode, ...]
        doubtful: tuple[DoubtfulMode, ...]
        main_flags: tuple[str, ...]

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def loss_factors(self) -> FloatArray:
        """(n_modes,)."""
        return np.array([mode.loss_factor for mode in self.modes])

    def table(self) -> str:
        """Return frequency and loss factor of each mode with standard errors and flags as text.

        With their scatter over the FRFs, where a method fits each FRF; doubtful poles stand below. Flags are
        kinds with their numbers.
        """
        parts = [_tables.text(*self._rows(), words=True), *self.main_flags]
        if self.doubtful:
            parts.append(_tables.text(*self._doubtful_rows(), words=True))
        return "\n\n".join(parts)

    def summary(self) -> str:
        """Return how many modes there are, where, and their loss factors in one sentence."""
        if not self.modes:
            return f"No mode was found by {self.method}."
        freq, loss = self.frequencies, self.loss_factors
        plural = len(self.modes) > 1
        where = f"from {freq.min():.4g} to {freq.max():.4g} Hz" if plural else f"at {freq[0]:.4g} Hz"
        ends = dict.fromkeys((f"{loss.min():.3g}", f"{loss.max():.3g}"))
        factors = " to ".join(ends)
        doubtful = f"; doubtful besides: {len(self.doubtful)}" if self.doubtful else ""
        source = self.method if self.method == "imported" else f"by {self.method}"
        words = f"{len(self.modes)} mode{'s' * plural} {where} {source}"
        return f"{words}, loss factor{'s' * plural} {factors}{doubtful}."

    def _rows(self) -> _tables.Table:
        scattered = any(mode.frequency_spread is not None for mode in self.modes)
        head = ("mode", "quantity", "value", "std error", *_STATISTICS[: 4 * scattered], "flags")
        rows = []
        for number, mode in enumerate(self.modes, 1):
            flags = ", ".join(_counted(name, n) for name, n in mode.flag_counts.items())
            for first, quantity, value, spread, words in (
                (str(number), "frequency", mode.frequency, mode.frequency_spread, flags),
                ("", "loss_factor", mode.loss_factor, mode.loss_factor_spread, ""),
            ):
                error = mode.standard_errors.get(quantity)
                cells = _scatter(spread)[: 4 * scattered]
                rows.append(
                    (first, _NAMES[quantity], rounded(value, error, least=5), _error(error), *cells, words)
                )
        return head, rows

    def _doubtful_rows(self) -> _tables.Table:
        rows = [
            (
                f"{pole.frequency:.5g}",
                "" if pole.loss_factor is None else f"{pole.loss_factor:.3g}",
                pole.reason,
            )
            for pole in self.doubtful
        ]
        return ("doubtful, Hz", "loss factor", "reason"), rows

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame` with one row a mode.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        return _frames.modes(cast("ModalModel", self))

    def plot(self) -> "Axes":
        """Draw loss factor over frequency, with the standard deviations over the FRFs; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.modal_model(cast("ModalModel", self))

    def _repr_html_(self) -> str:
        tables = _tables.html(*self._rows(), caption=f"Modal model {self.id}, {self.method}")
        tables += "".join(f"<p>{escape(text)}</p>" for text in self.main_flags)
        if self.doubtful:
            tables += _tables.html(*self._doubtful_rows(), caption="Doubtful poles")
        return tables


_STATISTICS = ("min", "max", "mean", "sd")
_NAMES = {"frequency": "frequency Hz", "loss_factor": "loss factor"}


def _counted(kind: str, count: int) -> str:
    words = kind.replace("_", " ")
    return words if count == 1 else f"{words} ({count})"


def _scatter(spread: "Spread | None") -> tuple[str, ...]:
    if spread is None:
        return ("",) * len(_STATISTICS)
    return tuple(f"{x:.5g}" for x in (spread.min, spread.max, spread.mean, spread.sd))


def _error(error: float | None) -> str:
    return "" if error is None else f"{error:.2g}"


def modal_model_of(data: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> "ModalModel":
    """Return a modal model from its JSON and the arrays of its npz file."""
    from modallab_client._generated.models import FrequencyInconsistency, ModalModel

    names = {"fitted_frequency": "fitted_frequencies", "fitted_loss_factor": "fitted_loss_factors"}
    served = ("shapes", "modal_constants", "shape_errors", "modal_constant_errors", *names)
    fields: dict[str, Any] = {names.get(name, name): arrays[name] for name in served if name in arrays}
    data_inconsistency = data.get("frequency_inconsistency")
    if data_inconsistency is not None:
        shifts: dict[str, Any] = {
            name: arrays[f"frequency_inconsistency_{name}"] for name in ("shift", "shift_error")
        }
        fields["frequency_inconsistency"] = read_as(FrequencyInconsistency, data_inconsistency, **shifts)
    return read_as(ModalModel, data, **fields)
