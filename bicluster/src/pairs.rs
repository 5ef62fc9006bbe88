//! Shared sums of any depth: the pair of symbols that most rows have in common becomes a symbol of its own, again and again.
//!
//! A pair is a bicluster of two columns and as many rows as contain both; in place of the two every such row keeps one
//! symbol, which can be part of a later pair. One addition replaces one in each of those rows. It is Paar's greedy search for
//! common subexpressions of a linear map (1997), the set-valued form of the grammars that replace repeated pairs in text.
//!
//! Counts of pairs only fall while symbols are taken away, so a queue of buckets with lazy recounts finds the largest.
//! The same pairs in the same order, applied to the same rows, give the same result: [`replay`].

use crate::symbols::SYMBOLS;
use std::ops::Range;

/// Two symbols, the smaller first, that make a new one.
pub(crate) type Pair = [u16; 2];

/// Symbols that a symbol shares its rows with, on average, up to which all pairs of a block are counted at once. Where
/// rows are longer, strips of the leaves go first, each by itself.
const PARTNERS: usize = 320;
/// Leaves of a strip at most.
const STRIP: usize = 1024;

/// Replaces pairs that at least `least` rows have in common, in `rows` of symbols below `leaves`; returns the pairs, whose
/// symbols are numbered from `leaves` on. Rows are left ascending.
pub(crate) fn merge(rows: &mut [Vec<u16>], leaves: usize, least: u32) -> Vec<Pair> {
    let mut search = Search::new(rows, leaves, least.max(2));
    if !countable(rows) {
        for strip in strips(&search.occurs, rows.len()) {
            let inside = |s: &u16| strip.contains(s);
            let mut parts: Vec<Vec<u16>> = rows.iter().map(|r| r.iter().copied().filter(inside).collect()).collect();
            search.run(&mut parts, strip.clone());
            rows.iter_mut().zip(parts).for_each(|(row, part)| {
                row.retain(|s| !inside(s));
                row.extend(part);
            });
        }
    }
    if countable(rows) {
        // In strips or not, what the rows hold now is all there is.
        let symbols = search.occurs.len().min(usize::from(u16::MAX)) as u16;
        search.run(rows, 0..symbols);
    }
    rows.iter_mut().for_each(|row| row.sort_unstable());
    search.pairs
}

/// Whether counting the pairs of all rows takes a few steps an element.
fn countable(rows: &[Vec<u16>]) -> bool {
    let elements: usize = rows.iter().map(Vec::len).sum();
    rows.iter().map(|row| row.len() * row.len()).sum::<usize>() <= PARTNERS * elements
}

/// Cuts the leaves, in their order, into strips of which a row has some 160 on average.
fn strips(occurs: &[Bits], rows: usize) -> Vec<Range<u16>> {
    let (mut strips, mut start, mut elements) = (Vec::new(), 0, 0);
    for (leaf, bits) in occurs.iter().enumerate() {
        elements += bits.iter().map(|word| word.count_ones() as usize).sum::<usize>();
        if elements >= PARTNERS / 2 * rows || leaf + 1 - start == STRIP || leaf + 1 == occurs.len() {
            strips.push(start as u16..(leaf + 1) as u16);
            (start, elements) = (leaf + 1, 0);
        }
    }
    strips
}

/// Applies pairs in their order, as [`merge`] did: wherever a row has both symbols, the new one takes their place.
pub(crate) fn replay(rows: &mut [Vec<u16>], leaves: usize, pairs: &[Pair]) {
    let mut occurs = occurrences(rows, leaves);
    for &pair in pairs {
        let both = intersection(&occurs, pair);
        take_away(&mut occurs, pair, &both);
        occurs.push(both);
    }
    rows.iter_mut().for_each(Vec::clear);
    for (symbol, bits) in occurs.iter().enumerate() {
        for_each_bit(bits, |row| rows[row].push(symbol as u16));
    }
}

/// The rows that a symbol occurs in, a bit each.
type Bits = Vec<u64>;

struct Search {
    occurs: Vec<Bits>,
    leaves: usize,
    least: u32,
    pairs: Vec<Pair>,
    /// Scratch of [`Search::partners`]: rows that each symbol shares with the one in question.
    counts: Vec<u32>,
}

