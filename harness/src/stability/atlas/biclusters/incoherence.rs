//! Rows that share nothing with their neighbours.

use super::{PAPER, operations, visibility};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::scatter::scattered;

pub(super) const CASE: Case = Case {
    name: "incoherence",
    title: "Incoherent rows",
    source: "biclustering, §4",
    parameter: "share of the non-zeros moved to random columns",
    values: &[0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0],
    quantity: "operations of relighting, of two for each non-zero",
    printed: Form {
        name: "biclusters grown as in the paper",
        figure: |share| operations(PAPER, &scattered(&visibility()?, share)?),
    },
    here: Form { name: "bicluster", figure: |share| operations("bicluster", &scattered(&visibility()?, share)?) },
    bound: |_| 1.0,
    promise: "never more than compressed rows take",
    breaks: None,
};
