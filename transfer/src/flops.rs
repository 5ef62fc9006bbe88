//! Floating-point operations, counted by the kernels that do them.
//!
//! A kernel is generic over [`Count`]. Relighting runs it with [`NoCount`], which compiles to nothing; [`crate::Encoded::flops`]
//! runs the same kernel with a [`Tally`]. A product accumulated onto a sum is one multiplication and one addition, so that the
//! papers' count for a sparse product, 2·nnz, is [`Flops::total`]. Unpacking a stored number (a half or an integer times a
//! power of two) is decoding and not counted; a factor that differs from row to row is. A multiplication by 1 or -1 costs nothing in a kernel that
//! knows its values: [`Flops::value_aware`] leaves those out.

use std::ops::{Add, AddAssign};

/// Floating-point operations of one relighting with one light vector of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flops {
    /// Multiplications, whatever their factors.
    pub multiplications: u64,
    /// Additions and subtractions, the one that accumulates onto zero included.
    pub additions: u64,
    /// Those of the multiplications that have a stored factor of 1 or -1.
    pub by_one: u64,
}

impl Flops {
    /// Multiplications and additions together: the papers' count.
    pub fn total(&self) -> u64 {
        self.multiplications + self.additions
    }
    /// As [`Flops::total`], with multiplications by 1 and -1 free.
    pub fn value_aware(&self) -> u64 {
        self.total() - self.by_one
    }
}

impl Add for Flops {
    type Output = Flops;
    fn add(self, o: Flops) -> Flops {
        Flops {
            multiplications: self.multiplications + o.multiplications,
            additions: self.additions + o.additions,
            by_one: self.by_one + o.by_one,
        }
    }
}

impl AddAssign for Flops {
    fn add_assign(&mut self, o: Flops) {
        *self = *self + o;
    }
}

/// What a kernel tells of its own arithmetic.
pub trait Count {
    /// `n` products, each accumulated onto a sum.
    fn multiply_add(&mut self, n: usize);
    /// `n` multiplications.
    fn multiply(&mut self, n: usize);
    /// `n` additions.
    fn add(&mut self, n: usize);
    /// These stored factors have just been multiplied by; the implementation counts those equal to 1 or -1.
    fn factors(&mut self, factors: impl Iterator<Item = f32>);
}

/// Counts nothing and costs nothing.
pub struct NoCount;

impl Count for NoCount {
    #[inline(always)]
    fn multiply_add(&mut self, _: usize) {}
    #[inline(always)]
    fn multiply(&mut self, _: usize) {}
    #[inline(always)]
    fn add(&mut self, _: usize) {}
    #[inline(always)]
    fn factors(&mut self, _: impl Iterator<Item = f32>) {}
}

/// Adds up what a kernel tells.
#[derive(Default)]
pub struct Tally(
    /// The sum so far.
    pub Flops,
);

impl Count for Tally {
    fn multiply_add(&mut self, n: usize) {
        self.multiply(n);
        self.add(n);
    }
    fn multiply(&mut self, n: usize) {
        self.0.multiplications += n as u64;
    }
    fn add(&mut self, n: usize) {
        self.0.additions += n as u64;
    }
    fn factors(&mut self, factors: impl Iterator<Item = f32>) {
        self.0.by_one += factors.filter(|f| f.abs() == 1.0).count() as u64;
    }
}
