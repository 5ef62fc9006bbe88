//! Few light coefficients, down to one: no row has a neighbour to the right.

use super::study::{Sweep, doublings};
use prt_transfer::{LightBasis, Result, TransferMatrix};

pub(super) const SWEEP: Sweep = Sweep {
    name: "columns",
    title: "Few columns: light coefficients that are spread evenly",
    parameter: "columns",
    values: |base| doublings(base.lights()),
    matrix: |base, lights| spread_lights(base, lights as usize),
};

/// `lights` columns of `base` at equal distances, in their order; each stands for the middle of its share of the light.
pub fn spread_lights(base: &TransferMatrix, lights: usize) -> Result<TransferMatrix> {
    let all = base.lights();
    let lights = lights.min(all);
    // Where a column of the base goes, if anywhere.
    let mut place = vec![None; all];
    (0..lights).for_each(|k| place[(2 * k + 1) * all / (2 * lights)] = Some(k as u32));
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in 0..base.rows() {
        for (col, value) in base.row(row).non_zeros() {
            if let Some(to) = place[col] {
                columns.push(to);
                values.push(value);
            }
        }
        offsets.push(columns.len());
    }
    let basis = if lights == all { base.basis().clone() } else { LightBasis::Plain { lights } };
    TransferMatrix::from_csr(offsets, columns, values, base.shape().responses, basis)
}
