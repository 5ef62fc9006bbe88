//! The one place where the program learns of its methods.

pub mod families;
mod family;

use prt_bicluster::Bicluster;
use prt_cpca::{Cpca, Pca, Vq};
use prt_slf::Slf;
use prt_srbf::Srbf;
use prt_tensor::{Cta, TuckerCodec};
use prt_transfer::compact::Compact;
use prt_transfer::csr::Csr;
use prt_transfer::dense::Dense;
use prt_transfer::f16::F16;
use prt_transfer::runs::Runs;
use prt_transfer::sh::Sh;
use prt_transfer::transform::Identity;
use prt_transfer::visibility::Visibility;
use prt_transfer::{Label, Method, Registry, Result};
use prt_wavelet::{Haar, Truncate};

/// Every light transform and codec of the workspace, in the order in which `prt methods` lists them.
pub fn registry() -> Registry {
    Registry::new()
        .transform::<Identity>()
        .transform::<Sh>()
        .transform::<Haar>()
        .transform::<Srbf>()
        .codec::<Dense>()
        .codec::<Csr>()
        .codec::<Compact>()
        .codec::<Runs>()
        .codec::<Visibility>()
        .codec::<F16>()
        .codec::<Truncate>()
        .codec::<Bicluster>()
        .codec::<Vq>()
        .codec::<Pca>()
        .codec::<Cpca>()
        .codec::<TuckerCodec>()
        .codec::<Cta>()
        .codec::<Slf>()
}

/// The method that a label's text describes.
pub fn method(registry: &Registry, label: &str) -> Result<Method> {
    registry.method(&label.parse::<Label>()?)
}
