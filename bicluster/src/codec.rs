//! `bicluster`: the codec.

use crate::block::Block;
use crate::distinct::Distinct;
use crate::encoded::EncodedBicluster;
use crate::params::{BiclusterParams, Levels, Objective, Seeds};
use crate::lay_out::{compact, lay_out, rows};
use crate::places::places;
use crate::regions::{blocks, regions};
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
        let compact = compact(matrix, progress)?;
        let bytes = held(&compact);
        let bytes_per_element = bytes as f64 / matrix.non_zeros().max(1) as f64;
        let distinct = Distinct::of(matrix, progress)?;
        let regions = regions(matrix, &distinct, &places(matrix));
        let kinds = blocks(matrix, &distinct, &regions);
        progress.start("bicluster", distinct.first.len() as u64);
        let blocks = kinds.into_par_iter().map(|kinds| {
            let rows = rows(matrix, &distinct, &kinds);
            progress.advance(kinds.len() as u64)?;
            Ok(Block::search(kinds, rows, self.0.objective, bytes_per_element))
        });
        let blocks: Vec<Block> = blocks.collect::<Result<_>>()?;
        let sums = lay_out(matrix, &distinct, &blocks, regions)?;
        Ok(if sums.bytes() < bytes { EncodedBicluster::of_sums(sums) } else { EncodedBicluster::of_compact(compact) })
    }
}

/// Bytes of memory.
pub(crate) fn held(encoded: &impl Encoded) -> usize {
    let mut sink = Sink::new();
    encoded.write(&mut sink);
    sink.resident_bytes()
}
