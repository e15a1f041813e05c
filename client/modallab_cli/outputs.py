"""What a command leaves behind: lines on stdout, files, pictures."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from modallab_client import Measurement, ModalLab, ModalModel
from modallab_client.errors import MissingExtraError

# Names of things that end with the command.
_PASSING = ("id", "created", "made_from", "structure_id", "rig_id", "measurement_id", "modal_model_id")


def print_reply(lab: ModalLab, path: str, *, stays: bool) -> None:
    """Print the reply of the lab as JSON, without ids where the lab ends with the command."""
    reply: Mapping[str, Any] = lab.request("GET", path)
    kept = {name: value for name, value in reply.items() if stays or name not in _PASSING}
    click.echo(json.dumps(kept, indent=2, ensure_ascii=False))


def check_pictures(picture: Path | None) -> None:
    """Raise `MissingExtraError` if a picture is wanted and nothing can draw it, before the work."""
    if picture is None:
        return
    try:
        import matplotlib
    except ImportError:
        raise MissingExtraError("a picture needs matplotlib: pip install 'modallab[plot]'") from None
    matplotlib.use("agg")  # no window, wherever the command runs


def draw(result: Any, picture: Path | None, *beside: Any) -> None:
    """Write the picture of a result, if one is wanted.

    Parameters
    ----------
    beside
        What the result is drawn with.
    """
    if picture is None:
        return
    axes = result.plot(*beside)
    first = axes[0] if isinstance(axes, tuple) else axes
    first.figure.savefig(picture, dpi=150)
    click.echo(f"The picture: {picture.resolve()}", err=True)


def write_frfs(lab: ModalLab, test: Measurement, out: Path) -> None:
    """Write FRFs in the format that the ending names."""
    content: dict[str, Callable[[], bytes]] = {
        ".uff": lambda: lab.measurements.uff(test.id),
        ".npz": lambda: lab.request("GET", f"/v1/measurements/{test.id}/arrays"),
        ".h5": lambda: lab.measurements.hdf5(test.id),
        ".frf": lambda: lab.measurements.thesis(test.id, decimals=16),
    }
    names = {".unv": ".uff", ".hdf5": ".h5"}
    ending = out.suffix.lower()
    out.write_bytes(content[names.get(ending, ending)]())


def write_modes(lab: ModalLab, model: ModalModel, out: Path) -> None:
    """Write modes as a universal file, or as a body of `POST /v1/modal-models/import`."""
    if out.suffix.lower() != ".json":
        out.write_bytes(lab.modal_models.uff(model.id))
        return
    modes = [
        {
            "frequency": mode.frequency,
            "loss_factor": mode.loss_factor,
            "shape": [[float(entry.real), float(entry.imag)] for entry in shape],
        }
        for mode, shape in zip(model.modes, model.shapes.T, strict=True)
    ]
    body = {"modes": modes, "dofs": list(model.dofs), "normalisation": model.normalisation}
    out.write_text(json.dumps(body, indent=1), encoding="utf-8")
