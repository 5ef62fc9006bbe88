//! The one place where the program touches files of matrices, lights and compressed matrices.

use anyhow::{Context, bail};
use ndarray::{Array2, ArrayView2};
use prt_transfer::method::Header;
use prt_transfer::{Compressed, LightBasis, Quiet, Registry, Section, Shape, TransferMatrix};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;

/// What a bare matrix does not say of itself.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// Rows of one sample.
    pub responses: Option<usize>,
    /// What the columns stand for.
    pub basis: Option<LightBasis>,
}

/// Reads a transfer matrix; the extension says which format.
pub fn read_matrix(path: &Path, description: &Description) -> anyhow::Result<TransferMatrix> {
    let matrix = crate::decode::matrix(&read_prt(path, &crate::registry::registry())?, &Quiet)?;
    let responses = description.responses.unwrap_or(matrix.shape().responses);
    let basis = description.basis.clone().unwrap_or_else(|| matrix.basis().clone());
    let matrix = matrix.with_basis(basis.clone())?;
    Ok(match (matrix.as_csr(), matrix.as_dense()) {
        (Some((o, c, v)), _) => TransferMatrix::from_csr(o.to_vec(), c.to_vec(), v.to_vec(), responses, basis)?,
        (_, Some(values)) => TransferMatrix::from_dense(values.to_vec(), matrix.rows(), responses, basis)?,
        _ => matrix,
    })
}

/// Writes a transfer matrix; the extension says which format.
pub fn write_matrix(path: &Path, matrix: &TransferMatrix) -> anyhow::Result<()> {
    let method = crate::registry::method(&crate::registry::registry(), "csr")?;
    write_prt(path, &method.encode(matrix, &Quiet)?)
}

/// Writes a compressed matrix.
pub fn write_prt(path: &Path, compressed: &Compressed) -> anyhow::Result<()> {
    let Header { label, tag, shape, basis, layout } = compressed.header();
    let sections = compressed.sections().into_sections();
    let sizes: Vec<Value> = sections.iter().map(|s| json!([s.name, s.bytes.len()])).collect();
    let header = json!({ "label": label.to_string(), "tag": tag, "basis": basis.to_string(), "layout": format!("{layout:?}"),
        "shape": [shape.samples, shape.responses, shape.lights], "sections": sizes });
    let mut bytes = format!("{header}\n").into_bytes();
    sections.iter().for_each(|s| bytes.extend(&s.bytes));
    write_beside(path, &bytes)
}

/// Reads a compressed matrix.
pub fn read_prt(path: &Path, registry: &Registry) -> anyhow::Result<Compressed> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse_prt(&bytes, registry).with_context(|| path.display().to_string())
}

fn parse_prt(bytes: &[u8], registry: &Registry) -> anyhow::Result<Compressed> {
    use prt_transfer::matrix::Layout;
    let end = bytes.iter().position(|&b| b == b'\n').context("no header line")?;
    let header: Value = serde_json::from_slice(&bytes[..end])?;
    let word = |name: &str| header[name].as_str().with_context(|| format!("header has no {name}"));
    let size = |i: usize| Some(header["shape"][i].as_u64()? as usize);
    let (Some(samples), Some(responses), Some(lights)) = (size(0), size(1), size(2)) else {
        bail!("header has no shape")
    };
    let layout = match word("layout")? {
        "Sparse" => Layout::Sparse,
        "Rows" => Layout::Rows,
        _ => Layout::Samples,
    };
    let (mut rest, mut sections) = (&bytes[end + 1..], Vec::new());
    for entry in header["sections"].as_array().context("header has no sections")? {
        let (Some(name), Some(length)) = (entry[0].as_str(), entry[1].as_u64()) else { bail!("section has no length") };
        let (section, tail) = rest.split_at_checked(length as usize).context("cut short")?;
        sections.push(Section { name: name.into(), bytes: section.to_vec() });
        rest = tail;
    }
    let header = Header {
        label: word("label")?.parse()?,
        tag: word("tag")?.into(),
        shape: Shape::new(samples, responses, lights)?,
        basis: word("basis")?.parse()?,
        layout,
    };
    Ok(registry.restore(&header, sections)?)
}

/// Reads a light of one or several channels: lights x channels.
pub fn read_lights(path: &Path) -> anyhow::Result<Array2<f32>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let rows: Vec<Vec<f32>> = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    let channels = rows.first().map_or(0, Vec::len);
    Ok(Array2::from_shape_vec((rows.len(), channels), rows.concat())?)
}

/// Writes an array of numbers.
pub fn write_array(path: &Path, array: ArrayView2<f32>) -> anyhow::Result<()> {
    let rows: Vec<Vec<f32>> = array.outer_iter().map(|row| row.to_vec()).collect();
    write_beside(path, &serde_json::to_vec(&rows)?)
}

/// Writes a file beside the old one and renames it, so that an interrupted run leaves the old file.
pub fn write_beside(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let place = || format!("cannot write {}", path.display());
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).with_context(place)?;
    file.write_all(bytes).with_context(place)?;
    file.persist(path).with_context(place)?;
    Ok(())
}
