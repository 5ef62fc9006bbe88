//! What the faces of an .obj say of their corners.
//!
//! Where a corner has no texture coordinates or no normal, tobj makes them up; where an index is far beyond what there is, its
//! arithmetic overflows.

/// The statements that corners have indices of, in the order of these.
const KINDS: [&str; 3] = ["v", "vt", "vn"];
pub(super) const TEXTURE: usize = 1;
pub(super) const NORMAL: usize = 2;

/// Of each kind, and as far as the file has been read.
#[derive(Clone, Copy)]
pub(super) struct Faces {
    /// How many there were; `None` where they are passed over.
    seen: [Option<i64>; 3],
    /// Which faces have them.
    pub(super) lines: [Lines; 3],
    /// The line of a face with an index beyond; 0 for none.
    pub(super) beyond: usize,
}

/// The first line of a face that has something at every corner, and that of a face that does not; 0 for none.
#[derive(Clone, Copy, Default)]
pub(super) struct Lines {
    pub(super) with: usize,
    pub(super) without: usize,
}

impl Faces {
    /// Before the first of the statements, which begin with one of `words`.
    pub(super) fn new(words: &[&str]) -> Faces {
        Faces { seen: KINDS.map(|kind| words.contains(&kind).then_some(0)), lines: Default::default(), beyond: 0 }
    }

    pub(super) fn after(mut self, statement: &[u8], line: usize) -> Faces {
        let mut words = statement.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let first = words.next().unwrap_or_default();
        if let Some(kind) = KINDS.iter().position(|kind| kind.as_bytes() == first) {
            self.seen[kind] = self.seen[kind].map(|count| count + 1);
            return self;
        }
        let corners: Vec<[i64; 3]> = words.map(indices).collect();
        // A point or a line.
        if corners.len() < 3 {
            return self;
        }
        for (kind, lines) in self.lines.iter_mut().enumerate() {
            let mut indices = corners.iter().map(|corner| corner[kind]);
            lines.add(indices.clone().all(|index| index != 0), line);
            let mut beyond = |seen: i64| indices.any(|index| index < -seen || index > u32::MAX.into());
            if self.seen[kind].is_some_and(&mut beyond) {
                self.beyond = line;
            }
        }
        self
    }
}

impl Lines {
    fn add(&mut self, has: bool, line: usize) {
        let first = if has { &mut self.with } else { &mut self.without };
        if *first == 0 {
            *first = line;
        }
    }
}

/// The indices of v/vt/vn, 0 for those that are empty, not there or no numbers.
fn indices(corner: &[u8]) -> [i64; 3] {
    let mut parts = corner.split(|&b| b == b'/');
    let index = |part: &[u8]| std::str::from_utf8(part).ok().and_then(|text| text.parse().ok());
    std::array::from_fn(|_| parts.next().and_then(index).unwrap_or(0))
}
