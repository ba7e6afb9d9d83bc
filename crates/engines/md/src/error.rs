use protomer_kernel::Number;

/// Errors of interactions that cannot be computed, and of bodies that cannot move on.
///
/// ```
/// use protomer_md::{Error, body::Kind};
/// assert_eq!(Kind::ball(3, 0.0), Err(Error::NoVolume));
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The repulsion diverges at contact.
    #[error("the bodies touch or overlap, where the repulsion is infinite; move them apart")]
    Overlap,
    /// A polygon and a polyhedron cannot interact.
    #[error("one body has two dimensions and the other three; give both the same number")]
    MixedDimensions,
    /// A body without volume has no mass.
    #[error(
        "the body has no volume, so it has no mass; give a polygon, a polyhedron, a disk, a ball or an \
         ellipsoid"
    )]
    NoVolume,
    /// Parts of a rigid union share volume.
    #[error(
        "parts {first} and {second} of the body overlap, so their volume would count twice; give \
         parts that touch at most"
    )]
    OverlappingParts {
        /// Number of the first part, from 1.
        first: usize,
        /// Number of the second part, from 1.
        second: usize,
    },
    /// The rescaled central term is for pairs only.
    #[error(
        "the central term of eq. 4.6 jumps where closest points do, so bodies in motion do not have \
         it; use none or conservative"
    )]
    CentralTerm,
    /// The closest points of an ellipsoid and a polytope are not found here.
    #[error(
        "ellipsoids feel ellipsoids, disks and balls only; give all bodies of the run without faces, \
         or a polytope in the place of the ellipsoid"
    )]
    EllipsoidBesideFaces,
    /// Bodies in motion met.
    #[error(
        "bodies {first} and {second} touch or overlap, where the repulsion is infinite; use a \
         smaller time step, or compress more slowly"
    )]
    Met {
        /// Number of the first body.
        first: usize,
        /// Number of the second body.
        second: usize,
    },
    /// A position or a velocity is not a number any more.
    #[error("the motion has no finite numbers any more; use a smaller time step")]
    Diverged,
    /// A body would meet two images of another.
    #[error(
        "the box is {smallest:.3} long, and bodies that see each other need at least {needed:.3}; \
         use more bodies, or a lower density"
    )]
    SmallBox {
        /// The shortest edge of the box.
        smallest: f64,
        /// The length that the edge must have at least.
        needed: f64,
    },
    /// A table of heights that is longer than the box.
    #[error(
        "the field has heights from {first} to {last}, and the box is {length:.4} long there; give heights from 0 to at \
         most that, or a lower density"
    )]
    TableBeyondBox {
        /// The first height.
        first: f64,
        /// The last height.
        last: f64,
        /// Length of the box along the last axis.
        length: f64,
    },
    /// A ball whose orientation would matter.
    #[error(
        "sites away from the centre turn a body, and disks and balls do not turn here; give an ellipse or an ellipsoid with \
         equal half axes, such as ellipsoid:0.5,0.5,0.5"
    )]
    BallWithSites,
    /// Heights without a box.
    #[error(
        "a field counts heights from the lower end of a box, and there is none; give a periodic box"
    )]
    NoBox,
    /// A field in a box whose volume changes.
    #[error(
        "a field has its heights in a box of constant size; give an ensemble at constant volume, or leave the field out"
    )]
    FieldAtPressure,
    /// An energy in addition to the contacts that bodies in motion cannot have.
    #[error(transparent)]
    Energy(#[from] protomer_kernel::KernelError),
    /// A setting outside its range.
    #[error("{what} is {}; give {expected}", Number(*value))]
    OutOfRange {
        /// The setting.
        what: &'static str,
        /// Value of the setting.
        value: f64,
        /// Description of the values that the setting may have.
        expected: &'static str,
    },
    /// The state does not fit the bodies.
    #[error("the state does not belong to these bodies; use the one that was saved with them")]
    OtherBodies,
}

/// The result of an operation on bodies.
pub type Result<T> = std::result::Result<T, Error>;
