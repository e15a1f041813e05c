"""What an update has to find."""

from collections.abc import Mapping

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import coefficients_of
from modallab.fe.section_size import SectionSize, size
from modallab.fe.structure import Structure
from modallab.updating.nodal_elements import carried, refuse_absent
from modallab.updating.parameterisation import Part

Values = Mapping[str, Mapping[int, float]]  # by part and member

SLIGHT = 1e-9  # of a coefficient: below, two models are the same but for rounding


def wrong_of(true: Values) -> dict[str, dict[int, float]]:
    """Return the coefficients that are not those of no change."""
    return {
        part: {n: value for n, value in table.items() if abs(value - Part(part).unchanged) > SLIGHT}
        for part, table in true.items()
    }


def true_coefficients(model: Structure, truth: Structure, parts: tuple[Part, ...]) -> Values:
    """Return what an update of the model has to find, by part and member: the truth's factors over its own.

    Only what multiplies a member's matrices is compared, and loss factors, and sizes where these are to be
    corrected; whatever else differs has no coefficient.

    Raises
    ------
    InvalidInputError
        If the structures have other members, or stiffness or modulus changes otherwise in bending than in
        extension.
    """
    members = [member.number for member in model.all_members]
    if members != [member.number for member in truth.all_members]:
        raise InvalidInputError(
            "the true structure has other members than the model",
            field="truth_id",
            value=len(truth.all_members),
            allowed="a changed copy of the model",
        )
    has, shall = coefficients_of(model), coefficients_of(truth)
    axial, bending = shall.axial / has.axial, shall.bending / has.bending
    whole = {Part.STIFFNESS, Part.MODULUS} & set(parts)
    if whole and not np.allclose(axial, bending, rtol=SLIGHT, atol=0.0):
        raise InvalidInputError(
            "the true structure differs otherwise in bending than in extension",
            field="parts",
            value=min(whole).value,
            allowed=f"{Part.AXIAL}, {Part.BENDING}",
        )
    ratios = {
        Part.DENSITY: shall.mass / has.mass,
        Part.MODULUS: axial,
        Part.MASS: shall.mass / has.mass,
        Part.STIFFNESS: axial,
        Part.AXIAL: axial,
        Part.BENDING: bending,
        Part.DAMPING: shall.loss_factor - has.loss_factor,
    }
    ratios |= {part: _sizes(truth, part.shape) / _sizes(model, part.shape) for part in parts if part.shape}
    return {
        part.value: _carried(model, truth, part)
        if part.at_node
        else dict(zip(members, map(float, ratios[part]), strict=True))
        for part in parts
    }


def _carried(model: Structure, truth: Structure, part: Part) -> dict[int, float]:
    has, shall = carried(model, part), carried(truth, part)
    refuse_absent(truth, part, has)
    return {node: shall[node] / value for node, value in has.items()}


def _sizes(structure: Structure, shape: SectionSize) -> FloatArray:
    return np.array([size(member, shape, field="parts") for member in structure.all_members])
