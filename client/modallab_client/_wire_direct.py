"""JSON and npz to what updating methods find that do not iterate; pure."""

from modallab_client import direct
from modallab_client._wire import Arrays, Json, floats, texts

MATRICES = ("mass", "stiffness", "mass_error", "stiffness_error", "force_balance")


def findings(data: Json) -> direct.DirectFindings:
    """Return what a direct method found."""
    return direct.DirectFindings(
        method=data["method"],
        completion=data["completion"],
        n_dofs=int(data["n_dofs"]),
        n_modes=int(data["n_modes"]),
        reproduced=data.get("reproduced"),
        connectivity_loss=dict(data.get("connectivity_loss") or {}),
        other_modes=_others(data.get("other_modes")),
        dof_errors={
            matrix: {one["dof"]: float(one["error"]) for one in ranked}
            for matrix, ranked in data["dof_errors"].items()
        },
        notes=texts(data.get("notes") or ()),
    )


def _others(data: Json | None) -> direct.OtherModes | None:
    if not data:
        return None
    before, after, mac = (floats(data[name]) for name in ("before", "after", "mac"))
    return direct.OtherModes(before, after, mac, data.get("rigid_body"))


def matrices(given: Arrays) -> direct.UpdatedMatrices:
    """Return the matrices of a direct method."""
    return direct.UpdatedMatrices(texts(given["dofs"]), **{name: given.get(name) for name in MATRICES})


def suspects(data: Json) -> direct.Suspects:
    """Return what error location by one step found."""
    changes, weights = (
        {part: {int(n): float(x) for n, x in table.items()} for part, table in data[name].items()}
        for name in ("changes", "weights")
    )
    return direct.Suspects(data["method"], changes, weights, floats(data.get("remaining") or ()))
