//! The methods that a command is to measure.

use crate::registry;
use prt_transfer::{Registry, Result};

/// The labels in their shortest form, so that two spellings of one method are one row. An unknown one is an error: a slip of
/// the keyboard should not cost minutes.
pub fn shortest<S: AsRef<str>>(registry: &Registry, labels: &[S]) -> Result<Vec<String>> {
    labels.iter().map(|label| Ok(registry::method(registry, label.as_ref())?.label().to_string())).collect()
}
