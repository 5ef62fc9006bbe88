//! The Stanford polygon format, PLY 1.0.

use super::broken;
use super::mesh::{build, chart, fan};
use crate::chart::Charted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use glam::{Vec2, Vec3};

/// The types of scalars, by either of their names.
#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

enum Property {
    Scalar { name: String, kind: Scalar },
    List { name: String, count: Scalar, kind: Scalar },
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh> {
    Ok(read_all(bytes)?.0)
}

pub(super) fn read_charted(bytes: &[u8]) -> Result<Charted> {
    let (mesh, uv) = read_all(bytes)?;
    chart("ply", mesh, uv)
}

/// What vertices have; normals and texture coordinates of all of them or of none.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uv: Vec<Vec2>,
}

fn read_all(bytes: &[u8]) -> Result<(Mesh, Vec<Vec2>)> {
    let (encoding, elements, length) = header(bytes)?;
    let line = 1 + bytes[..length].iter().filter(|&&b| b == b'\n').count();
    let mut body = Body { bytes, at: length, line, encoding };
    let (mut vertices, mut faces) = (Vertices::default(), Vec::new());
    for element in &elements {
        // Nothing to read, however many there are.
        if element.properties.is_empty() {
            continue;
        }
        match element.name.as_str() {
            "vertex" => read_vertices(&mut body, element, &mut vertices)?,
            "face" => read_faces(&mut body, element, &mut faces)?,
            _ => (0..element.count).try_for_each(|_| body.skip(element))?,
        }
    }
    for needed in ["vertex", "face"] {
        if !elements.iter().any(|e| e.name == needed) {
            return Err(broken("ply", "header", format!("an element '{needed}'"), "none"));
        }
    }
    Ok((build("ply", vertices.positions, vertices.normals, faces)?, vertices.uv))
}

/// Encoding, elements and the length of the header in bytes.
fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize)> {
    let (mut encoding, mut elements, mut at) = (None, Vec::<Element>::new(), 0);
    let mut number = 0;
    loop {
        number += 1;
        let wrong = |expected: &str, found: &str| {
            broken(
                "ply",
                format!("line {number}"),
                expected,
                format!("'{}'", found.chars().take(60).collect::<String>()),
            )
        };
        let Some(end) = bytes[at..].iter().position(|&b| b == b'\n') else {
            return Err(wrong("end_header", "the end of the file"));
        };
        let line = String::from_utf8_lossy(&bytes[at..at + end]);
        at += end + 1;
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(wrong("ply", &line)),
            ["format", kind, "1.0"] => {
                encoding = Some(match kind {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(wrong("ascii, binary_little_endian or binary_big_endian", kind)),
                });
            }
            ["comment" | "obj_info", ..] | [] => {}
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("a number of elements", count))?;
                elements.push(Element { name: name.into(), count, properties: Vec::new() });
            }
            ["property", ref property @ ..] => {
                let parsed = match *property {
                    ["list", count, kind, name] => {
                        Scalar::parse(count).zip(Scalar::parse(kind)).and_then(|(count, kind)| {
                            let whole = !matches!(count, Scalar::F32 | Scalar::F64);
                            whole.then(|| Property::List { name: name.into(), count, kind })
                        })
                    }
                    [kind, name] => Scalar::parse(kind).map(|kind| Property::Scalar { name: name.into(), kind }),
                    _ => None,
                };
                match (elements.last_mut(), parsed) {
                    (Some(element), Some(property)) => element.properties.push(property),
                    _ => return Err(wrong("property TYPE NAME or property list TYPE TYPE NAME of an element", &line)),
                }
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| wrong("a line 'format' before end_header", "none"))?;
                return Ok((encoding, elements, at));
            }
            _ => return Err(wrong("format, comment, element, property or end_header", &line)),
        }
    }
}

