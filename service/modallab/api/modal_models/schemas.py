"""Wire types of modal models."""

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field

from modallab.api.deps import Id
from modallab.api.derived import OptionsByMethod, body_of, options_from
from modallab.api.schema import Limits, OneOf
from modallab.api.wire import NO_CONVERSION, Count, DofText, ModeCount, Number, Seed, Text, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.line_options import MAX_BANDS, ExcludedLines
from modallab.core.modal_model import ModalModel, Mode
from modallab.extraction.default_method import FEW_REFERENCES, SINGLE_REFERENCE
from modallab.extraction.method_options import OPTIONS, options_type
from modallab.extraction.requested.selection import ModeSelection
from modallab.fe.synthetic_modes import Distribution, ModeNoise
from modallab.jobs.extracting import ExtractionInputs, ExtractionRequest


class ModeNoiseIn(Wire):
    """Relative errors of eigenvalues and of shape entries."""

    eigenvalue: Annotated[Number, Limits(0.0, 1.0, upper_excluded=True)] = 0.0
    """1, relative error of eigenvalues"""
    eigenvector: Annotated[Number, Limits(0.0, 1.0, upper_excluded=True)] = 0.0
    """1, relative error of shape entries"""
    distribution: Distribution = Distribution.UNIFORM
    """distribution of the errors"""

    def to_domain(self) -> ModeNoise:
        """Return the noise."""
        return ModeNoise(self.eigenvalue, self.eigenvector, self.distribution)


Dofs = Annotated[list[DofText], Field(min_length=1, max_length=5000)]


def distinct(texts: Sequence[str]) -> tuple[Dof, ...]:
    """Return DoFs; `InvalidInputError` if a text is none, or one is named twice, whatever its sense."""
    dofs = tuple(Dof.parse(text, field="dofs") for text in texts)
    if len({dof.point for dof in dofs}) < len(dofs):
        raise InvalidInputError(
            "a DoF is named twice", field="dofs", value=list(texts[:20]), allowed="each once"
        )
    return dofs


class SyntheticIn(Wire):
    """Modes of a structure as a test would give them."""

    count: ModeCount
    """number of elastic modes"""
    dofs: Dofs
    """degrees of freedom at which shapes are known, each once"""
    noise: ModeNoiseIn = ModeNoiseIn()
    """errors of the modes"""
    seed: Seed = 0
    """seed of the random numbers"""

    def places(self) -> tuple[Dof, ...]:
        """Return the DoFs at which shapes are known."""
        return distinct(self.dofs)


EXTRACTION_BODIES = {cls: body_of(cls) for cls in dict.fromkeys(OPTIONS.values())}
ExtractionOptionsBody = Annotated[
    Wire,
    OptionsByMethod(
        {method: EXTRACTION_BODIES[cls] for method, cls in OPTIONS.items()}, default=SINGLE_REFERENCE
    ),
]


class ModalModelStart(body_of(ExcludedLines)):  # type: ignore[misc]
    """Modes to be read from a measurement.

    Bands are in Hz, each with one mode, or of a global method one and more; or found by themselves.
    """

    model_config = ConfigDict(use_attribute_docstrings=True)

    measurement_id: Id
    """measurement whose FRFs are read"""
    method: Annotated[Text, OneOf(lambda: OPTIONS)] | None = Field(
        default=None,
        description="extraction method, as `/catalog/extraction-methods` lists them; left out:"
        f" `{FEW_REFERENCES}` with several references, `{SINGLE_REFERENCE}` with one, as"
        " `choices` of the modal model tell",
    )
    options: ExtractionOptionsBody = Field(
        default_factory=dict,
        validate_default=True,
        description=f"options of the method; without a method, of `{SINGLE_REFERENCE}`",
    )
    bands: (
        Literal["auto"] | Annotated[list[tuple[Number, Number]], Field(min_length=1, max_length=MAX_BANDS)]
    ) = "auto"
    """Hz, low and high end of each band; `auto`: found by a mode indicator"""
    n_modes: Annotated[int, Field(ge=1, le=500), NO_CONVERSION] | None = None
    """largest number of modes, the most prominent; null: all that stand out"""
    correct_window_damping: bool = Field(
        False, description="take what an exponential window added out of the loss factors"
    )

    def to_task(self) -> tuple[ExtractionInputs, ExtractionRequest]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        InvalidInputError
            If the method is unknown, or cannot do what is asked of it.
        """
        request = ExtractionRequest(
            method=self.method,
            options=options_from(options_type(self.method or SINGLE_REFERENCE), self.options),
            bands=None if self.bands == "auto" else tuple(self.bands),
            n_modes=self.n_modes,
            exclude=options_from(ExcludedLines, self).exclude,
            correct_window_damping=self.correct_window_damping,
        )
        return ExtractionInputs(self.measurement_id), request


Modes = Annotated[list[Count], Field(max_length=500)]


class SelectionIn(Wire):
    """Modes to be dropped or merged, by their numbers from 1."""

    drop: Modes = Field(default=[])
    """numbers of modes that are dropped"""
    merge: list[Modes] = Field(default=[], max_length=250)
    """groups of numbers; the modes of each become one"""

    def to_domain(self) -> ModeSelection:
        """Return the selection; `InvalidInputError` if it is empty, or names a mode twice."""
        return ModeSelection(tuple(self.drop), tuple(map(tuple, self.merge)))


Complex = Number | tuple[Number, Number]


class ModeIn(Wire):
    """One mode; shape entries are numbers or [re, im]."""

    frequency: Annotated[float, Field(gt=0, le=1e30), NO_CONVERSION] = Field(description="Hz")
    loss_factor: Number = 0.0
    """1, loss factor"""
    shape: list[Complex] = Field(min_length=1, max_length=5000)
    """mode shape, one entry a degree of freedom"""

    def to_domain(self, n_dofs: int) -> Mode:
        """Return the mode; `InvalidInputError` if its shape has another length."""
        if len(self.shape) != n_dofs:
            raise InvalidInputError(
                "a shape has an entry for each DoF", field="shape", value=len(self.shape), allowed=n_dofs
            )
        shape = np.array([complex(*v) if isinstance(v, tuple) else complex(v) for v in self.shape])
        return Mode(frequency=self.frequency, loss_factor=self.loss_factor, shape=shape)


class ModalModelIn(Wire):
    """Modes from elsewhere, at named DoFs."""

    modes: list[ModeIn] = Field(min_length=1, max_length=500)
    """modes in any order"""
    dofs: Dofs
    """degrees of freedom of the shapes, each once"""
    normalisation: Literal["mass", "none"] = "mass"
    """`mass`: 1/sqrt(kg), mass-normalised; `none`: unscaled"""

    def to_domain(self) -> ModalModel:
        """Return the modal model, in rising frequency."""
        dofs = distinct(self.dofs)
        modes = sorted((m.to_domain(len(dofs)) for m in self.modes), key=lambda mode: mode.frequency)
        return ModalModel(tuple(modes), dofs, self.normalisation, method="imported")
