//! What a bicluster saves and what it takes: the weights of Eq. 9.

use crate::params::Objective;

/// Weights, in operations or bytes. A bicluster of r rows and l columns gains
/// element·(nnz(M) - nnz(residual)) - row·r - column·l - base, where M is what its rows hold at its columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cost {
    /// An element left in the matrix, positive.
    pub(crate) element: u32,
    /// A row's membership.
    pub(crate) row: u32,
    /// A column with its value.
    pub(crate) column: u32,
    /// The bicluster itself.
    pub(crate) base: i32,
}

impl Cost {
    /// Biclusters of the matrix. Operations as in Eq. 9: gain = 2·nnz(M) - (r + 2l - 1) - 2·nnz(residual), a multiplication and an
    /// addition for an element. Bytes of index and value: a `u16` column and a one-byte code of the value make 3 for an element or
    /// a column, a `u16` makes 2 for a membership.
    pub(crate) fn of_elements(objective: Objective) -> Cost {
        match objective {
            Objective::Flops => Cost { element: 2, row: 1, column: 2, base: -1 },
            Objective::Bytes => Cost { element: 3, row: 2, column: 3, base: 0 },
        }
    }

    /// Biclusters of memberships, where every value is one: an addition each, gain = nnz(M) - (r + l - 1) - nnz(residual); or a `u16` each.
    pub(crate) fn of_memberships(objective: Objective) -> Cost {
        match objective {
            Objective::Flops => Cost { element: 1, row: 1, column: 1, base: -1 },
            Objective::Bytes => Cost { element: 2, row: 2, column: 2, base: 0 },
        }
    }

    /// What a bicluster of `rows` and `columns` takes.
    pub(crate) fn taken(&self, rows: usize, columns: usize) -> i64 {
        i64::from(self.row) * rows as i64 + i64::from(self.column) * columns as i64 + i64::from(self.base)
    }
}
