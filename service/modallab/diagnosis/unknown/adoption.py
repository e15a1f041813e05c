"""An unknown effect as an effect of the catalogue: a tabulated curve."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.frequency_table import MAX_ROWS, FrequencyTable
from modallab.core.place import EffectSpec
from modallab.diagnosis.result import Unknown, UnknownCause
from modallab.diagnosis.unknown.curve_models import GAIN_MODELS, STIFFNESS_MODELS
from modallab.rig.effect import Effect, build


def adopted_effect(unknown: Unknown, freq: FloatArray) -> Effect:
    """Return an unknown effect as a tabulated stiffness, or as the tabulated response of channels.

    By its parametric model where that is one of its own motion; otherwise by its curve.

    Parameters
    ----------
    freq
        (n_freq,) Hz, lines of the measurement.
    """
    lines = freq[freq > 0]
    lines = lines[:: -(-len(lines) // MAX_ROWS)]
    values = model_values(unknown, lines)
    if values is None:
        lines = np.array([point.frequency for point in unknown.curve])
        values = np.array([complex(point.real, point.imaginary) for point in unknown.curve])
    stiffness = unknown.cause is UnknownCause.INTERNAL_FORCE
    kind = "tabulated_stiffness" if stiffness else "tabulated_response"
    return build(EffectSpec(kind, unknown.at, table=FrequencyTable.of(lines, values).rows))


def model_values(unknown: Unknown, freq: FloatArray) -> ComplexArray | None:
    """Return the values (n_freq,) by the parametric model; None without one of the own motion."""
    if unknown.curve_model is None or unknown.source not in (None, unknown.at):
        return None
    (model,) = (m for m in (*STIFFNESS_MODELS, *GAIN_MODELS) if m.name is unknown.curve_model)
    amount, *shapes = (unknown.parameters[name].value for name in (model.amount, *model.shape_units))
    return np.asarray(amount * model.shape(np.array(shapes), 2 * np.pi * freq))