impl Search {
    fn new(rows: &[Vec<u16>], leaves: usize, least: u32) -> Search {
        Search { occurs: occurrences(rows, leaves), leaves, least, pairs: Vec::new(), counts: vec![0; leaves] }
    }

    /// Merges pairs of the given symbols, and of those that come of them, until none is left. Rows hold no other symbols.
    fn run(&mut self, rows: &mut [Vec<u16>], symbols: Range<u16>) {
        let mut queue: Vec<Vec<Pair>> = vec![Vec::new(); rows.len() + 1];
        for symbol in symbols {
            let bits = std::mem::take(&mut self.occurs[usize::from(symbol)]);
            self.partners(rows, symbol, &bits, |partner| partner > symbol, &mut queue);
            self.occurs[usize::from(symbol)] = bits;
        }
        for count in (self.least as usize..queue.len()).rev() {
            // Sorted, since equal counts leave the order free and ascending pairs pack well.
            while !queue[count].is_empty() {
                let mut batch = std::mem::take(&mut queue[count]);
                batch.sort_unstable();
                batch.into_iter().for_each(|pair| self.consider(rows, pair, count as u32, &mut queue));
            }
        }
    }

    /// Merges a pair if it still occurs `count` times; puts it back if it occurs less often.
    fn consider(&mut self, rows: &mut [Vec<u16>], pair: Pair, count: u32, queue: &mut [Vec<Pair>]) {
        if self.leaves + self.pairs.len() == SYMBOLS {
            return;
        }
        let both = intersection(&self.occurs, pair);
        let now: u32 = both.iter().map(|word| word.count_ones()).sum();
        if now < count {
            if now >= self.least {
                queue[now as usize].push(pair);
            }
            return;
        }
        let symbol = apply(&mut self.occurs, rows, pair, both.clone());
        self.pairs.push(pair);
        self.counts.push(0);
        self.partners(rows, symbol, &both, |_| true, queue);
    }

    /// Queues the pairs of `symbol`, which occurs in the rows `bits`, with partners that `wanted` lets through.
    fn partners(
        &mut self,
        rows: &[Vec<u16>],
        symbol: u16,
        bits: &[u64],
        wanted: impl Fn(u16) -> bool,
        queue: &mut [Vec<Pair>],
    ) {
        let mut touched = Vec::new();
        for_each_bit(bits, |row| {
            for &partner in rows[row].iter().filter(|&&p| p != symbol && wanted(p)) {
                let count = &mut self.counts[usize::from(partner)];
                if *count == 0 {
                    touched.push(partner);
                }
                *count += 1;
            }
        });
        for partner in touched {
            let count = std::mem::take(&mut self.counts[usize::from(partner)]);
            if count >= self.least {
                queue[count as usize].push([symbol.min(partner), symbol.max(partner)]);
            }
        }
    }
}

fn occurrences(rows: &[Vec<u16>], symbols: usize) -> Vec<Bits> {
    let mut occurs = vec![vec![0; rows.len().div_ceil(64)]; symbols];
    for (row, symbols) in rows.iter().enumerate() {
        symbols.iter().for_each(|&s| occurs[usize::from(s)][row / 64] |= 1 << (row % 64));
    }
    occurs
}

fn intersection(occurs: &[Bits], [a, b]: Pair) -> Bits {
    occurs[usize::from(a)].iter().zip(&occurs[usize::from(b)]).map(|(a, b)| a & b).collect()
}

/// Replaces the pair by a new symbol in the rows `both`.
fn apply(occurs: &mut Vec<Bits>, rows: &mut [Vec<u16>], pair: Pair, both: Bits) -> u16 {
    let symbol = occurs.len() as u16;
    take_away(occurs, pair, &both);
    for_each_bit(&both, |row| {
        rows[row].retain(|s| !pair.contains(s));
        rows[row].push(symbol);
    });
    occurs.push(both);
    symbol
}

fn take_away(occurs: &mut [Bits], pair: Pair, both: &[u64]) {
    for part in pair {
        occurs[usize::from(part)].iter_mut().zip(both).for_each(|(word, both)| *word &= !both);
    }
}

fn for_each_bit(bits: &[u64], mut visit: impl FnMut(usize)) {
    for (index, &word) in bits.iter().enumerate() {
        let mut word = word;
        while word != 0 {
            visit(64 * index + word.trailing_zeros() as usize);
            word &= word - 1;
        }
    }
}
