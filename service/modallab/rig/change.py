"""Changes between a first and a further test of one structure, and the log book they imply."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.place import EffectSpec
from modallab.rig.compatibility import check_compatible
from modallab.rig.effect import build
from modallab.rig.effects_in_other_test import effects_in_other_test
from modallab.rig.hardware import Exciter, ForceTransducer
from modallab.rig.settings import CHANGE
from modallab.rig.setup import RigSetup

SENSORS = "sensors"
_DEFAULT_SIGNALS = {"shaker": "periodic_random", "hammer": "impact"}


@dataclass(frozen=True)
class AddedMass:
    """A known mass added for one test."""

    mass: float
    """kg, added mass."""
    at: Dof | None = None
    """Place of the mass; None: on every accelerometer, and it moves with it."""

    def __post_init__(self) -> None:
        if not 0 < self.mass <= CHANGE.max_mass:  # NaN fails too
            raise InvalidInputError(
                "an added mass weighs something",
                field="added_mass.mass",
                value=self.mass,
                allowed=bounds(exclusive_minimum=0, maximum=CHANGE.max_mass, unit="kg"),
            )


@dataclass(frozen=True)
class Change:
    """Differences from the first test; None or empty: no change."""

    level_factor: float | None = None  # on the rms of the source
    averages_factor: float | None = None
    n_lines: int | None = None
    frequency_max: float | None = None  # Hz
    window: str | None = None
    excitation: str | None = None
    exciter: str | None = None  # shaker or hammer
    drive: Dof | None = None
    responses: tuple[Dof, ...] = ()
    added_mass: AddedMass | None = None

    def __post_init__(self) -> None:
        for name in ("level_factor", "averages_factor"):
            value = getattr(self, name)
            if value is not None and not CHANGE.min_factor <= value <= CHANGE.max_factor:
                raise InvalidInputError(
                    f"{name} is out of bounds",
                    field=f"changed.{name}",
                    value=value,
                    allowed=bounds(CHANGE.min_factor, CHANGE.max_factor),
                )
        if self.exciter not in (None, *_DEFAULT_SIGNALS):
            raise InvalidInputError(
                f"no exciter called {self.exciter!r}",
                field="changed.exciter",
                value=str(self.exciter),
                allowed=list(_DEFAULT_SIGNALS),
            )

    @property
    def plain(self) -> dict[str, Any]:
        """The differences by name, as JSON."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {name: _plain(value) for name, value in values.items() if value not in (None, ())}

    @classmethod
    def read(cls, plain: Mapping[str, Any]) -> "Change":
        """Return the change from its JSON form.

        Raises
        ------
        InvalidInputError
            If it names what cannot be changed, or a value has no meaning.
        """
        names = {entry.name for entry in fields(cls)}
        for name in plain:
            if name not in names:
                raise InvalidInputError(
                    f"a further test cannot change {name!r}",
                    field="changed",
                    value=name,
                    allowed=sorted(names),
                )
        values: dict[str, Any] = dict(plain)
        if drive := values.get("drive"):
            values["drive"] = Dof.parse(drive, field="changed.drive")
        values["responses"] = tuple(
            Dof.parse(text, field="changed.responses") for text in values.get("responses") or ()
        )
        if mass := values.get("added_mass"):
            at = mass.get("at", SENSORS)
            place = None if at == SENSORS else Dof.parse(at, field="changed.added_mass.at")
            values["added_mass"] = AddedMass(float(mass["mass"]), place)
        return cls(**values)

    def applied(self, setup: RigSetup) -> RigSetup:
        """Return the log book of the first test with the changes applied.

        Raises
        ------
        InvalidInputError
            If the rig cannot do it.
        """
        values, changed = self.plain, setup
        for name in _SETTERS:  # in this order: another exciter brings its own settings
            if name in values:
                changed = _SETTERS[name](changed, self)
        check_compatible(changed)
        return _with_its_effects(changed, setup)

    def agreed(self, declared: RigSetup, first: RigSetup) -> RigSetup:
        """Return the further test's own log book, completed by the changes that it lacks.

        Parameters
        ----------
        declared
            As the further test came with it; it may be the first one's, if nobody wrote a new one.
        first
            The log book of the first test.

        Raises
        ------
        InvalidInputError
            If it says something else than the change does.
        """
        values = self.plain
        for name in (field for field in _SETTERS if field in values):
            only = Change(**{name: getattr(self, name)})
            expected, current = _GETTERS[name](only.applied(first), self), _GETTERS[name](declared, self)
            if _equal(current, expected):
                continue
            if current is None:  # nobody declared it for the further test
                declared = _COMPLETIONS[name](declared, expected)
                continue
            if not _equal(current, _GETTERS[name](first, self)):
                raise InvalidInputError(
                    f"the log book of the further test contradicts what is said to have been changed: {name}",
                    field=f"changed.{name}",
                    value=str(current),
                    allowed=str(expected),
                )
            declared = _SETTERS[name](declared, self)
        check_compatible(declared)
        return _with_its_effects(declared, first)


