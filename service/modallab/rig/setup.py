"""Rig as declared in the log book."""

from dataclasses import dataclass, field, replace

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.place import EffectSpec
from modallab.estimation.averaging import effective_averages
from modallab.estimation.estimator import MULTIPLE_INPUT_ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.fe.point_translations import Point
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise, NoiseDensity
from modallab.rig.stinger import Stinger
from modallab.rig.suspension import Suspension


@dataclass(frozen=True)
class AcquisitionRun:
    """Drive points and responses of one run of the analyser."""

    drives: tuple[Dof, ...]
    """Simultaneously driven DoFs."""
    outputs: tuple[Dof, ...]
    """Measured response DoFs."""
    elapsed: float = 0.0
    """1, share of the test before this run: 0 for the first, 1 for the last."""
    displaced_accelerometers: tuple[tuple[int, Point], ...] = ()
    """Declared node and true point of each accelerometer that is not where it should be."""
    accelerometer_mass: float = 0.0
    """kg, declared mass of each accelerometer."""

    @property
    def accelerometer_points(self) -> list[Point]:
        """The points of the accelerometers, one for each node of the responses."""
        points = dict(self.displaced_accelerometers)
        return [points.get(node, (node, 0.0)) for node in sorted({dof.node for dof in self.outputs})]

    @property
    def drive(self) -> Dof:
        """The first drive point."""
        return self.drives[0]


@dataclass(frozen=True)
class RigSetup:
    """A rig as declared; parts that are not declared are ideal.

    Several shakers drive at the same time; a hammer strikes one drive point after the other.
    """

    drives: tuple[Dof, ...]
    """Drive points."""
    responses: tuple[Dof, ...]
    """Response DoFs."""
    exciter: Exciter = field(default_factory=Exciter)
    """Shaker or hammer."""
    stinger: Stinger | None = None
    """Stinger; None: rigid and without mass."""
    force_transducer: ForceTransducer = field(default_factory=ForceTransducer)
    """Force transducer at the drive point."""
    accelerometers: Accelerometers = field(default_factory=Accelerometers)
    """Response transducers."""
    analyser: Analyser = field(default_factory=Analyser)
    """Analyser settings."""
    noise: Noise = field(default_factory=Noise)
    """White noise of the channels."""
    suspension: Suspension = field(default_factory=Suspension)
    """Elastic suspension of the structure."""
    effects: tuple[EffectSpec, ...] = ()
    """Further declared effects."""

    def __post_init__(self) -> None:
        for dofs, name, part in (
            (self.drives, "drive" if len(self.drives) == 1 else "drives", "a drive point"),
            (self.responses, "responses", "a response"),
        ):
            if not dofs:
                raise InvalidInputError(f"a rig needs {part}", field=name, allowed="one DoF or more")
            points = [dof.point for dof in dofs]
            if twice := [str(point) for point in dict.fromkeys(points) if points.count(point) > 1]:
                raise InvalidInputError(
                    f"{part} is named twice", field=name, value=twice, allowed="each once, whatever its sense"
                )
            for dof in dofs:
                if not dof.translational:
                    raise InvalidInputError(
                        f"{dof} is a rotation: a force and an accelerometer act along X, Y or Z",
                        field=name,
                        value=str(dof),
                        allowed=["X", "Y", "Z"],
                    )
        if self.n_simultaneous > 1:
            self._check_told_apart()

    def _check_told_apart(self) -> None:
        """Raise unless the estimator can separate simultaneous forces."""
        analyser, n_in = self.analyser, len(self.drives)
        if analyser.estimator not in MULTIPLE_INPUT_ESTIMATORS:
            raise InvalidInputError(
                f"{analyser.estimator} is defined for one force, and {n_in} act at once",
                field="estimator",
                value=analyser.estimator,
                allowed=list(MULTIPLE_INPUT_ESTIMATORS),
            )
        worth = effective_averages(analyser.simulated_averages, analyser.overlap, WINDOWS[analyser.window])
        if worth < n_in:
            raise InvalidInputError(
                "too few averages to separate simultaneous forces",
                field="averages",
                value=round(worth, 2),
                allowed=bounds(n_in, unit="independent records"),
            )

    @property
    def n_simultaneous(self) -> int:
        """Number of forces that act at the same time."""
        return 1 if self.exciter.kind == "hammer" else len(self.drives)

    @property
    def roving_hammer(self) -> bool:
        """Whether a hammer strikes several drive points, one after the other."""
        return self.exciter.kind == "hammer" and len(self.drives) > 1

    @property
    def simulated(self) -> "RigSetup":
        """The rig of a simulated test: what is unknown has its ideal value."""
        analyser, noise = self.analyser, self.noise
        source = replace(analyser.excitation, level=analyser.source_level, shape="flat")
        return replace(
            self,
            analyser=replace(analyser, averages=analyser.simulated_averages, excitation=source),
            noise=Noise(
                0.0 if noise.force is None else noise.force, 0.0 if noise.response is None else noise.response
            ),
        )

    def check_noise_channels(self) -> None:
        """Raise `InvalidInputError` unless noise by channel is stated for each channel of its side."""
        sides = (("force", self.noise.force, self.drives), ("response", self.noise.response, self.responses))
        for name, level, dofs in sides:
            if isinstance(level, NoiseDensity):
                level.check_channels(f"noise.{name}.psd", dofs)

    @property
    def drive(self) -> Dof:
        """The first drive point."""
        return self.drives[0]

    @property
    def baseband(self) -> "RigSetup":
        """The rig with an analyser whose lines start at 0 Hz, see `Analyser.baseband`."""
        return self if self.analyser.frequency_min == 0 else replace(self, analyser=self.analyser.baseband)

    @property
    def acquisition_runs(self) -> tuple[AcquisitionRun, ...]:
        """The runs of the test.

        One for each position of what roves: of the accelerometer, of the hammer, or of both.
        """
        roving = self.accelerometers.roving
        outputs = [(response,) for response in self.responses] if roving else [self.responses]
        drives = [(drive,) for drive in self.drives] if self.exciter.kind == "hammer" else [self.drives]
        runs = [(d, o) for d in drives for o in outputs]
        last = max(len(runs) - 1, 1)
        mass = self.accelerometers.mass
        return tuple(AcquisitionRun(d, o, i / last, accelerometer_mass=mass) for i, (d, o) in enumerate(runs))
