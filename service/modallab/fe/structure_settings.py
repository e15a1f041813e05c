"""Settings of structures and their elements."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class InputSettings(Settings):
    """Bounds of what a structure may be made of."""

    min_positive: float = setting(
        1e-30,
        unit="SI",
        doc="least positive property",
        derived="no beam is below, and products of properties do not vanish",
    )
    max_property: float = setting(
        1e30,
        unit="SI",
        doc="largest property",
        derived="no beam is above, and products of properties do not overflow",
    )
    max_coordinate: float = setting(
        1e9, unit="m", doc="largest coordinate of a node", derived="no structure is larger"
    )
    max_damping: float = setting(
        1e15,
        unit="SI",
        doc="largest damping coefficient",
        derived="far beyond any damping, and small enough to be computed with",
    )
    min_shear_coefficient: float = setting(
        0.01, doc="least shear coefficient of a section", derived="below that of any thin-walled section"
    )
    max_shear_coefficient: float = setting(
        1.0, doc="largest shear coefficient of a section", derived="the whole area shears"
    )
    min_poisson_ratio: float = setting(
        -0.99, doc="least Poisson ratio", derived="stability of an isotropic material: above -1"
    )
    max_poisson_ratio: float = setting(0.5, doc="largest Poisson ratio", derived="an incompressible material")
    min_length: float = setting(
        1e-9, unit="m", doc="least length of a bar", derived="rounding of coordinates of order one"
    )
    min_corner_area: float = setting(
        1e-6,
        doc="least cross product of adjacent sides of a plate, over its longest side squared",
        derived="rounding of coordinates read from text",
    )
    min_spatial_corner_area: float = setting(
        1e-9,
        doc="least area at a corner times the whole area, over the longest side to the fourth",
        derived="rounding of coordinates read from text",
    )
    min_orientation: float = setting(
        1e-9,
        doc="least distance of a bar's orientation vector from its axis, over the vector's length",
        derived="rounding of coordinates of order one",
    )
    max_warp: float = setting(
        1e-3,
        doc="largest distance of a plate's corner from the mean plane, over the plate's size",
        derived="the error of flat facets is of its square",
    )
    max_asymmetry: float = setting(
        1e-8,
        doc="largest difference of a matrix from its transpose, over its largest entry",
        derived="eight digits of matrices written to files",
    )
    min_mass_pivot: float = setting(
        1e-12,
        doc="least pivot of a mass matrix with a unit diagonal",
        derived="below, the matrix is singular but for rounding",
    )
    rigid_shift: float = setting(
        1e-9,
        doc="shift of the search for rigid-body motions, over an upper bound of the highest eigenvalue",
        derived="above rounding, below elastic eigenvalues",
    )
    rigid_candidates: int = setting(
        12,
        unit="motions",
        doc="slowest motions among which rigid-body motions are identified",
        derived="six of a body, and as many mechanisms",
    )
    reported_dofs: int = setting(
        10, unit="DoFs", doc="DoFs listed in an error message", derived="length of a readable message"
    )
    max_whole_group_values: int = setting(
        1_000_000,
        unit="values",
        doc="values of all groups as full matrices up to which each group is one element",
        derived="memory: 8 MB",
    )
    max_pair_elements: int = setting(
        50_000, unit="elements", doc="elements that groups are cut into at most", derived="memory and time"
    )
    max_element_values: int = setting(
        20_000_000, unit="values", doc="values of all element matrices of one kind", derived="memory: 160 MB"
    )


INPUT = InputSettings()


@dataclass(frozen=True)
class ElementSettings(Settings):
    """Constants of the element formulations and of catalogue meshes."""

    shear_coefficient: float = setting(
        5 / 6,
        doc="shear correction of a homogeneous plate and of a rectangular section",
        derived="parabolic shear stress over the thickness, Reissner (1945)",
    )
    rigid_joint_flexibility: float = setting(
        1e-5,
        doc="joint flexibility times the member's rotational stiffness below which its inertia is neglected",
        derived="the joint rotation is then a mode far above any band: condensed statically",
    )
    elements_per_metre: float = setting(
        7 / 5,
        unit="1/m",
        doc="elements of horizontals and, over their horizontal length, of diagonals of the thesis's frames",
        derived="1992 thesis, appendix B.3",
    )
    vertical_elements_per_metre: float = setting(
        5 / 3,
        unit="1/m",
        doc="elements of verticals of the thesis's frames",
        derived="1992 thesis, appendix B.3",
    )


ELEMENT = ElementSettings()
