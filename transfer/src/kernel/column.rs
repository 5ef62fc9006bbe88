//! Column indices as they are stored: 1, 2 or 4 bytes.

/// A stored index of a column, or of an entry of a table.
pub trait Column: Copy + Send + Sync + 'static {
    /// As an index.
    fn at(self) -> usize;

    /// Eight indices in a row, by as few loads as their width allows.
    ///
    /// # Safety
    /// `first` must point to eight readable indices.
    unsafe fn eight(first: *const Self) -> [usize; 8];

    /// As [`Column::eight`], four.
    ///
    /// # Safety
    /// `first` must point to four readable indices.
    unsafe fn four(first: *const Self) -> [usize; 4];
}

impl Column for u8 {
    #[inline(always)]
    fn at(self) -> usize {
        self.into()
    }
    #[inline(always)]
    unsafe fn eight(first: *const u8) -> [usize; 8] {
        // SAFETY: eight bytes, as the caller promises.
        let word = unsafe { first.cast::<u64>().read_unaligned() };
        std::array::from_fn(|i| (word >> (8 * i)) as u8 as usize)
    }
    #[inline(always)]
    unsafe fn four(first: *const u8) -> [usize; 4] {
        // SAFETY: four bytes, as the caller promises.
        let word = unsafe { first.cast::<u32>().read_unaligned() };
        std::array::from_fn(|i| (word >> (8 * i)) as u8 as usize)
    }
}

impl Column for u16 {
    #[inline(always)]
    fn at(self) -> usize {
        self.into()
    }
    #[inline(always)]
    unsafe fn eight(first: *const u16) -> [usize; 8] {
        // SAFETY: two words of four indices, as the caller promises.
        let words = unsafe { first.cast::<[u64; 2]>().read_unaligned() };
        std::array::from_fn(|i| (words[i / 4] >> (16 * (i % 4))) as u16 as usize)
    }
    #[inline(always)]
    unsafe fn four(first: *const u16) -> [usize; 4] {
        // SAFETY: a word of four indices, as the caller promises.
        let word = unsafe { first.cast::<u64>().read_unaligned() };
        std::array::from_fn(|i| (word >> (16 * i)) as u16 as usize)
    }
}

impl Column for u32 {
    #[inline(always)]
    fn at(self) -> usize {
        self as usize
    }
    #[inline(always)]
    unsafe fn eight(first: *const u32) -> [usize; 8] {
        // SAFETY: four words of two indices, as the caller promises.
        let words = unsafe { first.cast::<[u64; 4]>().read_unaligned() };
        std::array::from_fn(|i| (words[i / 2] >> (32 * (i % 2))) as u32 as usize)
    }
    #[inline(always)]
    unsafe fn four(first: *const u32) -> [usize; 4] {
        // SAFETY: two words of two indices, as the caller promises.
        let words = unsafe { first.cast::<[u64; 2]>().read_unaligned() };
        std::array::from_fn(|i| (words[i / 2] >> (32 * (i % 2))) as u32 as usize)
    }
}
