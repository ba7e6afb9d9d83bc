use protomer_kernel::{AtMost, Number};

/// Errors of simulations of hard bodies, and of the computation of phases.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// let message = HardBody::<3>::ball(-1.0).map_err(|error| error.to_string());
/// assert_eq!(message.err().as_deref(), Some("the radius is -1; it must be positive"));
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The shape has another number of dimensions than the box.
    #[error("the shape has {shape} dimensions and the box {space}; give both the same number")]
    Dimension {
        /// Number of dimensions of the shape.
        shape: usize,
        /// Number of dimensions of the box.
        space: usize,
    },
    /// A value outside the range in which it has a meaning.
    #[error("{quantity} is {}; it must be {requirement}", Number(*value))]
    OutOfRange {
        /// The quantity, as a user would name it.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// Values that are accepted.
        requirement: &'static str,
    },
    /// A body would meet an image of itself.
    #[error(
        "the box has the edge {edge:.4}, and one of less than {least:.4} is too small for these bodies; give at \
         least {bodies} of them"
    )]
    BoxTooSmall {
        /// Smallest length of the box.
        edge: f64,
        /// Smallest length that the box may have.
        least: f64,
        /// A number of bodies whose box has that length at the same packing fraction.
        bodies: usize,
    },
    /// At constant pressure the box would become too small.
    #[error(
        "at this pressure the box shrinks to an edge of {edge:.4}, and one of less than {least:.4} is too small for \
         these bodies; give at least {bodies} of them"
    )]
    BoxShrinks {
        /// Smallest length that the box would have.
        edge: f64,
        /// Smallest length that the box may have.
        least: f64,
        /// A number of bodies whose box cannot become too small.
        bodies: usize,
    },
    /// The work was asked to stop before it had a state.
    #[error("stopped before the bodies were in their places")]
    Stopped,
    /// The bodies jammed on the way to their packing fraction.
    #[error(
        "random bodies jammed at a packing fraction of {reached:.4} on the way to {wanted:.4}; give a \
         lower one"
    )]
    Jammed {
        /// The packing fraction reached.
        reached: f64,
        /// The packing fraction wanted.
        wanted: f64,
    },
    /// Bodies overlap in the places that were given.
    #[error(
        "{overlaps} pairs of bodies overlap in the places given (or reach into a wall); give the shape and the size that \
         they had there, or places without overlap"
    )]
    PlacedOverlap {
        /// Number of pairs that overlap, and of bodies that reach into a wall.
        overlaps: usize,
    },
    /// Bodies overlap on the sites of a crystal.
    #[error(
        "the bodies overlap in this crystal at a packing fraction of {wanted:.4}; they fit up to \
         {}",
        AtMost(*largest)
    )]
    Dense {
        /// The packing fraction wanted.
        wanted: f64,
        /// Largest packing fraction at which the bodies do not overlap.
        largest: f64,
    },
    /// Two bodies overlap where none may.
    #[error(
        "{} at a packing fraction of {packing_fraction:.4}; give a lower one",
        match .bodies {
            [first, second] if first == second =>
                format!("body {first} of the unit cell overlaps an image of itself"),
            [first, second] => format!("bodies {first} and {second} of the unit cell overlap"),
        }
    )]
    Overlap {
        /// Numbers of the bodies in the order of the sites, from 1.
        bodies: [usize; 2],
        /// The packing fraction wanted.
        packing_fraction: f64,
    },
    /// Two sites of a unit cell are the same, or images of each other.
    #[error(
        "bodies {} and {} of the unit cell overlap at any packing fraction: their sites coincide, or one is an \
         image of the other; leave one out",
        .bodies[0],
        .bodies[1]
    )]
    SameSite {
        /// Numbers of the bodies in the order of the sites, from 1.
        bodies: [usize; 2],
    },
    /// Pieces of a body overlap.
    #[error(
        "pieces {} and {} of the body overlap, so its volume is not the sum of theirs; move them apart until \
         they touch, or cut one",
        .pieces[0],
        .pieces[1]
    )]
    Pieces {
        /// Numbers of the pieces, from 1.
        pieces: [usize; 2],
    },
    /// The bodies do not fill whole unit cells.
    #[error(
        "{bodies} bodies are not a whole number of unit cells of {sites}; give a multiple of {sites}, such \
         as {nearest}"
    )]
    PartialCell {
        /// The number of bodies wanted.
        bodies: usize,
        /// Sites of a unit cell.
        sites: usize,
        /// A number of bodies near the one wanted that works.
        nearest: usize,
    },
    /// The name is not that of a crystal.
    #[error(
        "'{name}' is not a crystal in {dimension} dimensions; known are {}",
        listed(names)
    )]
    UnknownCrystal {
        /// The name.
        name: String,
        /// Number of dimensions of the bodies.
        dimension: usize,
        /// Names of the crystals that are known.
        names: Vec<&'static str>,
    },
    /// A crystal with sites for more kinds of bodies than there are.
    #[error(
        "the crystal has sites for {kinds} kinds of bodies, and there is only {given}; give a crystal of one kind, or run a \
         mixture"
    )]
    KindsOfCrystal {
        /// Kinds of sites.
        kinds: usize,
        /// Kinds of bodies.
        given: usize,
    },
    /// A curve needs more points.
    #[error("there are {given} points; a curve through them needs at least {fewest}")]
    FewPoints {
        /// Number of points given.
        given: usize,
        /// Number of points needed.
        fewest: usize,
    },
    /// The abscissas of a table do not ascend.
    #[error("{second} follows {first}; give ascending values, each of them once")]
    NotAscending {
        /// The first of the two values.
        first: f64,
        /// The value after it.
        second: f64,
    },
    /// Two things that cannot be simulated in one box yet.
    #[error("{first} and {second} cannot be simulated together; leave one out")]
    NotTogether {
        /// Name of one of them.
        first: &'static str,
        /// Name of the other.
        second: &'static str,
    },
    /// A body that any rotation about an axis leaves as it is.
    #[error(
        "the body looks the same however it is turned about its axis; the orientation of such bodies \
         cannot be held yet"
    )]
    Axis,
    /// A body among whose places hardly any overlap another.
    #[error(
        "the body is so slender that of a million places in the ball about it none overlaps; give a less slender one"
    )]
    TooSlender,
    /// The shape cannot be used.
    #[error(transparent)]
    Shape(#[from] protomer_kernel::KernelError),
}

/// The result of an operation on hard bodies.
pub type Result<T> = std::result::Result<T, Error>;

/// The smallest packing fraction: a box that is wider would have no room for more digits of the places.
const EMPTIEST: f64 = 1e-15;

/// `Ok` for a part of the box that bodies can fill.
pub(crate) fn require_packing_fraction(value: f64) -> Result<()> {
    let holds = (EMPTIEST..1.0).contains(&value);
    require(
        "the packing fraction",
        value,
        "from 1e-15 to less than 1",
        holds,
    )
}

/// Names with commas and "and" between them.
fn listed(names: &[&str]) -> String {
    match names {
        [others @ .., last] if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// `Ok` if `value` is finite and `holds`, otherwise the error that names the quantity.
pub(crate) fn require(
    quantity: &'static str,
    value: f64,
    requirement: &'static str,
    holds: bool,
) -> Result<()> {
    if value.is_finite() && holds {
        return Ok(());
    }
    Err(Error::OutOfRange {
        quantity,
        value,
        requirement,
    })
}
