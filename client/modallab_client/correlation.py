"""How modes and FRFs of a test agree with a model, and what carries one to the points of the other."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from modallab_client import _plots, _tables
from modallab_client.models import FloatArray
from modallab_client.results import ModalModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class ReductionUsed:
    """How the model's mass was reduced to the measured DoFs, and how good that is."""

    kind: str
    parameters: Mapping[str, float]
    frequency_errors: FloatArray  # (n_model,) of the reduced model, relative to the full one
    n_motions: int | None = None  # that the reduced model has, rigid-body motions among them


@dataclass(frozen=True, eq=False)
class ResponseCorrelation:
    """How measured FRFs agree with those of a model at the same points and lines."""

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    frac: FloatArray  # (n_out, n_in), 0 to 1
    freq: FloatArray  # (n_lines,) Hz, of both axes of the FDAC
    fdac: FloatArray = field(repr=False)  # (n_in, n_lines measured, n_lines model), 0 to 1
    # measured over model frequency along the FDAC's ridge; None where there is none, or one response only
    frequency_scale: float | None = None
    fdac_on_ridge: float | None = None  # mean
    fdac_unscaled: float | None = None  # mean at equal frequencies
    notes: tuple[str, ...] = ()

    def plot(self, drive: str | None = None) -> "Axes":
        """Draw the FDAC of an input, by default the first, with its ridge; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such input.
        """
        return _plots.fdac(self, self.inputs[0] if drive is None else drive)

    def plot_frac(self) -> "Axes":
        """Draw the FRAC of every FRF; return the axes."""
        return _plots.frac(self)


@dataclass(frozen=True, eq=False)
class Correlation:
    """How the modes of a test and of a model agree."""

    mac: FloatArray  # (n_measured, n_model)
    pairs: tuple[tuple[int, int], ...]  # (measured, model), counted from 1
    frequency_differences: FloatArray  # (n_pairs,) Hz
    comac: FloatArray  # (n_dof,) 1 agrees
    dofs: tuple[str, ...] = ()
    id: str | None = None
    ecomac: FloatArray | None = None  # (n_dof,) 0 agrees
    pole_weighted_mac: FloatArray | None = None  # (n_measured, n_model)
    reduction: ReductionUsed | None = None  # where one was asked for, and with it the next two
    cross_orthogonality: FloatArray | None = None  # (n_measured, n_model)
    auto_orthogonality: FloatArray | None = None  # (n_measured, n_measured)
    responses: ResponseCorrelation | None = None  # where a measurement was given

    def plot(self) -> "Axes":
        """Draw the MAC matrix; return the axes."""
        return _plots.mac(self)

    def plot_coordinates(self) -> "tuple[Axes, Axes]":
        """Draw CoMAC and, below, ECoMAC of every DoF; return both axes."""
        return _plots.coordinates(self)

    def plot_orthogonality(self) -> "tuple[Axes, Axes]":
        """Draw cross- and auto-orthogonality side by side; return both axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If no reduction was asked for.
        """
        return _plots.orthogonality(self)

    def table(self) -> str:
        """Return the pairs with their frequency differences and MAC as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head: tuple[str, ...] = ("measured", "model", "difference Hz", "MAC")
        cross = self.cross_orthogonality
        if cross is not None:
            head = (*head, "orthogonality")
        rows = []
        for (i, j), difference in zip(self.pairs, self.frequency_differences, strict=True):
            cells = (str(i), str(j), f"{difference:+.4g}", f"{self.mac[i - 1, j - 1]:.4f}")
            rows.append(cells if cross is None else (*cells, f"{cross[i - 1, j - 1]:.4f}"))
        return head, rows

    def _repr_html_(self) -> str:
        caption = f"Correlation at {len(self.comac)} degrees of freedom"
        return _tables.html(*self._rows(), caption=caption)


@dataclass(frozen=True, eq=False)
class Expansion:
    """Measured modes at all DoFs of a structure, and how far the structure goes along with them."""

    model: ModalModel
    fit_residuals: FloatArray  # (n_modes,) share of the measured shape that the expanded one does not have
    # (n_modes,) Hz, at which strain and kinetic energy of the structure balance in the expanded shape
    rayleigh_frequencies: FloatArray

    def table(self) -> str:
        """Return what each mode left over, and its frequency by measurement and by the shape, as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("mode", "frequency Hz", "of the shape Hz", "residual", "flags")
        numbers = zip(self.model.modes, self.rayleigh_frequencies, self.fit_residuals, strict=True)
        rows = [
            (str(i), f"{mode.frequency:.2f}", f"{rayleigh:.2f}", f"{residual:.2g}", ", ".join(mode.flags))
            for i, (mode, rayleigh, residual) in enumerate(numbers, 1)
        ]
        return head, rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Modes {self.model.id} at {len(self.model.dofs)} DoFs")


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A structure at some of its DoFs: x = T x_master."""

    masters: tuple[str, ...]
    dofs: tuple[str, ...]
    transformation: FloatArray  # (n_dof, n_master)
    mass: FloatArray  # (n_master, n_master) kg
    stiffness: FloatArray  # (n_master, n_master) N/m
    frequencies: FloatArray  # (k,) Hz, of the reduced model
    shapes: FloatArray  # (n_master, k) 1/sqrt(kg)
    model_frequencies: FloatArray  # (n,) Hz, of the full model's first elastic modes
    frequency_errors: FloatArray  # (n,) of the reduced model for each of these, relative
