"""Effects whose change of FRFs or of force spectra has a closed form."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.channel import Channel
from modallab.rig.effect import Effect
from modallab.rig.run import Run

HOOKS = tuple(name for name in vars(Effect) if name.startswith("on_"))
"""Methods by which an effect acts on a test."""


def changes_frfs_alone(effect: Effect) -> bool:
    """Return whether an effect acts on the structure and on channels alone."""
    return _hooks(effect) <= {"on_system", "on_channel"}


def filters_channels(effect: Effect) -> bool:
    """Return whether an effect acts on channels."""
    return "on_channel" in _hooks(effect)


def changes_drives_alone(effect: Effect) -> bool:
    """Return whether an effect acts on the exciters alone: not on FRFs."""
    return _hooks(effect) == {"on_drive"}


def _hooks(effect: Effect) -> set[str]:
    """Return the hooks by which an effect acts."""
    kind = type(effect)
    return {hook for hook in HOOKS if getattr(kind, hook) is not getattr(Effect, hook)}


def transfer_ratios(run: Run, variants: Sequence[Effect], omega: FloatArray) -> ComplexArray | None:
    """Return the ratios of FRFs with the filters that effects add to the channels of a run to those without.

    None where an effect changes what a channel picks up.

    Parameters
    ----------
    omega
        (n_lines,) rad/s.

    Returns
    -------
    (n_variants, n_lines, n_out) for the only force of the run.
    """
    ratios = np.ones((len(variants), len(omega), len(run.responses)), complex)
    for ratio, effect in zip(ratios, variants, strict=True):
        for channels in (run.responses, run.forces):
            for i, channel in enumerate(channels):
                changed = effect.on_channel(channel, run.system)
                if changed is channel:
                    continue
                if changed.pickups != channel.pickups or (channel.force and len(run.forces) > 1):
                    return None
                added = _added_transfer(channel, changed, omega)
                if channel.force:
                    ratio /= added[:, None]
                else:
                    ratio[:, i] *= added
    return ratios


def _added_transfer(channel: Channel, changed: Channel, omega: FloatArray) -> ComplexArray:
    """Return the product (n_lines,) of the filters that a channel has in addition."""
    added = Channel(channel.dof, filters=changed.filters[len(channel.filters) :])
    return added.transfer(omega)
