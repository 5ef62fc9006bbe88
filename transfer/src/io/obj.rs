//! Wavefront OBJ through tobj, which is handed only the statements that matter here.
//!
//! Taking out groups and materials keeps vertices shared across them; taking out comments and names lets them be in any
//! encoding; handing over one statement at a time tells on which line parsing stopped.

use super::broken;
use super::mesh::build;
use crate::error::Result;
use crate::mesh::Mesh;
use glam::Vec3;
use std::cell::Cell;
use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use tobj::{LoadError, LoadOptions};

pub(super) fn read(bytes: &[u8]) -> Result<Mesh> {
    let line = Cell::new(0);
    let mut statements = Statements { rest: bytes, line: &line, current: Vec::new(), at: 0 };
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let loaded = tobj::load_obj_buf(&mut statements, &options, |_| Err(LoadError::OpenFileFailed));
    let (models, _) = loaded.map_err(|e| {
        // Indices are checked only once everything has been parsed.
        let late = matches!(e, LoadError::FaceVertexOutOfBounds | LoadError::FaceNormalOutOfBounds);
        let place = if late { "faces".into() } else { format!("line {}", line.get()) };
        broken("obj", place, "a statement v, vn or f", e.to_string())
    })?;
    // Without groups there is one model.
    let mesh = models.into_iter().map(|model| model.mesh).find(|mesh| !mesh.indices.is_empty());
    let Some(mesh) = mesh else {
        return Err(broken("obj", "faces", "at least one face of three vertices", "none"));
    };
    let vectors = |numbers: &[f32]| numbers.as_chunks::<3>().0.iter().map(|&v| Vec3::from(v)).collect::<Vec<_>>();
    let (positions, normals) = (vectors(&mesh.positions), vectors(&mesh.normals));
    if mesh.normal_indices.len() != mesh.indices.len() {
        return build("obj", positions, Vec::new(), triangles(&mesh.indices));
    }
    let (mut known, mut corners) = (HashMap::new(), Vec::new());
    let indices: Vec<u32> = mesh
        .indices
        .iter()
        .zip(&mesh.normal_indices)
        .map(|corner| {
            *known.entry(corner).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            })
        })
        .collect();
    let pick = |from: &[Vec3], at: u32| from.get(at as usize).copied().unwrap_or(Vec3::ZERO);
    let (positions, normals) = corners.iter().map(|&(&p, &n)| (pick(&positions, p), pick(&normals, n))).unzip();
    build("obj", positions, normals, triangles(&indices))
}

fn triangles(indices: &[u32]) -> Vec<[u32; 3]> {
    indices.as_chunks().0.to_vec()
}

/// Hands out one statement at a time.
struct Statements<'a> {
    rest: &'a [u8],
    /// Lines taken so far.
    line: &'a Cell<usize>,
    current: Vec<u8>,
    at: usize,
}

impl Statements<'_> {
    /// Takes lines up to the next statement v, vn or f, continued lines joined.
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
            if matches!(word, b"v" | b"vn" | b"f") {
                // A trailing comment is no number.
                let end = self.current.iter().position(|&b| b == b'#').unwrap_or(self.current.len());
                self.current.truncate(end);
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
