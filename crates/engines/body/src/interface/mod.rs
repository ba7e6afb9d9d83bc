//! Geometry of the interface between two bodies: area that both bury, fit of their surfaces, polar contacts.

mod buried_area;
mod complementarity;
mod partner;
mod polar;

pub use buried_area::{buried_area_angstrom2, exposed_sites};
pub use complementarity::shape_complementarity;
pub use partner::Partner;
pub use polar::{PolarContacts, polar_contacts};