def _plain(value: Any) -> Any:
    if isinstance(value, AddedMass):
        return {"at": SENSORS if value.at is None else str(value.at), "mass": value.mass}
    if isinstance(value, Dof):
        return str(value)
    return [str(dof) for dof in value] if isinstance(value, tuple) else value


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return bool(np.isclose(a, b, rtol=CHANGE.relative_tolerance, atol=0.0))
    return bool(a == b)


def _with_its_effects(setup: RigSetup, first: RigSetup) -> RigSetup:
    """Return the log book with only those declared effects that carry over from the first test."""
    declared = [build(spec) for spec in setup.effects]
    return replace(
        setup, effects=tuple(effect.spec for effect in effects_in_other_test(declared, first, setup))
    )


def _with_analyser(setup: RigSetup, **values: Any) -> RigSetup:
    return replace(setup, analyser=replace(setup.analyser, **values))


def _with_excitation(setup: RigSetup, **values: Any) -> RigSetup:
    return _with_analyser(setup, excitation=replace(setup.analyser.excitation, **values))


def _with_exciter(setup: RigSetup, change: Change) -> RigSetup:
    """Return the rig with another kind of exciter, without the first one's hardware."""
    if change.exciter == setup.exciter.kind or change.exciter is None:
        return setup
    hammer = change.exciter == "hammer"
    bare = replace(
        setup,
        exciter=Exciter("hammer" if hammer else "shaker"),
        stinger=None,
        force_transducer=ForceTransducer(),
    )
    # A shaker's window cuts nothing off; what a blow leaves of it would.
    return _with_excitation(_with_analyser(bare, window="rectangular"), kind=_DEFAULT_SIGNALS[change.exciter])


def _with_added_mass(setup: RigSetup, change: Change) -> RigSetup:
    added = change.added_mass
    assert added is not None
    if added.at is None:
        sensors = setup.accelerometers
        return replace(setup, accelerometers=replace(sensors, mass=sensors.mass + added.mass))
    return replace(setup, effects=(*setup.effects, _mass_effect(added)))


def _mass_effect(added: AddedMass) -> EffectSpec:
    assert added.at is not None
    return EffectSpec("extra_mass", added.at.point, {"mass": added.mass})


def _declared_mass(setup: RigSetup, change: Change) -> float:
    """Return the mass that a log book declares at the place of the added mass, kg."""
    added = change.added_mass
    assert added is not None
    if added.at is None:
        return setup.accelerometers.mass
    masses = [spec for spec in setup.effects if spec.kind == "extra_mass" and spec.at == added.at.point]
    return sum(spec.parameters["mass"] for spec in masses)


_SETTERS: Mapping[str, Callable[[RigSetup, Change], RigSetup]] = {
    "exciter": _with_exciter,
    "level_factor": lambda s, c: _with_excitation(s, level=s.analyser.source_level * (c.level_factor or 1.0)),
    "averages_factor": lambda s, c: _with_analyser(
        s, averages=max(1, round(s.analyser.simulated_averages * (c.averages_factor or 1.0)))
    ),
    "n_lines": lambda s, c: _with_analyser(s, n_lines=c.n_lines),
    "frequency_max": lambda s, c: _with_analyser(s, frequency_max=c.frequency_max),
    "window": lambda s, c: _with_analyser(s, window=c.window),
    "excitation": lambda s, c: _with_excitation(s, kind=c.excitation),
    "drive": lambda s, c: replace(s, drives=s.drives if c.drive is None else (c.drive,)),
    "responses": lambda s, c: replace(s, responses=c.responses),
    "added_mass": _with_added_mass,
}
_GETTERS: Mapping[str, Callable[[RigSetup, Change], Any]] = {
    "exciter": lambda s, _: s.exciter.kind,
    "level_factor": lambda s, _: s.analyser.excitation.level,
    "averages_factor": lambda s, _: s.analyser.averages,
    "n_lines": lambda s, _: s.analyser.n_lines,
    "frequency_max": lambda s, _: s.analyser.frequency_max,
    "window": lambda s, _: s.analyser.window,
    "excitation": lambda s, _: s.analyser.excitation.kind,
    "drive": lambda s, _: ", ".join(map(str, s.drives)),
    "responses": lambda s, _: ", ".join(map(str, s.responses)),
    "added_mass": _declared_mass,
}
_COMPLETIONS: Mapping[str, Callable[[RigSetup, Any], RigSetup]] = {
    "level_factor": lambda s, level: _with_excitation(s, level=level),
    "averages_factor": lambda s, averages: _with_analyser(s, averages=averages),
}
