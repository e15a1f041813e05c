"""True coefficients of a changed structure."""

from collections.abc import Mapping

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.assembly import coefficients_of
from modallab.fe.section_size import SectionSize, size
from modallab.fe.structure import Structure
from modallab.updating.nodal_elements import check_nodal_values, nodal_values
from modallab.updating.parameterisation import Part

Values = Mapping[str, Mapping[int, float]]  # by part and member


def erroneous_coefficients(true: Values) -> dict[str, dict[int, float]]:
    """Return the coefficients that differ from nominal."""
    return {
        part: {
            n: value for n, value in table.items() if abs(value - Part(part).nominal) > COMPARISON_ROUNDING
        }
        for part, table in true.items()
    }


def true_coefficients(model: Structure, truth: Structure, parts: tuple[Part, ...]) -> Values:
    """Return the true coefficients by part and member: the factors of the truth over those of the model.

    Only factors of members' matrices are compared, loss factors, and sizes where these are corrected; other
    differences have no coefficient.

    Raises
    ------
    InvalidInputError
        If the structures have different members, or stiffness or modulus differ in bending and extension.
    """
    members = [member.number for member in model.all_members]
    if members != [member.number for member in truth.all_members]:
        raise InvalidInputError(
            "the true structure has other members than the model",
            field="truth_id",
            value=len(truth.all_members),
            allowed="a changed copy of the model",
        )
    model_factors, true_factors = coefficients_of(model), coefficients_of(truth)
    axial, bending = true_factors.axial / model_factors.axial, true_factors.bending / model_factors.bending
    uniform_parts = {Part.STIFFNESS, Part.MODULUS} & set(parts)
    if uniform_parts and not np.allclose(axial, bending, rtol=COMPARISON_ROUNDING, atol=0.0):
        raise InvalidInputError(
            "the true structure differs otherwise in bending than in extension",
            field="parts",
            value=min(uniform_parts).value,
            allowed=[Part.AXIAL, Part.BENDING],
        )
    ratios = {
        Part.DENSITY: true_factors.mass / model_factors.mass,
        Part.MODULUS: axial,
        Part.MASS: true_factors.mass / model_factors.mass,
        Part.STIFFNESS: axial,
        Part.AXIAL: axial,
        Part.BENDING: bending,
        Part.DAMPING: true_factors.loss_factor - model_factors.loss_factor,
    }
    ratios |= {
        part: _section_sizes(truth, part.section_size) / _section_sizes(model, part.section_size)
        for part in parts
        if part.section_size
    }
    return {
        part.value: _nodal_ratios(model, truth, part)
        if part.is_nodal
        else dict(zip(members, map(float, ratios[part]), strict=True))
        for part in parts
    }


def _nodal_ratios(model: Structure, truth: Structure, part: Part) -> dict[int, float]:
    model_values, true_values = nodal_values(model, part), nodal_values(truth, part)
    check_nodal_values(truth, part, model_values)
    return {node: true_values[node] / value for node, value in model_values.items()}


def _section_sizes(structure: Structure, shape: SectionSize) -> FloatArray:
    return np.array([size(member, shape, field="parts") for member in structure.all_members])
