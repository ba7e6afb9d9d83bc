//! The first contact in a step.
