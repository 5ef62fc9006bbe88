//! The methods that a command is to measure.

use crate::registry;
use prt_transfer::{Registry, Result};

/// What others are compared with.
pub const BASELINE: &str = "compact";

/// The labels in their shortest form, so that two spellings of one method are one row. An unknown one is an error: a slip of
/// the keyboard should not cost minutes.
pub fn shortest<S: AsRef<str>>(registry: &Registry, labels: &[S]) -> Result<Vec<String>> {
    labels.iter().map(|label| Ok(registry::method(registry, label.as_ref())?.label().to_string())).collect()
}

/// The user's labels, or the `usual` ones where there are none; each once, and `baseline` among them, since others are
/// compared with it.
pub fn with_baseline(registry: &Registry, given: &[String], usual: &[&str], baseline: &str) -> Result<Vec<String>> {
    let mut labels = if given.is_empty() { shortest(registry, usual)? } else { shortest(registry, given)? };
    labels.push(baseline.into());
    let mut kept: Vec<String> = Vec::new();
    for label in labels {
        if !kept.contains(&label) {
            kept.push(label);
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_there_once_and_the_baseline_too() {
        let registry = registry::registry();
        let of = |given: &[&str]| {
            let given: Vec<String> = given.iter().map(|&label| label.into()).collect();
            with_baseline(&registry, &given, &["csr"], "compact").map_err(|error| error.to_string())
        };
        assert_eq!(of(&[]).unwrap(), ["csr", "compact"]);
        assert_eq!(of(&["compact", "f16", "identity+f16"]).unwrap(), ["compact", "f16"]);
        assert!(of(&["f17"]).unwrap_err().contains("'f17'"));
    }
}
