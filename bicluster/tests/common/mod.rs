//! Matrices through the codec and its files.
#![allow(dead_code)]

use prt_bicluster::{Bicluster, BiclusterParams};
use prt_transfer::transform::{Identity, IdentityParams};
use prt_transfer::{Compressed, Configure, Method, Quiet, Registry, TransferMatrix};

pub(crate) fn identity() -> Identity {
    Identity::new(IdentityParams {}).unwrap()
}

pub(crate) fn encode(params: BiclusterParams, matrix: &TransferMatrix) -> Compressed {
    Method::new(identity(), Bicluster::new(params).unwrap()).encode(matrix, &Quiet).unwrap()
}

pub(crate) fn registry() -> Registry {
    Registry::new().transform::<Identity>().codec::<Bicluster>()
}

/// What a file gives back.
pub(crate) fn reloaded(compressed: &Compressed) -> Compressed {
    registry().restore(&compressed.header(), compressed.sections().into_sections()).unwrap()
}
