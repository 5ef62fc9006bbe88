//! Half precision.
