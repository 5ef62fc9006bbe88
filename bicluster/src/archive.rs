//! The short form of shared sums of any depth, for the file: the elements as runs, and the pairs in the order in which they
//! were merged. Replaying the pairs gives the sums again, in a fraction of the time that finding them took.

use crate::block::Block;
use crate::distinct::Distinct;
use crate::lay_out::{lay_out, rows};
use crate::listing::Listing;
use crate::pairs::Pair;
use crate::planes;
use crate::regions::blocks;
use crate::sums::Sums;
use crate::symbols::Leaf;
use prt_transfer::sections::broken;
use prt_transfer::{Encoded, Quiet, Result, Shape, Sink, Source};
use rayon::prelude::*;

/// The number of pairs of a block where nothing is shared.
const PLAIN: u32 = u32::MAX;

/// Writes the short form. There is one where the sums know the regions of their blocks.
pub(crate) fn write(sums: &Sums, sink: &mut Sink) {
    let listing = Listing::of(sums.shape, |row, out| sums.elements(row, out));
    sink.put("index/regions", &sums.regions);
    let pairs = |block: &[u32; 3]| if block[0] == 0 { PLAIN } else { block[1] };
    sink.put("index/pairs", &sums.blocks.iter().map(pairs).collect::<Vec<_>>());
    // The next pair's first symbol mostly lies a little above the last one's.
    let pairs = sums.inputs.as_chunks::<2>().0;
    let before = std::iter::once(0).chain(pairs.iter().map(|p| p[0]));
    let first: Vec<u32> = pairs.iter().zip(before).map(|(p, before)| p[0].wrapping_sub(before).into()).collect();
    let second: Vec<u32> = pairs.iter().map(|p| u32::from(p[1] - p[0])).collect();
    planes::put(sink, "index/first", &first, u16::MAX.into());
    planes::put(sink, "index/second", &second, u16::MAX.into());
    listing.write(sums.shape.lights, sink);
}

/// Reads what [`write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<Sums> {
    let regions: Vec<u16> = source.take_exact("index/regions", shape.lights)?;
    let counts: Vec<u32> = source.take("index/pairs")?;
    let first = planes::take(source, "index/first", u16::MAX.into())?;
    let second = planes::take(source, "index/second", u16::MAX.into())?;
    let matrix = Listing::read(shape, source)?;
    let distinct = Distinct::of(&matrix, &Quiet)?;
    let kinds = blocks(&matrix, &distinct, &regions);
    let merged: u64 = counts.iter().filter(|&&n| n != PLAIN).map(|&n| u64::from(n)).sum();
    if counts.len() != kinds.len() || merged != first.len() as u64 || first.len() != second.len() {
        let expected = format!("pairs of {} blocks", kinds.len());
        return Err(broken("index/pairs", expected, format!("{merged} of {} blocks", counts.len())));
    }
    let mut symbol = 0u16;
    let pairs = first.iter().zip(&second).map(|(&first, &second)| {
        symbol = symbol.wrapping_add(first as u16);
        [symbol, symbol.wrapping_add(second as u16)]
    });
    let mut pairs = pairs.collect::<Vec<Pair>>().into_iter();
    let of_block = |&n: &u32| (n != PLAIN).then(|| pairs.by_ref().take(n as usize).collect());
    let pairs: Vec<Option<Vec<Pair>>> = counts.iter().map(of_block).collect();
    let blocks: Vec<Block> = (kinds.into_par_iter().zip(pairs))
        .map(|(kinds, pairs)| {
            let rows = rows(&matrix, &distinct, &kinds);
            match pairs {
                None => Ok(Block::plain(kinds, rows)),
                Some(pairs) => Block::replay(kinds, rows, pairs)
                    .ok_or_else(|| broken("index/first", "pairs of earlier symbols", "later ones")),
            }
        })
        .collect::<Result<_>>()?;
    lay_out(&matrix, &distinct, &blocks, regions)
}

impl Sums {
    /// The elements of a row, columns ascending.
    fn elements(&self, row: usize, out: &mut Vec<Leaf>) {
        let Some(product) = self.slots[row].checked_sub(1) else { return };
        self.expand(product as usize, &mut |leaf| out.push(leaf));
        if let Some(rest) = &self.rest {
            let mut values = vec![0.0; self.shape.lights];
            rest.row_into(product as usize, &mut values);
            out.extend((0..).zip(values).filter(|(_, v)| *v != 0.0));
        }
        out.sort_unstable_by_key(|leaf| leaf.0);
    }
}
