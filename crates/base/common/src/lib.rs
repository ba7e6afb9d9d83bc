//! What the application crates share: answers of verbs, files in and out, quantities with units.
//!
//! | module | one idea |
//! |---|---|
//! | [`answer`] | the answer of a verb: a value, its text, its figure |
//! | [`input`] | input files: found, read, decompressed, hashed |
//! | [`live`] | simulations in memory |
//! | [`output_file`] | output files: replaced only on request |
//! | [`page`] | what a page consists of |
//! | [`quantity`] | numbers with units, such as `150mM` |
//! | [`range`] | ranges of numbers, checked where they enter |
//! | [`remedy`] | errors of the operating system with what to do about them |
//! | [`mod@settings`] | settings that are declared once |
//! | [`cpu_time`] | processor time of a piece of work |

pub mod answer;
pub mod cpu_time;
pub mod input;
pub mod live;
pub mod output_file;
pub mod page;
pub mod quantity;
pub mod range;
pub mod remedy;
pub mod settings;
