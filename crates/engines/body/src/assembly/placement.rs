//! A body and its pose.

use protomer_kernel::Pose;

/// A body, by its index in a list the caller keeps, and its pose.
pub type Placement = (usize, Pose);
