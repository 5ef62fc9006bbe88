//! The one place where the program learns of its methods.

use prt_transfer::csr::Csr;
use prt_transfer::transform::Identity;
use prt_transfer::{Label, Method, Registry, Result};

/// Every light transform and codec of the workspace, in the order in which `prt methods` lists them.
pub fn registry() -> Registry {
    Registry::new().transform::<Identity>().codec::<Csr>()
}

/// The method that a label's text describes.
pub fn method(registry: &Registry, label: &str) -> Result<Method> {
    registry.method(&label.parse::<Label>()?)
}
