"""Example of each effect; an effect without an entry is shown on the free beam, at one of its places."""

from docs.gallery.example import Example, structure
from modallab.core.dof import Dof
from modallab.core.place import Channels, Dofs, Members, Place
from modallab.fe.assembly import assemble
from modallab.rig.effect import EFFECTS, Stage
from modallab.rig.setup import RigSetup

TIP = {"drive": "6:+Y", "responses": ["21:+Y"]}
ARMATURE = {"exciter": {"armature_mass": 0.02}}
MODES = (250.0, 500.0)  # the fifth and the sixth of the free beam

STRUCTURE = {
    "extra_mass": Example(
        at="11:+Y",
        band=MODES,
        shows="50 g at mid-span: the fifth frequency falls; the sixth mode has a node there and does not"
        " change.",
    ),
    "density_error": Example(
        at={"members": [9, 10, 11, 12]},
        shows="Four heavy members of twenty at mid-span: frequencies of modes that move there fall most.",
    ),
    "stiffness_error": Example(
        at={"members": [9, 10, 11, 12]},
        shows="Four stiff members of twenty at mid-span: all frequencies rise, most for modes that bend"
        " there.",
    ),
    "loss_factor_error": Example(
        band=MODES,
        shows="Twice the loss factor: peaks are half as high and twice as broad; frequencies do not change.",
    ),
    "local_damping": Example(
        at="11:+Y",
        band=(15.0, 75.0),
        shows="A damper at mid-span damps the first mode; the second has a node there.",
    ),
    "damping_law": Example(
        shows="Half of the damping is viscous: peaks above 150 Hz are lower, those below it higher.",
    ),
    "attached_oscillator": Example(
        at="11:+Y",
        band=(0.0, 250.0),
        shows="50 g on a spring at 100 Hz: its own resonance beside those of the beam.",
    ),
    "tabulated_stiffness": Example(
        at="11:+Y",
        band=(0.0, 150.0),
        shows="A part at mid-span whose stiffness rises from 10 to 20 kN/m and whose loss rises with it.",
    ),
    "ground_spring": Example(
        at="11:+Y",
        band=(0.0, 150.0),
        shows="A spring at mid-span, on which the free beam bounces: low frequencies rise, high ones change"
        " little.",
    ),
    "rotational_ground_spring": Example(
        at="1:+RZ",
        parameters={"stiffness": 500.0},
        band=(0.0, 150.0),
        shows="A spring restrains the rotation of the driven end: the rigid-body rotation becomes a"
        " resonance, and low frequencies rise.",
    ),
    "elastic_support": Example(
        structure="clamped beam",
        rig=TIP,
        at="1:+Y",
        parameters={"flexibility": 2e-6},
        band=(0.0, 250.0),
        shows="The clamp yields along Y by 2 micrometres per newton: high frequencies fall most, as the"
        " reaction of a mode grows with its frequency.",
    ),
    "rotational_elastic_support": Example(
        structure="clamped beam",
        rig=TIP,
        at="1:+RZ",
        parameters={"flexibility": 3e-4},
        band=(0.0, 250.0),
        shows="The clamp turns by 0.3 mrad per newton metre: all frequencies fall, the lowest by the largest"
        " share.",
    ),
    "joint_flexibility": Example(
        at="8:+RZ",
        band=MODES,
        shows="A flexible joint at node 8 lowers the frequencies of modes that bend there, and no others.",
    ),
    "shear_and_rotary_inertia": Example(
        structure="short beam",
        band=(0.0, 8000.0),
        shows="Short bar: high frequencies fall, in proportion to the square of the order.",
    ),
    "cubic_stiffness": Example(
        structure="damped beam",
        rig={"drive": "11:+Y", "responses": ["21:+Y"]},
        at="11:+Y",
        levels=(0.5, 5.0),
        panels=("magnitude", "coherence"),
        band=(2.0, 50.0),
        shows="The first resonance rises with the level; coherence falls there and at three times its"
        " frequency.",
    ),
    "friction": Example(
        structure="clamped beam",
        rig=TIP,
        at="21:+Y",
        levels=(0.2, 2.0),
        panels=("magnitude", "coherence"),
        band=(2.0, 150.0),
        shows="At a low level friction holds the free end; at a high level it has little influence.",
    ),
    "rattle": Example(
        structure="clamped beam",
        rig=TIP,
        at="21:+Y",
        levels=(0.005, 1.0),
        panels=("magnitude", "coherence"),
        band=(2.0, 100.0),
        shows="Motion within the gap is not affected; larger motion strikes the stops, which stiffen the"
        " beam, and coherence falls.",
    ),
    "drift": Example(
        rig={"responses": ["1:+Y", "11:+Y", "21:+Y"], "accelerometers": {"roving": True}},
        band=(300.0, 330.0),
        panels=("magnitude 1:+Y", "magnitude 11:+Y", "magnitude 21:+Y"),
        shows="The beam is one per cent softer in the last run than in the first: natural frequencies"
        " differ between FRFs.",
    ),
}
EXCITER = {
    "exciter_armature": Example(
        panels=("magnitude", "force"),
        shows="The FRF does not change; the force spectrum has a dip at every resonance.",
    ),
    "exciter_suspension": Example(
        rig=ARMATURE,
        band=(1.0, 100.0),
        panels=("magnitude", "force"),
        shows="The FRF does not change; the beam bounces on the suspension, and below that the force is"
        " small.",
    ),
    "exciter_coil": Example(
        rig=ARMATURE,
        panels=("magnitude", "force"),
        shows="The FRF does not change; induced voltage reduces the force where the velocity is high.",
    ),
    "stinger_axial": Example(
        rig=ARMATURE,
        band=(0.0, 3000.0),
        panels=("magnitude", "force"),
        shows="The FRF does not change; the armature resonates at 1.6 kHz, and above that the force is"
        " small.",
    ),
    "stinger_bending": Example(
        structure="frame",
        rig={"drive": "13:+Y", "responses": ["10:+Y"]},
        band=(2.0, 200.0),
        shows="Lateral motion and rotation are restrained: frequencies rise, and mass cancellation has no"
        " influence.",
    ),
    "stinger_mass": Example(
        parameters={"mass": 0.01},
        panels=("magnitude", "force"),
        shows="10 g behind the sensing element: the FRF does not change, the force decreases.",
    ),
    "cancelled_mass": Example(
        panels=("magnitude", "force"),
        shows="The FRF is that of the structure alone; the source still moves the mass.",
    ),
    "double_hit": Example(
        rig={"exciter": {"kind": "hammer"}, "analyser": {"window": "force_exponential"}},
        band=(0.0, 200.0),
        panels=("magnitude", "force", "response"),
        shows="A second blow 20 ms later: ripples of 50 Hz in force and response; the FRF does not change.",
    ),
}
TRANSDUCERS = {
    "accelerometer_mass": Example(
        rig={"responses": ["1:+Y", "8:+Y"], "accelerometers": {"roving": True}},
        band=MODES,
        panels=("magnitude 1:+Y", "magnitude 8:+Y"),
        shows="The shift of a frequency depends on the position: largest at the free end, 0 at nodes of"
        " the mode.",
    ),
    "cable_mass": Example(
        rig={"responses": [f"{node}:+Y" for node in range(1, 22, 2)]},
        band=MODES,
        panels=("magnitude 1:+Y",),
        shows="Eleven cables of 5 g: frequencies fall as with heavier accelerometers, and peaks are lower.",
    ),
    "force_transducer_mass": Example(
        rig={"responses": ["1:+Y"]},
        band=MODES,
        shows="10 g, not cancelled: frequencies fall; antiresonances of the drive point do not change.",
    ),
    "force_transducer_stiffness": Example(
        structure="short beam",
        rig={"exciter": {"armature_mass": 0.2}},
        band=(0.0, 8000.0),
        panels=("magnitude", "force"),
        shows="The FRF does not change; armature and beam resonate at some kHz, and above that the force"
        " is small.",
    ),
    "mounted_resonance": Example(
        structure="short beam",
        band=(0.0, 10000.0),
        panels=("magnitude", "ratio"),
        shows="Magnet with 7 kHz: the reading is 1/8 too large at 2.3 kHz, and 20 times too large at 7 kHz.",
    ),
    "transverse_sensitivity": Example(
        structure="frame",
        rig={"drive": "13:+Y", "responses": ["9:+Y"]},
        band=(0.0, 300.0),
        panels=("magnitude", "ratio"),
        shows="3 % of the motion along X is measured as motion along Y: antiresonances move.",
    ),
    "gain_error": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "ratio"),
        shows="10 % or 0.83 dB too high at every line; frequencies and damping do not change.",
    ),
    "integrated_response": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "turn"),
        shows="Velocity in place of acceleration: the magnitude falls by 20 dB a decade, and every line lags"
        " by 90 degrees.",
    ),
    "polarity": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "phase"),
        shows="A phase error of 180 degrees at every line; magnitudes do not change.",
    ),
    "swapped_channels": Example(
        rig={"responses": ["4:+Y", "16:+Y"]},
        at={"channels": ["4:+Y", "16:+Y"]},
        band=(0.0, 350.0),
        panels=("magnitude 4:+Y", "magnitude 16:+Y"),
        shows="Each FRF is correct, but has the name of the other.",
    ),
    "misplaced_accelerometer": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "ratio"),
        shows="The accelerometer is one centimetre beside its node: antiresonances move, most at high"
        " frequency.",
    ),
}
ANALYSER = {
    "channel_delay": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "turn"),
        shows="The phase error is proportional to frequency; magnitudes do not change.",
    ),
    "ac_coupling": Example(
        at={"channels": ["7:+Y"]},
        band=(0.2, 20.0),
        panels=("magnitude", "turn"),
        shows="High-pass of one channel at 1 Hz: the phase is wrong far above it, the magnitude only near"
        " it.",
    ),
    "leakage": Example(
        panels=("magnitude", "coherence"),
        shows="A tenth of the power leaks: leakage into antiresonances is incoherent.",
    ),
    "quantisation": Example(
        panels=("magnitude", "coherence", "response"),
        shows="With 8 bits the spectra have a noise floor; coherence falls where a spectrum is near it.",
    ),
    "overload": Example(
        panels=("magnitude", "coherence", "response"),
        shows="Clipped peaks cause a noise floor, far above that of rounding.",
    ),
}
NOISE = {
    "response_noise": Example(
        panels=("magnitude", "coherence"),
        shows="Coherence falls where the response is small, between resonances. H1 stays correct.",
    ),
    "force_noise": Example(
        rig={"exciter": {"armature_mass": 0.1}},
        panels=("magnitude", "coherence", "force"),
        shows="Coherence falls where the force is small, at resonances, and H1 is too small there.",
    ),
    "mains_hum": Example(
        band=(0.0, 400.0),
        panels=("magnitude", "coherence", "response"),
        shows="Coherence has dips at 50, 150, 250 and 350 Hz; the response spectrum has a peak at 50 Hz.",
    ),
}
GROUPS = {
    "Structure": STRUCTURE,
    "Exciter and stinger": EXCITER,
    "Transducers": TRANSDUCERS,
    "Analyser": ANALYSER,
    "Noise": NOISE,
}
STRUCTURE["suspension"] = Example(
    at="1:+Y",
    declared={"suspension": {"at": ["1:+Y", "21:+Y"], "stiffness": 100.0, "loss_factor": 0.05}},
    band=(0.2, 40.0),
    shows="Two elastic cords: rigid-body modes at 0.9 and 1.6 Hz; the first elastic mode does not change.",
)


