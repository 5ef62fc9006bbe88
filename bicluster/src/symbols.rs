//! The elements of a block of rows as symbols: a symbol is a light coefficient times a value.
//!
//! Values are told apart by their bits, so that any finite `f32` comes back exactly; multiplications are done once per symbol
//! of a block and not once per element.

/// A light coefficient times a value.
pub(crate) type Leaf = (u32, f32);

/// Symbols that a block may have: they are numbered in two bytes.
pub(crate) const SYMBOLS: usize = 1 << 16;
/// Leaves that a block may have, so that as many sums are left.
const LEAVES: usize = 1 << 15;

/// Rows of a block in symbols.
pub(crate) struct Symbols {
    /// By value, 1 first, then by column.
    pub(crate) leaves: Vec<Leaf>,
    /// Ascending indices into `leaves` for each row.
    pub(crate) rows: Vec<Vec<u16>>,
    /// For each row the elements that are no leaves, columns ascending.
    pub(crate) left: Vec<Vec<Leaf>>,
}

impl Symbols {
    /// Elements that occur in several rows become leaves; those of one row only as well, where they are few, and those of the
    /// first `whole` rows in any case.
    pub(crate) fn of(rows: &[Vec<Leaf>], whole: usize) -> Symbols {
        let mut elements: Vec<(u64, u32)> = Vec::with_capacity(rows.iter().map(Vec::len).sum());
        for (row, leaves) in rows.iter().enumerate() {
            elements.extend(leaves.iter().map(|&leaf| (key(leaf), row as u32)));
        }
        elements.sort_unstable();
        let counts: Vec<usize> = elements.chunk_by(|a, b| a.0 == b.0).map(<[_]>::len).collect();
        let single = counts.iter().filter(|&&n| n == 1).count();
        // One row's element costs more as a leaf than in a sparse row, but a sparse row of its own costs too.
        let least = if single > rows.len() { 2 } else { 1 };
        let mut chosen = most_frequent(&counts, least).into_iter();
        let mut symbols =
            Symbols { leaves: Vec::new(), rows: vec![Vec::new(); rows.len()], left: vec![Vec::new(); rows.len()] };
        for group in elements.chunk_by(|a, b| a.0 == b.0) {
            if chosen.next() == Some(true) || (group[0].1 as usize) < whole {
                let symbol = symbols.leaves.len() as u16;
                symbols.leaves.push(leaf(group[0].0));
                group.iter().for_each(|&(_, row)| symbols.rows[row as usize].push(symbol));
            } else {
                group.iter().for_each(|&(key, row)| symbols.left[row as usize].push(leaf(key)));
            }
        }
        symbols.left.iter_mut().for_each(|row| row.sort_unstable_by_key(|l| l.0));
        symbols
    }
}

/// Which counts are at least `least` and among the [`LEAVES`] largest, the first of equal ones.
fn most_frequent(counts: &[usize], least: usize) -> Vec<bool> {
    let mut order: Vec<usize> = (0..counts.len()).filter(|&i| counts[i] >= least).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(counts[i]));
    let mut chosen = vec![false; counts.len()];
    order.into_iter().take(LEAVES).for_each(|i| chosen[i] = true);
    chosen
}

/// Orders leaves by value, 1 before all others, then by column. No value is 0, so its bits are never 0.
pub(crate) fn key((column, value): Leaf) -> u64 {
    let bits = if value == 1.0 { 0 } else { value.to_bits() };
    u64::from(bits) << 32 | u64::from(column)
}

fn leaf(key: u64) -> Leaf {
    let bits = (key >> 32) as u32;
    (key as u32, if bits == 0 { 1.0 } else { f32::from_bits(bits) })
}
