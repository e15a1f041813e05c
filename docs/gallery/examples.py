"""How each effect is shown; one without an entry is shown on the free beam, where it could sit."""

from docs.gallery.example import Example, structure
from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
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
        shows="50 g in mid-span: the fifth mode moves there and falls, the sixth has a node there and stays.",
    ),
    "density_error": Example(
        at={"members": [9, 10, 11, 12]},
        shows="Four heavy members of twenty at mid-span: frequencies of modes that move there fall most.",
    ),
    "stiffness_error": Example(
        at={"members": [9, 10, 11, 12]},
        shows="Four stiff members of twenty in mid-span: every mode rises, those that bend there most.",
    ),
    "loss_factor_error": Example(
        band=MODES,
        shows="Twice the loss: peaks are half as high and twice as broad, frequencies stay.",
    ),
    "local_damping": Example(
        at="11:+Y",
        band=(15.0, 75.0),
        shows="A damper in mid-span takes from the first mode; the second has a node there.",
    ),
    "damping_law": Example(
        shows="Half of the loss viscous: peaks above 150 Hz are lower, those below it higher.",
    ),
    "attached_oscillator": Example(
        at="11:+Y",
        band=(0.0, 250.0),
        shows="50 g on a spring at 100 Hz: its own resonance beside those of the beam.",
    ),
    "ground_spring": Example(
        at="11:+Y",
        band=(0.0, 150.0),
        shows="A spring under mid-span: the free beam bounces on it, low modes rise, high ones hardly.",
    ),
    "rotational_ground_spring": Example(
        at="1:+RZ",
        parameters={"stiffness": 500.0},
        band=(0.0, 150.0),
        shows="The driven end is held in rotation: the rigid rotation becomes a resonance, low modes rise.",
    ),
    "joint_flexibility": Example(
        at="8:+RZ",
        band=MODES,
        shows="A slack joint at node 8 lowers modes that bend there and leaves those that do not.",
    ),
    "shear_and_rotary_inertia": Example(
        structure="short beam",
        band=(0.0, 8000.0),
        shows="Of a short bar the high modes fall, in proportion to the square of their order.",
    ),
    "cubic_stiffness": Example(
        structure="damped beam",
        rig={"drive": "11:+Y", "responses": ["21:+Y"]},
        at="11:+Y",
        levels=(0.5, 5.0),
        panels=("magnitude", "coherence"),
        band=(2.0, 50.0),
        shows="The first resonance rises with the level; coherence falls there and at three times that.",
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
        shows="Within the gap nothing happens; beyond it the stops stiffen the beam and coherence falls.",
    ),
    "drift": Example(
        rig={"responses": ["1:+Y", "11:+Y", "21:+Y"], "accelerometers": {"roving": True}},
        band=(300.0, 330.0),
        panels=("magnitude 1:+Y", "magnitude 11:+Y", "magnitude 21:+Y"),
        shows="The first run sees the beam as it was, the last one a per cent softer: no common frequency.",
    ),
}
EXCITER = {
    "exciter_armature": Example(
        panels=("magnitude", "force"),
        shows="The FRF stays; the force drops out at every resonance.",
    ),
    "exciter_suspension": Example(
        rig=ARMATURE,
        band=(1.0, 100.0),
        panels=("magnitude", "force"),
        shows="The FRF stays; the beam bounces on the armature's suspension, and below that force is lost.",
    ),
    "exciter_coil": Example(
        rig=ARMATURE,
        panels=("magnitude", "force"),
        shows="The FRF stays; the voltage that motion induces takes force where the drive point moves fast.",
    ),
    "stinger_axial": Example(
        rig=ARMATURE,
        band=(0.0, 3000.0),
        panels=("magnitude", "force"),
        shows="The FRF stays; the armature resonates on the stinger at 1.6 kHz, above it the force is gone.",
    ),
    "stinger_bending": Example(
        structure="frame",
        rig={"drive": "13:+Y", "responses": ["10:+Y"]},
        band=(2.0, 200.0),
        shows="The drive point moves less across and turns less: modes rise, and no mass cancellation helps.",
    ),
    "stinger_mass": Example(
        parameters={"mass": 0.01},
        panels=("magnitude", "force"),
        shows="A stinger of 10 g moves behind the gauge's sensing element: the FRF stays, force is lost.",
    ),
    "cancelled_mass": Example(
        panels=("magnitude", "force"),
        shows="The FRF is that of the bare structure; the source has to move the mass all the same.",
    ),
    "double_hit": Example(
        rig={"exciter": {"kind": "hammer"}, "analyser": {"window": "force_exponential"}},
        band=(0.0, 200.0),
        panels=("magnitude", "force", "response"),
        shows="A second blow 20 ms later: force and response ripple every 50 Hz, the FRF stays.",
    ),
}
TRANSDUCERS = {
    "accelerometer_mass": Example(
        rig={"responses": ["1:+Y", "8:+Y"], "accelerometers": {"roving": True}},
        band=MODES,
        panels=("magnitude 1:+Y", "magnitude 8:+Y"),
        shows="Each position shifts the modes by its own amount: most at the free end, least at their nodes.",
    ),
    "cable_mass": Example(
        rig={"responses": [f"{node}:+Y" for node in range(1, 22, 2)]},
        band=MODES,
        panels=("magnitude 1:+Y",),
        shows="Eleven cables of 5 g: modes fall as with heavier accelerometers, and lose height beside it.",
    ),
    "force_transducer_mass": Example(
        rig={"responses": ["1:+Y"]},
        band=MODES,
        shows="10 g below the gauge, not cancelled: frequencies fall, the drive point's antiresonances stay.",
    ),
    "force_transducer_stiffness": Example(
        structure="short beam",
        rig={"exciter": {"armature_mass": 0.2}},
        band=(0.0, 8000.0),
        panels=("magnitude", "force"),
        shows="The FRF stays; armature and beam resonate on the gauge in the kilohertz, then force is lost.",
    ),
    "mounted_resonance": Example(
        structure="short beam",
        band=(0.0, 10000.0),
        panels=("magnitude", "ratio"),
        shows="A magnet's 7 kHz: a third of the way the reading is an eighth too large, at 7 kHz 20 times.",
    ),
    "transverse_sensitivity": Example(
        structure="frame",
        rig={"drive": "13:+Y", "responses": ["9:+Y"]},
        band=(0.0, 300.0),
        panels=("magnitude", "ratio"),
        shows="3 % of the motion along X is heard as motion along Y: antiresonances move.",
    ),
    "gain_error": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "ratio"),
        shows="10 % too much at every line, 0.83 dB; frequencies and damping stay.",
    ),
    "polarity": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "phase"),
        shows="Half a turn of phase at every line; nothing else.",
    ),
    "swapped_channels": Example(
        rig={"responses": ["4:+Y", "16:+Y"]},
        at={"channels": ["4:+Y", "16:+Y"]},
        band=(0.0, 350.0),
        panels=("magnitude 4:+Y", "magnitude 16:+Y"),
        shows="Each FRF is right, under the other's name.",
    ),
    "misplaced_accelerometer": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "ratio"),
        shows="A centimetre off: antiresonances move, most of all at high frequency.",
    ),
}
ANALYSER = {
    "channel_delay": Example(
        at={"channels": ["7:+Y"]},
        panels=("magnitude", "turn"),
        shows="The phase error grows in proportion to frequency; sizes stay.",
    ),
    "ac_coupling": Example(
        at={"channels": ["7:+Y"]},
        band=(0.2, 20.0),
        panels=("magnitude", "turn"),
        shows="One channel's high-pass at 1 Hz: phase is wrong far above the corner, size only near it.",
    ),
    "leakage": Example(
        panels=("magnitude", "coherence"),
        shows="A tenth of the power leaks: what spills into the antiresonances is not coherent.",
    ),
    "quantisation": Example(
        panels=("magnitude", "coherence", "response"),
        shows="8 bits: a floor under the spectra, and coherence is lost where they come near it.",
    ),
    "overload": Example(
        panels=("magnitude", "coherence", "response"),
        shows="Clipped peaks put a floor under the spectra, far above a converter's own.",
    ),
}
NOISE = {
    "response_noise": Example(
        panels=("magnitude", "coherence"),
        shows="Coherence is lost where the response is small: between resonances. H1 stays right.",
    ),
    "force_noise": Example(
        rig={"exciter": {"armature_mass": 0.1}},
        panels=("magnitude", "coherence", "force"),
        shows="Coherence is lost where the force drops out, at resonances, and H1 is low there.",
    ),
    "mains_hum": Example(
        band=(0.0, 400.0),
        panels=("magnitude", "coherence", "response"),
        shows="50, 150, 250 and 350 Hz are missing in coherence; 50 Hz stands out of the response too.",
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
    shows="Two soft bands: rigid-body modes at 0.9 and 1.6 Hz, the first elastic mode stays.",
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
    if isinstance(place, Channels):
        return {"channels": [str(dof) for dof in place.dofs]}
    return place if place is None else str(place)
