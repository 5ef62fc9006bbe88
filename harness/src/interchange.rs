//! `prt export` and `prt import`: clustered principal components from and for programs that use D3DX.

use crate::files::{self, Description};
use crate::interrupt::Unseen;
use crate::registry::registry;
use crate::terminal;
use clap::Args;
use prt_cpca::{EncodedCpca, Model, Width, d3dx};
use prt_transfer::label::Label;
use prt_transfer::matrix::Layout;
use prt_transfer::method::Header;
use prt_transfer::sh::MAX_ORDER;
use prt_transfer::{Compressed, Encoded, Error, LightBasis, Registry, ResponseBasis, Restore, Result, Sink, Source};
use std::path::PathBuf;

/// Arguments of `prt export`.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  prt export teapot.prt -o teapot.pca\n\n\
    Of `vq`, `pca` and `cpca` without a light transform, with 1 or 3 responses. Spherical harmonics take the signs \
    of D3DX.")]
pub struct Export {
    /// Compressed matrix
    #[arg(value_name = "FILE.prt")]
    pub input: PathBuf,
    /// Where to write the buffer
    #[arg(short, long, value_name = "FILE.pca")]
    pub output: PathBuf,
}

/// Arguments of `prt import`.
#[derive(Args, Debug)]
#[command(after_help = "Example:\n  prt import head.pca -o head.prt\n\n\
    Spherical harmonics are taken to have the signs of D3DX; with --basis plain:N coefficients stay as they are.")]
pub struct Import {
    /// Compressed PRT buffer of D3DX
    #[arg(value_name = "FILE.pca")]
    pub input: PathBuf,
    /// Where to write the compressed matrix
    #[arg(short, long, value_name = "FILE.prt")]
    pub output: PathBuf,
    /// What the channels of one sample stand for [default: plain numbers]
    #[arg(long, value_name = "RESPONSES")]
    pub responses: Option<ResponseBasis>,
    /// What the coefficients stand for [default: spherical harmonics where their number is a square, plain numbers
    /// otherwise]
    #[arg(long, value_name = "BASIS")]
    pub basis: Option<LightBasis>,
}

/// Runs `prt export`.
pub fn export(arguments: &Export) -> anyhow::Result<()> {
    files::expect_extension(&arguments.output, "pca")?;
    let compressed = files::read_prt(&arguments.input, &registry())?;
    Ok(files::write_beside(&arguments.output, &to_d3dx(&compressed)?)?)
}

/// Runs `prt import`.
pub fn import(arguments: &Import) -> anyhow::Result<()> {
    files::expect_extension(&arguments.output, "prt")?;
    let description = Description { responses: arguments.responses.clone(), basis: arguments.basis.clone() };
    let bytes = files::read_bytes(&arguments.input)?;
    let compressed = from_d3dx(&bytes, description, &registry()).map_err(|e| e.in_file(&arguments.input))?;
    files::write_prt(&arguments.output, &compressed, &Unseen)?;
    terminal::say(format!("{}, {}, {}", compressed.label(), compressed.basis(), compressed.responses()))
}

/// The bytes of a compressed PRT buffer.
fn to_d3dx(compressed: &Compressed) -> Result<Vec<u8>> {
    let Header { label, tag, shape, basis, .. } = compressed.header();
    if tag != EncodedCpca::TAG || label.transform.name != "identity" {
        return Err(Error::Unsupported {
            what: "export to a D3DX compressed PRT buffer".into(),
            expected:
                "clusters and components of the light's own coefficients: vq, pca or cpca without a light transform"
                    .into(),
            found: label.to_string(),
        });
    }
    let mut source = Source::new(compressed.sections().into_sections())?;
    let mut model = EncodedCpca::read(shape, &mut source)?.model();
    change_phase(&mut model, &basis);
    d3dx::to_d3dx(&model)
}

/// A compressed matrix of a compressed PRT buffer.
fn from_d3dx(bytes: &[u8], description: Description, registry: &Registry) -> Result<Compressed> {
    let mut model = d3dx::from_d3dx(bytes)?;
    let (shape, clusters) = (model.shape, model.clusters.len());
    let basis = description.basis.unwrap_or_else(|| usual_basis(shape.lights));
    let responses = description.responses.unwrap_or(ResponseBasis::Plain { responses: shape.responses });
    change_phase(&mut model, &basis);
    let components = if clusters == 0 { 0 } else { model.components(0) };
    let label: Label = format!("cpca:clusters={}:components={components}", clusters.max(1)).parse()?;
    // In its shortest form.
    let label = registry.method(&label)?.label().clone();
    let layout = if shape.responses > 1 { Layout::Samples } else { Layout::Rows };
    let header = Header { label, tag: EncodedCpca::TAG.into(), shape, basis, responses, layout };
    let mut sink = Sink::new();
    EncodedCpca::store(&model, Width::F32, Width::F32).write(&mut sink);
    registry.restore(&header, sink.into_sections())
}

