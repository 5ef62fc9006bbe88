//! Pictures of a scene relit by a matrix, exact or compressed, and how far apart they are.
//!
//! A [`Viewpoint`] is made once for an origin: what the samples of every pixel see. A [`Portrait`] is the picture of the exact matrix from there
//! under a light; it takes others like it and compares them. [`Turning`] tells how much changes of the picture are changed while the light turns.
//! [`Pictures`] are the PNGs of many methods at about the same bytes.

mod csv;
mod field;
mod flicker;
mod gallery;
mod original;
mod portrait;
mod scenery;
mod viewpoint;

pub use csv::write_csv;
pub use flicker::Turning;
pub use gallery::{Candidate, Gallery, Pictures, Shown};
pub use original::{Comparison, Errors, Original};
pub use portrait::Portrait;
pub use scenery::{Scenery, fill_behind};
pub use viewpoint::{AZIMUTH, ELEVATION, FIELD_OF_VIEW, SAMPLES, SIZE, Viewpoint};

#[cfg(test)]
mod tests;
