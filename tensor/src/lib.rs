//! Tensor approximation of radiance transfer.

pub mod tucker;