def example_of(kind: str) -> Example:
    """Return how an effect is shown."""
    for group in GROUPS.values():
        if kind in group:
            return group[kind]
    return _plain(kind)


def group_of(kind: str) -> str:
    """Return the heading that an effect stands under."""
    for name, group in GROUPS.items():
        if kind in group:
            return name
    cls = EFFECTS[kind]
    if cls.structural:
        return "Structure"
    if cls.at_drive and cls.stage <= Stage.DRIVE:
        return "Exciter and stinger"
    return "Transducers" if cls.stage <= Stage.CHANNEL else "Analyser"


def _plain(kind: str) -> Example:
    """Return the free beam with the effect at its defaults: everywhere, or midway among its places."""
    setup = RigSetup((Dof(1, "Y"),), (Dof(7, "Y"),))
    places = EFFECTS[kind].places(assemble(structure("free beam")), setup)
    if not places or None in places:
        return Example()
    return Example(at=_written(places[len(places) // 2]))


def _written(place: Place) -> object:
    if isinstance(place, Members):
        return {"members": list(place.numbers)}
    if isinstance(place, Dofs):
        return {"dofs": [str(dof) for dof in place.dofs]}
    if isinstance(place, Channels):
        return {"channels": [str(dof) for dof in place.dofs]}
    return place if place is None else str(place)
