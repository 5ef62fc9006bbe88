//! A biclustered matrix.

use crate::archive;
use crate::kernel;
use crate::sums::Sums;
use crate::wire;
use ndarray::{ArrayView2, ArrayViewMut2, s};
use prt_transfer::compact::EncodedCompact;
use prt_transfer::matrix::check_apply;
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source, Tally};
use rayon::prelude::*;

/// Sums that rows share, or where they do not pay the matrix in narrow widths. Relighting multiplies once for each leaf of a block whose value is not 1, and adds
/// n - 1 times for each sum and each distinct row of n terms. Where there are elements that no sum covers, they take a
/// multiplication and an addition each, and every distinct row one more addition.
pub struct EncodedBicluster(pub(crate) Form);

pub(crate) enum Form {
    Compact(Box<EncodedCompact>),
    Sums(Box<Sums>),
}

impl EncodedBicluster {
    pub(crate) fn of_sums(sums: Sums) -> EncodedBicluster {
        EncodedBicluster(Form::Sums(Box::new(sums)))
    }
    pub(crate) fn of_compact(compact: EncodedCompact) -> EncodedBicluster {
        EncodedBicluster(Form::Compact(Box::new(compact)))
    }
}

impl Encoded for EncodedBicluster {
    fn shape(&self) -> Shape {
        match &self.0 {
            Form::Compact(compact) => compact.shape(),
            Form::Sums(sums) => sums.shape,
        }
    }

    fn apply_into(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) -> Result<()> {
        let sums = match &self.0 {
            Form::Compact(compact) => return compact.apply_into(lights, out),
            Form::Sums(sums) => sums,
        };
        check_apply(sums.shape, &lights, &out)?;
        if !sums.adds_only() && lights.iter().any(|x| !x.is_finite()) {
            sums.apply_rows(lights, out);
            return Ok(());
        }
        for first in (0..lights.ncols()).step_by(4) {
            let channels = s![.., first..lights.ncols().min(first + 4)];
            let (lights, out) = (lights.slice(channels), out.slice_mut(channels));
            match lights.ncols() {
                1 => apply::<1>(sums, lights, out)?,
                _ => apply::<4>(sums, lights, out)?,
            }
        }
        Ok(())
    }

    fn row_into(&self, row: usize, out: &mut [f32]) {
        match &self.0 {
            Form::Compact(compact) => compact.row_into(row, out),
            Form::Sums(sums) => sums.row_into(row, out),
        }
    }

    fn flops(&self, light: &[f32]) -> Flops {
        let sums = match &self.0 {
            Form::Compact(compact) => return compact.flops(light),
            Form::Sums(sums) => sums,
        };
        let light: Vec<[f32; 1]> = light.iter().map(|&x| [x]).collect();
        let (mut tally, mut symbols, mut products) = (Tally::default(), Vec::new(), Vec::new());
        for block in 0..sums.blocks.len() {
            products.resize(sums.starts[block + 1].product - sums.starts[block].product, [0.0]);
            kernel::run(sums, block, &light, &mut symbols, &mut products, &mut tally);
        }
        let flops = tally.0;
        match &sums.rest {
            Some(rest) => {
                let onto = Flops { additions: sums.products() as u64, ..Flops::default() };
                flops + onto + rest.flops(light.as_flattened())
            }
            None => flops,
        }
    }

    fn write(&self, sink: &mut Sink) {
        match &self.0 {
            Form::Compact(compact) => compact.write(sink),
            Form::Sums(sums) if sums.regions.is_empty() => wire::write(sums, sink),
            Form::Sums(sums) => archive::write(sums, sink),
        }
    }

    fn hold(&self, sink: &mut Sink) {
        match &self.0 {
            Form::Compact(compact) => compact.hold(sink),
            Form::Sums(sums) => wire::hold(sums, sink),
        }
    }
}

fn apply<const N: usize>(sums: &Sums, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
    kernel::gather::<N>(sums, &kernel::products(sums, lights)?, out);
    Ok(())
}

impl Sums {
    /// Whether it is known that every term of a row is a part of it: merged pairs are, biclusters may leave residuals.
    fn adds_only(&self) -> bool {
        !self.regions.is_empty()
    }

    /// Relights row by row: an infinite coefficient must not reach rows that a residual takes it away from.
    fn apply_rows(&self, lights: ArrayView2<f32>, mut out: ArrayViewMut2<f32>) {
        out.outer_iter_mut().into_par_iter().enumerate().for_each_init(
            || vec![0.0; self.shape.lights],
            |values, (row, mut out)| {
                self.row_into(row, values);
                out.fill(0.0);
                for (value, x) in values.iter().zip(lights.outer_iter()).filter(|(v, _)| **v != 0.0) {
                    out.iter_mut().zip(x).for_each(|(y, x)| *y += value * x);
                }
            },
        );
    }

    fn row_into(&self, row: usize, out: &mut [f32]) {
        let mut sums = vec![0f64; out.len()];
        if let Some(product) = self.slots[row].checked_sub(1) {
            if let Some(rest) = &self.rest {
                rest.row_into(product as usize, out);
                sums.iter_mut().zip(&*out).for_each(|(sum, &value)| *sum = value.into());
            }
            // Residuals are such that f64 holds every partial sum, so that what adds up here is the element itself.
            self.expand(product as usize, &mut |(column, value)| sums[column as usize] += f64::from(value));
        }
        out.iter_mut().zip(sums).for_each(|(value, sum)| *value = sum as f32);
    }
}

impl Restore for EncodedBicluster {
    const TAG: &'static str = "bicluster.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedBicluster> {
        if source.has("index/pairs") {
            return Ok(EncodedBicluster::of_sums(archive::read(shape, source)?));
        }
        if source.has("index/slots") {
            return Ok(EncodedBicluster::of_sums(wire::read(shape, source)?));
        }
        Ok(EncodedBicluster::of_compact(EncodedCompact::read(shape, source)?))
    }
}
