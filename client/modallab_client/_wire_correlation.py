"""JSON and npz to expanded modes and reduced models; pure."""

from modallab_client import correlation as results
from modallab_client._wire import Arrays, Json, floats, texts
from modallab_client.results import ModalModel


def expansion(data: Json, model: ModalModel) -> results.Expansion:
    """Return expanded modes."""
    return results.Expansion(model, floats(data["fit_residuals"]), floats(data["rayleigh_frequencies"]))


def reduced(given: Arrays) -> results.ReducedModel:
    """Return a reduced model."""
    return results.ReducedModel(
        masters=texts(given["masters"]),
        dofs=texts(given["dofs"]),
        transformation=given["transformation"],
        mass=given["mass"],
        stiffness=given["stiffness"],
        frequencies=given["frequencies"],
        shapes=given["shapes"],
        model_frequencies=given["model_frequencies"],
        frequency_errors=given["frequency_errors"],
    )
