//! Which matrix, and which program: what a finished measurement belongs to.

use crc32fast::Hasher;
use prt_transfer::{Row, TransferMatrix};
use std::sync::OnceLock;

/// CRC-32 of a matrix's shape, basis and elements, as eight hexadecimal digits.
pub fn matrix(matrix: &TransferMatrix) -> String {
    let mut hasher = Hasher::new();
    hasher.update(format!("{:?} {}", matrix.shape(), matrix.basis()).as_bytes());
    let mut bytes = Vec::new();
    for row in 0..matrix.rows() {
        bytes.clear();
        if let Row::Sparse { columns, .. } = matrix.row(row) {
            bytes.extend(columns.iter().flat_map(|c| c.to_le_bytes()));
        }
        let (Row::Sparse { values, .. } | Row::Dense(values)) = matrix.row(row);
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        hasher.update(&(values.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    format!("{:08x}", hasher.finalize())
}

/// Version, commit and CRC-32 of the running executable: a rebuilt program with the same commit is another program.
pub fn program() -> &'static str {
    static PROGRAM: OnceLock<String> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let bytes = std::env::current_exe().and_then(std::fs::read);
        let executable = bytes.map_or_else(|_| "unknown".into(), |b| format!("{:08x}", crc32fast::hash(&b)));
        format!("{} {} {executable}", env!("CARGO_PKG_VERSION"), env!("PRT_COMMIT"))
    })
}

#[cfg(test)]
mod tests {
    use super::matrix;
    use prt_transfer::{LightBasis, TransferMatrix};

    #[test]
    fn a_matrix_differs_from_one_with_another_value_place_or_meaning() {
        let sparse = |column, value, responses| {
            let basis = LightBasis::Plain { lights: 4 };
            TransferMatrix::from_csr(vec![0, 1, 1], vec![column], vec![value], responses, basis).unwrap()
        };
        let prints = [sparse(1, 0.5, 1), sparse(2, 0.5, 1), sparse(1, 0.25, 1), sparse(1, 0.5, 2)].map(|m| matrix(&m));
        for (i, print) in prints.iter().enumerate() {
            assert!(!prints[..i].contains(print), "{prints:?}");
        }
        let sphere = sparse(1, 0.5, 1).with_basis(LightBasis::SphericalHarmonics { order: 2 }).unwrap();
        assert!(!prints.contains(&matrix(&sphere)));
    }
}
