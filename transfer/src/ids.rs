//! The cluster of each sample, in as few bits as their number needs.

use crate::error::Result;
use crate::sections::broken;
use crate::sections::{Sink, Source};

const SECTION: &str = "index/members";

/// Cluster ids of ⌈log2 clusters⌉ bits each, the first in the lowest bits of the first byte; nothing where there is one
/// cluster.
#[derive(Clone, Debug, PartialEq)]
pub struct Ids {
    bits: u32,
    packed: Vec<u8>,
}

/// Bits of an id below `clusters`, at most 32.
fn bits_of(clusters: usize) -> u32 {
    clusters.max(1).next_power_of_two().trailing_zeros()
}

impl Ids {
    /// Packs ids, all below `clusters`, of which there are at most 2^32.
    pub fn pack(ids: &[u32], clusters: usize) -> Ids {
        let bits = bits_of(clusters);
        let mut packed = Vec::with_capacity((ids.len() * bits as usize).div_ceil(8));
        let (mut pending, mut filled) = (0u64, 0);
        for &id in ids {
            pending |= u64::from(id) << filled;
            filled += bits;
            while filled >= 8 {
                packed.push(pending as u8);
                pending >>= 8;
                filled -= 8;
            }
        }
        if filled > 0 {
            packed.push(pending as u8);
        }
        Ids { bits, packed }
    }

    /// The id of a sample.
    #[inline]
    pub fn at(&self, sample: usize) -> u32 {
        let bit = sample * self.bits as usize;
        let rest = self.packed.get(bit / 8..).unwrap_or_default();
        // An id reaches over at most five bytes.
        let word = match rest.first_chunk() {
            Some(eight) => u64::from_le_bytes(*eight),
            None => rest.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte)),
        };
        (word >> (bit % 8) & ((1 << self.bits) - 1)) as u32
    }

    /// The ids of the samples from `first` on.
    pub fn fill(&self, first: usize, ids: &mut [u32]) {
        match self.bits {
            0 => ids.fill(0),
            8 => ids.iter_mut().zip(&self.packed[first..]).for_each(|(id, &byte)| *id = byte.into()),
            _ => ids.iter_mut().enumerate().for_each(|(i, id)| *id = self.at(first + i)),
        }
    }

    /// Writes them to the section `index/members`.
    pub fn write(&self, sink: &mut Sink) {
        self.write_to(sink, SECTION);
    }

    /// As [`Ids::write`], to a section of another name.
    pub fn write_to(&self, sink: &mut Sink, section: &str) {
        if self.bits > 0 {
            sink.put(section, &self.packed);
        }
    }

    /// The ids of `samples`, checked to be below `clusters`.
    pub fn read(source: &mut Source, samples: usize, clusters: usize) -> Result<Ids> {
        Ids::read_from(source, SECTION, samples, clusters)
    }

    /// What [`Ids::write_to`] wrote; see [`Ids::read`].
    pub fn read_from(source: &mut Source, section: &str, samples: usize, clusters: usize) -> Result<Ids> {
        let bits = bits_of(clusters);
        if bits == 0 {
            return Ok(Ids { bits, packed: Vec::new() });
        }
        let length = samples as u128 * u128::from(bits);
        let count = usize::try_from(length.div_ceil(8)).unwrap_or(usize::MAX);
        let ids = Ids { bits, packed: source.take_exact(section, count)? };
        if let Some(sample) = (0..samples).find(|&sample| ids.at(sample) as usize >= clusters) {
            let found = format!("{} of sample {sample}", ids.at(sample));
            return Err(broken(section, format!("clusters below {clusters}"), found));
        }
        Ok(ids)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unpacked(ids: &Ids, count: usize) -> Vec<u32> {
        (0..count).map(|i| ids.at(i)).collect()
    }

    #[test]
    fn an_id_takes_as_many_bits_as_its_clusters_need() {
        let sizes = [(0, 0), (1, 0), (2, 1), (3, 2), (256, 8), (257, 9), (65_536, 16), (1 << 32, 32)];
        assert!(sizes.iter().all(|&(clusters, bits)| bits_of(clusters) == bits));
        assert_eq!(Ids::pack(&[1, 0, 2, 3, 1], 4).packed, [0b1110_0001, 0b01]);
    }

    proptest! {
        #[test]
        fn ids_come_back_from_memory_and_from_a_section(
            bits in 1u32..=32, seed in prop::collection::vec(any::<u32>(), 1..70),
        ) {
            let clusters = (1usize << bits) - bits as usize / 2;
            let ids: Vec<u32> = seed.iter().map(|s| (*s as usize % clusters) as u32).collect();
            let packed = Ids::pack(&ids, clusters);
            prop_assert_eq!(&unpacked(&packed, ids.len()), &ids);
            let mut part = vec![0; ids.len() / 2];
            packed.fill(ids.len() - part.len(), &mut part);
            prop_assert_eq!(&part[..], &ids[ids.len() - part.len()..]);
            let mut sink = Sink::new();
            packed.write(&mut sink);
            let mut source = Source::new(sink.into_sections()).unwrap();
            prop_assert_eq!(Ids::read(&mut source, ids.len(), clusters).unwrap(), packed);
        }
    }

    #[test]
    fn an_id_beyond_the_clusters_is_refused() {
        let mut sink = Sink::new();
        Ids::pack(&[0, 3, 1], 4).write(&mut sink);
        let mut source = Source::new(sink.into_sections()).unwrap();
        let told = Ids::read(&mut source, 3, 3).unwrap_err().to_string();
        assert!(told.contains("3 of sample 1"), "{told}");
    }
}
