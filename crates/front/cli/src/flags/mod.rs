//! Flags shared by several verbs.

pub mod body;
pub mod cache;
#[cfg(feature = "learning")]
pub mod device;
pub mod execution;
pub mod hard_body;
pub mod medium;
pub mod model;
pub mod scheduler;
pub mod settings;
pub mod solute;
pub mod space;
pub mod tables;
pub mod terms;
pub mod tolerance;

/// A flag, if given, overrides the configuration.
pub fn override_with<T: Copy>(setting: &mut T, flag: Option<T>) {
    if let Some(value) = flag {
        *setting = value;
    }
}
