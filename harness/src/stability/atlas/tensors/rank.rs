//! Members that are combinations of a few: rows of uf(Z) that are rounding, made as long as all others.

use super::members::{here, printed};
use super::samples;
use crate::stability::atlas::case::{Case, Form};

pub(super) const CASE: Case = Case {
    name: "rank",
    title: "Members of less than the rank",
    source: "Tsai and Shih 2006, Eq. 16",
    parameter: "rank of 24 members, of a cluster of sample rank 8",
    values: &[8.0, 7.0, 6.0, 4.0, 2.0, 1.0],
    quantity: "Σ(T-T̃)²/ΣT²",
    printed: Form {
        name: "each of the 8 rows of uf(Z) normalised",
        figure: |rank| printed(&samples(24, rank as usize)?),
    },
    here: Form { name: "cta, no more rows than the data have", figure: |rank| here(&samples(24, rank as usize)?) },
    bound: |_| 1e-10,
    promise: "exact to single precision",
    breaks: None,
};
