//! `bicluster`: the codec.

use crate::approximate::approximate;
use crate::block::Block;
use crate::encoded::EncodedBicluster;
use crate::growth::Options;
use crate::lay_out::{compact, lay_out, partition, rows};
use crate::listing::can_list;
use crate::params::{BiclusterParams, Levels, Seeds};
use prt_transfer::footprint::{Extent, Footprint, by};
use prt_transfer::params::Value;
use prt_transfer::{Codec, Configure, Encoded, Error, Params, Progress, Result, Sink, TransferMatrix};
use rayon::prelude::*;

/// The codec.
pub struct Bicluster(BiclusterParams);

impl Configure for Bicluster {
    type Params = BiclusterParams;

    fn new(params: BiclusterParams) -> Result<Bicluster> {
        if let Some(bound) = params.max_error.filter(|e| !(0.0..=1.0).contains(e)) {
            return Err(BiclusterParams::refuse("max_error", bound, "from 0 to 1"));
        }
        if let (Some(seeds), Levels::All) = (params.seeds, params.levels) {
            return Err(BiclusterParams::refuse("seeds", seeds.show(), "none where levels=all, which grows nothing"));
        }
        if params.seed != 0 && params.seeds != Some(Seeds::Random) {
            return Err(BiclusterParams::refuse("seed", params.seed, "0 without seeds=random"));
        }
        Ok(Bicluster(params))
    }

    fn params(&self) -> &BiclusterParams {
        &self.0
    }
}

impl Codec for Bicluster {
    type Encoded = EncodedBicluster;

    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedBicluster> {
        if matrix.rows() >= u32::MAX as usize {
            let limit = u64::from(u32::MAX) - 1;
            return Err(Error::TooLarge { what: "rows to bicluster".into(), limit, found: matrix.rows() as u64 });
        }
        match self.0.max_error {
            Some(bound) if bound > 0.0 => {
                self.exact(&approximate(matrix, bound, self.0.objective, progress)?, progress)
            }
            _ => self.exact(matrix, progress),
        }
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        // Rows cut into kinds, `compact` to compare with, and the elements in hashes where values differ, as those of dense matrices do; an
        // approximation holds what every element costs besides.
        let costs = if self.0.max_error.is_some_and(|bound| bound > 0.0) { 26.0 } else { 0.0 };
        let of_rows = by(50.0, extent.rows());
        let (peak, result) = match extent.is_thin() {
            true => (by(17.0 + costs, extent.non_zeros), by(8.0, extent.non_zeros)),
            false => (by(52.0 + costs, extent.non_zeros) + by(6.0, extent.cells()), by(4.0, extent.cells())),
        };
        Some(Footprint { peak: peak + of_rows, result: result + of_rows })
    }
}

impl Bicluster {
    fn exact(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<EncodedBicluster> {
        let BiclusterParams { objective, levels, seeds, seed, .. } = self.0;
        let options = Options { seeds: seeds.unwrap_or(Seeds::Best), seed, objective };
        let compact = compact(matrix, progress)?;
        let bytes = held(&compact);
        let bytes_per_element = bytes as f64 / matrix.non_zeros().max(1) as f64;
        let (distinct, regions, kinds) = partition(matrix, progress)?;
        progress.start("bicluster", distinct.first.len() as u64);
        let blocks = kinds.into_par_iter().map(|kinds| {
            let (count, rows) = (kinds.len() as u64, rows(matrix, &distinct, &kinds));
            let block = match levels {
                Levels::All => Block::search(kinds, rows, objective, bytes_per_element),
                _ => Block::grow(kinds, rows, &options, levels == Levels::Two, bytes_per_element),
            };
            progress.advance(count)?;
            Ok(block)
        });
        let blocks: Vec<Block> = blocks.collect::<Result<_>>()?;
        // Only pairs can be found again from rows and regions.
        let archived = levels == Levels::All && can_list(matrix);
        let regions = if archived { regions } else { Vec::new() };
        let sums = lay_out(matrix, &distinct, &blocks, regions)?;
        let readable = sums.check().is_ok();
        let (sums, compact) = (EncodedBicluster::of_sums(sums), EncodedBicluster::of_compact(compact));
        let operations = |encoded: &EncodedBicluster| encoded.flops(&vec![0.0; matrix.lights()]).total();
        let pays = held(&sums) < bytes && operations(&sums) <= operations(&compact);
        Ok(if readable && pays { sums } else { compact })
    }
}

/// Bytes of memory.
fn held(encoded: &impl Encoded) -> usize {
    let mut sink = Sink::new();
    encoded.hold(&mut sink);
    sink.resident_bytes()
}
