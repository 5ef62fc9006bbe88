//! How long operations tell what they are doing, and how they are told to stop.

use crate::error::Result;

/// Receives progress. A library never prints: the program decides what is shown.
pub trait Progress: Sync {
    /// A new stage of `total` units of work begins, such as `("encode", rows)`.
    fn start(&self, stage: &str, total: u64) {
        let _ = (stage, total);
    }
    /// `done` more units are finished; called from any thread. An error ([`crate::Error::Cancelled`]) stops the work.
    fn advance(&self, done: u64) -> Result<()> {
        let _ = done;
        Ok(())
    }
}

/// Nobody listens.
pub struct Quiet;

impl Progress for Quiet {}