fn read_vertices(body: &mut Body, element: &Element, vertices: &mut Vertices) -> Result<()> {
    let find = |wanted: &str| {
        element.properties.iter().position(|p| matches!(p, Property::Scalar { name, .. } if name == wanted))
    };
    let three = |names: [&str; 3]| Some([find(names[0])?, find(names[1])?, find(names[2])?]);
    let Some(position) = three(["x", "y", "z"]) else {
        return Err(broken("ply", "element 'vertex'", "scalar properties x, y, z", "not all of them"));
    };
    let normal = three(["nx", "ny", "nz"]);
    let pairs = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
    let texture = pairs.iter().find_map(|names| find(names[0]).zip(find(names[1])));
    let mut row = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        for (property, value) in element.properties.iter().zip(&mut row) {
            match property {
                Property::Scalar { kind, .. } => *value = body.number(*kind)?,
                Property::List { count, kind, .. } => body.skip_list(*count, *kind)?,
            }
        }
        let pick = |at: [usize; 3]| Vec3::from(at.map(|i| row[i] as f32));
        vertices.positions.push(pick(position));
        vertices.normals.extend(normal.map(pick));
        vertices.uv.extend(texture.map(|(u, v)| Vec2::new(row[u] as f32, row[v] as f32)));
    }
    Ok(())
}

fn read_faces(body: &mut Body, element: &Element, faces: &mut Vec<[u32; 3]>) -> Result<()> {
    let is_polygon =
        |p: &Property| matches!(p, Property::List { name, .. } if name == "vertex_indices" || name == "vertex_index");
    let Some(polygon) = element.properties.iter().position(is_polygon) else {
        return Err(broken("ply", "element 'face'", "a list vertex_indices or vertex_index", "none"));
    };
    let mut corners = Vec::new();
    for _ in 0..element.count {
        for (at, property) in element.properties.iter().enumerate() {
            match property {
                Property::Scalar { kind, .. } => drop(body.number(*kind)?),
                Property::List { count, kind, .. } if at == polygon => {
                    corners.clear();
                    for _ in 0..body.index(*count)? {
                        corners.push(body.index(*kind)?);
                    }
                    fan(&corners, faces);
                }
                Property::List { count, kind, .. } => body.skip_list(*count, *kind)?,
            }
        }
    }
    Ok(())
}

impl Scalar {
    fn parse(name: &str) -> Option<Scalar> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }
}

/// The elements after the header, number by number.
struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
}

impl Body<'_> {
    fn broken(&self, expected: &str, found: impl Into<String>) -> Error {
        let place = match self.encoding {
            Encoding::Ascii => format!("line {}", self.line),
            _ => format!("byte {}", self.at),
        };
        broken("ply", place, expected, found)
    }
    /// Every type's values are exact in `f64`.
    fn number(&mut self, kind: Scalar) -> Result<f64> {
        if self.encoding == Encoding::Ascii {
            return self.word();
        }
        Ok(match kind {
            Scalar::I8 => i8::from_le_bytes(self.raw()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.raw()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.raw()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.raw()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.raw()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.raw()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.raw()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.raw()?),
        })
    }
    fn raw<const N: usize>(&mut self) -> Result<[u8; N]> {
        let Some(found) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(self.broken("another number", "the end of the file"));
        };
        let mut found = *found;
        self.at += N;
        if self.encoding == Encoding::Big {
            found.reverse();
        }
        Ok(found)
    }
    fn word(&mut self) -> Result<f64> {
        let blank = self.bytes[self.at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.line += self.bytes[self.at..self.at + blank].iter().filter(|&&b| b == b'\n').count();
        self.at += blank;
        let rest = &self.bytes[self.at..];
        let word = &rest[..rest.iter().take_while(|b| !b.is_ascii_whitespace()).count()];
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        let shown = || match word {
            [] => "the end of the file".into(),
            _ => format!("'{}'", word[..word.len().min(40)].escape_ascii()),
        };
        let number = number.ok_or_else(|| self.broken("a number", shown()))?;
        self.at += word.len();
        Ok(number)
    }
    fn index(&mut self, kind: Scalar) -> Result<u32> {
        let number = self.number(kind)?;
        // Every u32 is exact in f64.
        if number == f64::from(number as u32) {
            Ok(number as u32)
        } else {
            Err(self.broken("an index from 0 to 4294967295", number.to_string()))
        }
    }
    fn skip_list(&mut self, count: Scalar, kind: Scalar) -> Result<()> {
        (0..self.index(count)?).try_for_each(|_| self.number(kind).map(drop))
    }
    fn skip(&mut self, element: &Element) -> Result<()> {
        element.properties.iter().try_for_each(|property| match property {
            Property::Scalar { kind, .. } => self.number(*kind).map(drop),
            Property::List { count, kind, .. } => self.skip_list(*count, *kind),
        })
    }
}
