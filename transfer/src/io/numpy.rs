//! The header of a NumPy array file (`.npy`, and each entry of an `.npz`), format versions 1 to 3.

use super::Place;
use super::element::{ElementType, Elements};
use crate::error::Result;
use std::io::Read;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// A header is a short dictionary; NumPy itself refuses more than 10,000 bytes from a stranger.
const LONGEST: usize = 1 << 16;

/// What the header says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArrayHeader {
    pub(super) element: ElementType,
    /// First axis fastest.
    pub(super) fortran: bool,
    pub(super) shape: Vec<usize>,
}

impl ArrayHeader {
    pub(super) fn read(reader: &mut impl Read, place: Place) -> Result<ArrayHeader> {
        let mut start = [0; 8];
        reader.read_exact(&mut start).map_err(|e| place.unreadable("the 8 bytes before an array's header", &e))?;
        if &start[..6] != MAGIC {
            return Err(place.broken("a NumPy array (\\x93NUMPY)", format!("'{}'", start[..6].escape_ascii())));
        }
        let mut length = [0; 4];
        let width = match start[6] {
            1 => 2,
            2 | 3 => 4,
            version => return Err(place.broken("NumPy format version 1, 2 or 3", version.to_string())),
        };
        reader.read_exact(&mut length[..width]).map_err(|e| place.unreadable("the header's length", &e))?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(place.broken(format!("a header of at most {LONGEST} bytes"), length.to_string()));
        }
        let mut text = vec![0; length];
        reader.read_exact(&mut text).map_err(|e| place.unreadable(format!("a header of {length} bytes"), &e))?;
        let text = String::from_utf8_lossy(&text);
        Literal { rest: text.trim(), place }.header()
    }

    /// Elements of the whole array.
    pub(super) fn count(&self, place: Place) -> Result<usize> {
        let count = self.shape.iter().try_fold(1usize, |n, &axis| n.checked_mul(axis));
        let bytes = count.and_then(|n| n.checked_mul(self.element.size.max(8)));
        match (count, bytes) {
            (Some(count), Some(bytes)) if bytes <= isize::MAX as usize => Ok(count),
            _ => Err(place.broken("an array that memory can address", format!("shape {:?}", self.shape))),
        }
    }
    /// The array's elements; `earned` bytes are known to lie behind `reader`.
    pub(super) fn elements<'a, R: Read>(&self, reader: R, earned: u64, place: Place<'a>) -> Result<Elements<'a, R>> {
        Ok(Elements { reader, element: self.element, count: self.count(place)?, earned, place })
    }
}

/// Header and padding of a C-order array, as format version 1 writes it: a multiple of 64 bytes.
pub(super) fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let axes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let tuple = if axes.len() == 1 { format!("({},)", axes[0]) } else { format!("({})", axes.join(", ")) };
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {tuple}, }}");
    let padding = (64 - (10 + text.len() + 1) % 64) % 64;
    text.extend(std::iter::repeat_n(' ', padding));
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    // Three axes of 20 digits each stay far below 65,536 bytes.
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// The dictionary, a Python literal: `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }`.
struct Literal<'a> {
    rest: &'a str,
    place: Place<'a>,
}

impl<'a> Literal<'a> {
    fn header(mut self) -> Result<ArrayHeader> {
        let (mut element, mut fortran, mut shape) = (None, None, None);
        self.expect('{')?;
        while !self.take('}') {
            let key = self.string()?;
            self.expect(':')?;
            match key {
                "descr" => element = Some(ElementType::parse(self.string()?, self.place)?),
                "fortran_order" => fortran = Some(self.boolean()?),
                "shape" => shape = Some(self.tuple()?),
                _ => return Err(self.place.broken("descr, fortran_order, shape", format!("key '{key}'"))),
            }
            if !self.take(',') {
                self.expect('}')?;
                break;
            }
        }
        let missing = |key: &str| self.place.broken(format!("'{key}' in the header"), "none");
        Ok(ArrayHeader {
            element: element.ok_or_else(|| missing("descr"))?,
            fortran: fortran.ok_or_else(|| missing("fortran_order"))?,
            shape: shape.ok_or_else(|| missing("shape"))?,
        })
    }

    fn take(&mut self, letter: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(letter) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }
    fn expect(&mut self, letter: char) -> Result<()> {
        if self.take(letter) { Ok(()) } else { Err(self.unexpected(&format!("'{letter}' in the header"))) }
    }
    fn unexpected(&self, expected: &str) -> crate::Error {
        self.place.broken(expected, format!("'{}'", self.rest.chars().take(24).collect::<String>()))
    }
    fn string(&mut self) -> Result<&'a str> {
        let quote = if self.take('\'') {
            '\''
        } else if self.take('"') {
            '"'
        } else if self.take('[') {
            return Err(self.unexpected("one element type, not the fields of a structure"));
        } else {
            return Err(self.unexpected("a string in the header"));
        };
        let Some((text, rest)) = self.rest.split_once(quote) else {
            return Err(self.unexpected("a closing quote in the header"));
        };
        self.rest = rest;
        Ok(text)
    }
    fn boolean(&mut self) -> Result<bool> {
        self.rest = self.rest.trim_start();
        for (word, value) in [("True", true), ("False", false)] {
            if let Some(rest) = self.rest.strip_prefix(word) {
                self.rest = rest;
                return Ok(value);
            }
        }
        Err(self.unexpected("True or False in the header"))
    }
    fn tuple(&mut self) -> Result<Vec<usize>> {
        self.expect('(')?;
        let mut axes = Vec::new();
        while !self.take(')') {
            self.rest = self.rest.trim_start();
            let digits = self.rest.bytes().take_while(u8::is_ascii_digit).count();
            let axis = self.rest[..digits].parse().map_err(|_| self.unexpected("a size in the header's shape"))?;
            // Python 2 wrote long integers as 3L.
            self.rest = self.rest[digits..].trim_start_matches('L');
            axes.push(axis);
            if !self.take(',') {
                self.expect(')')?;
                break;
            }
        }
        // NumPy's own limit.
        if axes.len() > 64 { Err(self.place.broken("at most 64 axes", axes.len().to_string())) } else { Ok(axes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place = Place { format: "npy", name: "header" };

    #[test]
    fn a_written_header_reads_back_and_keeps_the_data_aligned() {
        for shape in [vec![], vec![7], vec![3, 4], vec![2, 0, usize::MAX]] {
            let bytes = header("<f4", &shape);
            assert_eq!(bytes.len() % 64, 0);
            let read = ArrayHeader::read(&mut bytes.as_slice(), PLACE).unwrap();
            assert_eq!((read.shape, read.fortran), (shape, false));
        }
    }

    #[test]
    fn spacing_quotes_order_and_long_integers_do_not_matter() {
        let read = |text: &str| {
            let mut bytes = b"\x93NUMPY\x03\x00".to_vec();
            bytes.extend((text.len() as u32).to_le_bytes());
            bytes.extend(text.as_bytes());
            ArrayHeader::read(&mut bytes.as_slice(), PLACE)
        };
        let header = read("{\"shape\" :(3L,4L),'fortran_order':True,'descr':'>u2'}\n").unwrap();
        assert_eq!((header.shape, header.fortran, header.element.big_endian), (vec![3, 4], true, true));
        for wrong in [
            "",
            "{",
            "{}",
            "{'descr': '<f4'}",
            "{'descr': '<f4', 'fortran_order': 1, 'shape': ()}",
            "{'descr': '<c8', 'fortran_order': False, 'shape': ()}",
            "{'descr': '|O', 'fortran_order': False, 'shape': ()}",
            "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': ()}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
