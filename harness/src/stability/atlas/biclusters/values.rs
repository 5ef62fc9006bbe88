//! Many distinct values: constant columns have nothing to be constant.

use super::{PAPER, operations, visibility};
use crate::stability::atlas::case::{Case, Form};
use crate::stability::values::quantised;

pub(super) const CASE: Case = Case {
    name: "values",
    title: "Many distinct values",
    source: "biclustering, §4: constant-column biclusters",
    parameter: "levels of the quantised field",
    values: &[2.0, 4.0, 16.0, 64.0, 256.0, 4096.0, 65536.0],
    quantity: "operations of relighting, of two for each non-zero",
    printed: Form {
        name: "biclusters grown as in the paper",
        figure: |levels| operations(PAPER, &quantised(&visibility()?, levels as usize)?),
    },
    here: Form {
        name: "bicluster",
        figure: |levels| operations("bicluster", &quantised(&visibility()?, levels as usize)?),
    },
    bound: |_| 1.0,
    promise: "never more than compressed rows take",
    breaks: None,
};