/// D3DX knows no lights but spherical harmonics, all of them up to an order.
fn usual_basis(lights: usize) -> LightBasis {
    match lights.isqrt() {
        order if order * order == lights && order <= MAX_ORDER => LightBasis::SphericalHarmonics { order },
        _ => LightBasis::Plain { lights },
    }
}

fn change_phase(model: &mut Model, basis: &LightBasis) {
    if let LightBasis::SphericalHarmonics { .. } = basis {
        d3dx::change_phase(model);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prt_cpca::{Cluster, CpcaParams};
    use prt_transfer::csr::Csr;
    use prt_transfer::sh::Sh;
    use prt_transfer::transform::Identity;
    use prt_transfer::{Codec, Configure, Progress, Quiet, Shape, TransferMatrix};

    /// As many clusters as samples: a stand-in that needs no search.
    struct Samples(CpcaParams);

    impl Configure for Samples {
        type Params = CpcaParams;
        fn new(params: CpcaParams) -> Result<Samples> {
            Ok(Samples(params))
        }
        fn params(&self) -> &CpcaParams {
            &self.0
        }
    }

    impl Codec for Samples {
        type Encoded = EncodedCpca;
        fn encode(&self, matrix: &TransferMatrix, _: &dyn Progress) -> Result<EncodedCpca> {
            let (shape, values) = (matrix.shape(), matrix.as_dense().expect("the test's are dense"));
            let cluster = |mean: &[f32]| Cluster { mean: mean.to_vec(), components: Vec::new() };
            let clusters = values.chunks(shape.responses * shape.lights).map(cluster).collect();
            let members = (0..shape.samples as u32).collect();
            Ok(EncodedCpca::store(&Model { shape, clusters, members, weights: Vec::new() }, Width::F32, Width::F32))
        }
    }

    fn known() -> Registry {
        Registry::new().transform::<Identity>().transform::<Sh>().codec::<Samples>().codec::<Csr>()
    }

    fn encoded(label: &str, basis: LightBasis) -> Compressed {
        let values = (0..4 * 3 * basis.lights()).map(|i| i as f32 - 10.0).collect();
        let matrix = TransferMatrix::from_dense(values, 12, 3, basis).unwrap();
        known().method(&label.parse().unwrap()).unwrap().encode(&matrix, &Quiet).unwrap()
    }

    fn rows(compressed: &Compressed) -> Vec<Vec<f32>> {
        let mut row = vec![0.0; compressed.shape().lights];
        let rows = (0..compressed.shape().rows()).map(|r| {
            compressed.row_into(r, &mut row);
            row.clone()
        });
        rows.collect()
    }

    #[test]
    fn what_is_exported_comes_back_by_import() {
        for (basis, sign) in
            [(LightBasis::SphericalHarmonics { order: 2 }, -1.0), (LightBasis::Plain { lights: 5 }, 1.0)]
        {
            let original = encoded("cpca", basis.clone());
            let bytes = to_d3dx(&original).unwrap();
            // The second number of the first mean: l = 1, m = -1, or no harmonic.
            let number = f32::from_le_bytes(bytes[36..40].try_into().unwrap());
            assert_eq!(number, -9.0 * sign, "{basis}");
            let again = from_d3dx(&bytes, Description::default(), &known()).unwrap();
            assert_eq!((rows(&again), again.basis()), (rows(&original), &basis));
            assert_eq!(again.label().to_string(), "cpca:clusters=4:components=0");
            assert_eq!(again.shape(), Shape::new(4, 3, basis.lights()).unwrap());
            assert_eq!(again.responses().to_string(), "plain:3");
        }
    }

    #[test]
    fn a_description_overrules_what_is_usual_and_must_fit() {
        let bytes = to_d3dx(&encoded("cpca", LightBasis::Plain { lights: 9 })).unwrap();
        let described = |basis: &str| {
            let basis = Some(basis.parse().unwrap());
            from_d3dx(&bytes, Description { basis, responses: None }, &known())
        };
        assert_eq!(rows(&described("plain:9").unwrap())[0][1], -9.0);
        assert_eq!(rows(&described("sh:3").unwrap())[0][1], 9.0);
        assert!(described("plain:8").err().unwrap().to_string().contains("lights of the basis"));
    }

    #[test]
    fn a_light_transform_is_no_part_of_the_format_nor_is_another_codec() {
        let told = to_d3dx(&encoded("csr", LightBasis::Cubemap { resolution: 2 })).unwrap_err().to_string();
        assert!(told.contains("vq, pca or cpca") && told.contains("found csr"), "{told}");
        let told = to_d3dx(&encoded("sh:order=2+cpca", LightBasis::Cubemap { resolution: 2 })).unwrap_err().to_string();
        assert!(told.contains("without a light transform") && told.contains("sh:order=2+cpca"), "{told}");
    }
}
