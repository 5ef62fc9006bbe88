//! Wavefront OBJ through tobj, which is handed only the statements that matter here.
//!
//! Taking out groups and materials keeps vertices shared across them; taking out comments and names lets them be in any
//! encoding; handing over one statement at a time tells on which line parsing stopped.

mod faces;

use super::broken;
use super::mesh::{build, chart, without_chart};
use crate::chart::Charted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use faces::{Faces, Lines, NORMAL, TEXTURE};
use glam::{Vec2, Vec3};
use std::cell::Cell;
use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use tobj::{LoadError, LoadOptions};

pub(super) fn read(bytes: &[u8]) -> Result<Mesh> {
    let (mesh, faces) = load(bytes, &["v", "vn", "f"])?;
    let (positions, normals) = (vectors(&mesh.positions), vectors(&mesh.normals));
    if !has_normals(&mesh, faces) {
        return build("obj", positions, Vec::new(), triangles(&mesh.indices));
    }
    let (vertices, corners) = split(mesh.indices.iter().zip(&mesh.normal_indices).map(|(&p, &n)| [p, n]));
    let (positions, normals) = vertices.iter().map(|&[p, n]| (pick(&positions, p), pick(&normals, n))).unzip();
    build("obj", positions, normals, triangles(&corners))
}

pub(super) fn read_charted(bytes: &[u8]) -> Result<Charted> {
    let (mesh, faces) = load(bytes, &["v", "vn", "vt", "f"])?;
    let Lines { with, without } = faces.lines[TEXTURE];
    if mesh.texcoord_indices.len() != mesh.indices.len() || with == 0 {
        return Err(without_chart("obj"));
    }
    if without > 0 {
        let expected = format!("texture coordinates at every corner, as on line {with}");
        return Err(broken("obj", format!("line {without}"), expected, "a corner without"));
    }
    let (positions, normals) = (vectors(&mesh.positions), vectors(&mesh.normals));
    let (uv, _) = mesh.texcoords.as_chunks::<2>();
    let smooth = has_normals(&mesh, faces);
    let normal = |corner: usize| if smooth { mesh.normal_indices[corner] } else { 0 };
    let corners = mesh.indices.iter().zip(&mesh.texcoord_indices).enumerate();
    let (vertices, corners) = split(corners.map(|(corner, (&p, &t))| [p, normal(corner), t]));
    let at = |from: &[Vec3], i: usize| vertices.iter().map(|vertex| pick(from, vertex[i])).collect::<Vec<_>>();
    let normals = if smooth { at(&normals, 1) } else { Vec::new() };
    let uv = vertices.iter().map(|&[.., t]| uv.get(t as usize).map_or(Vec2::NAN, |&uv| uv.into())).collect();
    chart("obj", build("obj", at(&positions, 0), normals, triangles(&corners))?, uv)
}

/// Whether every corner has a normal of the file's.
fn has_normals(mesh: &tobj::Mesh, faces: Faces) -> bool {
    mesh.normal_indices.len() == mesh.indices.len() && faces.lines[NORMAL].without == 0
}

/// What tobj makes of the statements that begin with one of `words`.
fn load(bytes: &[u8], words: &[&str]) -> Result<(tobj::Mesh, Faces)> {
    let (line, faces) = (Cell::new(0), Cell::new(Faces::new(words)));
    let mut statements = Statements { words, rest: bytes, line: &line, faces: &faces, current: Vec::new(), at: 0 };
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let loaded = tobj::load_obj_buf(&mut statements, &options, |_| Err(LoadError::OpenFileFailed));
    let faces = faces.get();
    if faces.beyond > 0 {
        let place = format!("line {}", faces.beyond);
        return Err(broken("obj", place, "indices of v, vt and vn that are there", "one beyond"));
    }
    let (models, _) = loaded.map_err(|e| parsing_stopped(&e, line.get(), words))?;
    // Without groups there is one model.
    let mesh = models.into_iter().map(|model| model.mesh).find(|mesh| !mesh.indices.is_empty());
    let mesh = mesh.ok_or_else(|| broken("obj", "faces", "at least one face of three vertices", "none"))?;
    Ok((mesh, faces))
}

fn parsing_stopped(error: &LoadError, line: usize, words: &[&str]) -> Error {
    use LoadError::{FaceNormalOutOfBounds, FaceTexCoordOutOfBounds, FaceVertexOutOfBounds};
    // Indices are checked only once everything has been parsed.
    let late = matches!(error, FaceVertexOutOfBounds | FaceNormalOutOfBounds | FaceTexCoordOutOfBounds);
    let place = if late { "faces".into() } else { format!("line {line}") };
    let (last, others) = words.split_last().unwrap_or((&"", &[]));
    broken("obj", place, format!("a statement {} or {last}", others.join(", ")), error.to_string())
}

/// A vertex for each tuple of indices that some corner has, in the order of their first corners; and the vertex of each corner.
fn split<const N: usize>(corners: impl Iterator<Item = [u32; N]>) -> (Vec<[u32; N]>, Vec<u32>) {
    let (mut known, mut vertices) = (HashMap::new(), Vec::new());
    let number = |corner| {
        *known.entry(corner).or_insert_with(|| {
            vertices.push(corner);
            vertices.len() as u32 - 1
        })
    };
    let corners = corners.map(number).collect();
    (vertices, corners)
}

fn vectors(numbers: &[f32]) -> Vec<Vec3> {
    numbers.as_chunks::<3>().0.iter().map(|&v| Vec3::from(v)).collect()
}

fn pick(from: &[Vec3], at: u32) -> Vec3 {
    from.get(at as usize).copied().unwrap_or(Vec3::ZERO)
}

fn triangles(indices: &[u32]) -> Vec<[u32; 3]> {
    indices.as_chunks().0.to_vec()
}

/// Hands out one statement at a time.
struct Statements<'a> {
    /// What the statements begin with that are not passed over.
    words: &'a [&'a str],
    rest: &'a [u8],
    /// Lines taken so far.
    line: &'a Cell<usize>,
    faces: &'a Cell<Faces>,
    current: Vec<u8>,
    at: usize,
}

impl Statements<'_> {
    /// Takes lines up to the next statement that counts, continued lines joined.
    fn advance(&mut self) {
        (self.current, self.at) = (Vec::new(), 0);
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|&b| b == b'\n').map_or(self.rest.len(), |at| at + 1);
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest;
            self.line.set(self.line.get() + 1);
            let line = line.trim_ascii();
            if let Some(begun) = line.strip_suffix(b"\\") {
                self.current.extend(begun);
                self.current.push(b' ');
                continue;
            }
            self.current.extend(line);
            let word = self.current.split(u8::is_ascii_whitespace).find(|w| !w.is_empty()).unwrap_or_default();
            if self.words.iter().any(|known| known.as_bytes() == word) {
                // A trailing comment is no number.
                let end = self.current.iter().position(|&b| b == b'#').unwrap_or(self.current.len());
                self.current.truncate(end);
                self.faces.set(self.faces.get().after(&self.current, self.line.get()));
                if self.faces.get().beyond > 0 {
                    (self.rest, self.current) = (&[], Vec::new());
                }
                self.current.push(b'\n');
                return;
            }
            self.current.clear();
        }
        // A continuation of nothing.
        self.current.clear();
    }
}

impl Read for Statements<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl BufRead for Statements<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.current.len() {
            self.advance();
        }
        Ok(&self.current[self.at..])
    }
    fn consume(&mut self, read: usize) {
        self.at += read;
    }
}
