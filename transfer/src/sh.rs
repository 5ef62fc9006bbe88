//! Real spherical harmonics.
