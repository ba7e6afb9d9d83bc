//! Flags that several verbs share, and what they stand for.

pub mod body;
pub mod choices;
pub mod device;
pub mod execution;
pub mod medium;
pub mod scheduler;
pub mod space;
pub mod tables;
pub mod tolerance;

/// A flag, if given, takes the place of what a configuration says.
pub fn override_with<T: Copy>(setting: &mut T, flag: Option<T>) {
    if let Some(value) = flag {
        *setting = value;
    }
}
