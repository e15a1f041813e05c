"""JSON and npz to correlations, expanded modes and reduced models; pure."""

from modallab_client import correlation as results
from modallab_client._wire import Arrays, Json, floats, texts
from modallab_client.results import ModalModel


def has_responses(data: Json) -> bool:
    """Return whether FRFs were held against each other, so that there are arrays to ask for."""
    return data.get("frac") is not None


def correlation(data: Json, given: Arrays | None = None) -> results.Correlation:
    """Return a correlation; its FDAC is among the arrays."""
    reduction = data.get("reduction")
    return results.Correlation(
        mac=floats(data["mac"]),
        pairs=tuple((int(measured), int(model)) for measured, model in data["pairs"]),
        frequency_differences=floats(data["frequency_differences"]),
        comac=floats(data["comac"]),
        dofs=texts(data.get("dofs") or ()),
        id=data.get("id"),
        reduction=None
        if reduction is None
        else results.ReductionUsed(
            kind=reduction["kind"],
            parameters=dict(reduction.get("parameters") or {}),
            frequency_errors=floats(reduction["frequency_errors"]),
            n_motions=reduction.get("n_motions"),
        ),
        responses=None if given is None or not has_responses(data) else _responses(data, given),
        **{name: None if data.get(name) is None else floats(data[name]) for name in _MATRICES},
    )


_MATRICES = ("ecomac", "pole_weighted_mac", "cross_orthogonality", "auto_orthogonality")


def _responses(data: Json, given: Arrays) -> results.ResponseCorrelation:
    return results.ResponseCorrelation(
        outputs=texts(data["outputs"]),
        inputs=texts(data["inputs"]),
        frac=floats(data["frac"]),
        freq=given["fdac_freq"],
        fdac=given["fdac"],
        frequency_scale=data.get("frequency_scale"),
        fdac_on_ridge=data.get("fdac_on_ridge"),
        fdac_unscaled=data.get("fdac_unscaled"),
        notes=texts(data.get("notes") or ()),
    )


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
