//! A method is a light transform and a codec; the registry finds both by the names in a label.

mod rows;
mod transformed;

pub use rows::transform_rows;
pub use transformed::Transformed;

use crate::basis::LightBasis;
use crate::codec::{Codec, Encoded, Restore};
use crate::error::{Error, Result};
use crate::flops::Flops;
use crate::footprint::{Extent, Footprint};
use crate::label::{Label, Stage};
use crate::matrix::{Layout, Shape, TransferMatrix, check_apply};
use crate::params::{Field, Params};
use crate::progress::Progress;
use crate::responses::ResponseBasis;
use crate::sections::{Section, Sink, Source};
use crate::transform::{LightTransform, Transform};
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use std::sync::Arc;

/// A transform and a codec with their parameters, ready to encode.
pub struct Method {
    label: Label,
    transform: Box<dyn AnyTransform>,
    codec: Box<dyn AnyCodec>,
}

/// A matrix compressed by a method: everything that a `.prt` file holds.
pub struct Compressed {
    label: Label,
    tag: &'static str,
    basis: LightBasis,
    responses: ResponseBasis,
    layout: Layout,
    shape: Shape,
    transform: Arc<dyn LightTransform>,
    encoded: Box<dyn Encoded>,
}

/// What a file says of a compressed matrix before its sections.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The method.
    pub label: Label,
    /// The codec's layout in the file, [`Restore::TAG`].
    pub tag: String,
    /// Samples, responses, lights of T.
    pub shape: Shape,
    /// What T's columns stand for.
    pub basis: LightBasis,
    /// What the responses of a sample stand for.
    pub responses: ResponseBasis,
    /// How T came.
    pub layout: Layout,
}

/// Transforms and codecs by name. The program fills it in one place; a user of a single codec needs none.
#[derive(Default)]
pub struct Registry {
    transforms: Vec<TransformEntry>,
    codecs: Vec<CodecEntry>,
}

/// A method's stage, or a model, as lists such as `prt methods` show it.
#[derive(Clone, Debug)]
pub struct About {
    /// Its name in a label.
    pub name: &'static str,
    /// A sentence.
    pub about: &'static str,
    /// Its parameters.
    pub fields: Vec<Field>,
}

struct TransformEntry {
    about: fn() -> About,
    build: fn(&Stage) -> Result<Box<dyn AnyTransform>>,
}

struct CodecEntry {
    about: fn() -> About,
    tag: &'static str,
    build: fn(&Stage) -> Result<Box<dyn AnyCodec>>,
    restore: fn(Shape, &mut Source) -> Result<Box<dyn Encoded>>,
}

/// [`Codec`] without its associated types.
trait AnyCodec: Send + Sync {
    fn stage(&self) -> Stage;
    fn tag(&self) -> &'static str;
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Box<dyn Encoded>>;
    fn footprint(&self, extent: &Extent) -> Option<Footprint>;
}

/// [`Transform`] without its associated types.
trait AnyTransform: Send + Sync {
    fn stage(&self) -> Stage;
    fn bind(&self, basis: &LightBasis) -> Result<Box<dyn LightTransform>>;
    fn restore(&self, basis: &LightBasis, source: &mut Source) -> Result<Box<dyn LightTransform>>;
}

impl<C: Codec> AnyCodec for C {
    fn stage(&self) -> Stage {
        self.params().to_stage()
    }
    fn tag(&self) -> &'static str {
        C::Encoded::TAG
    }
    fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Box<dyn Encoded>> {
        Ok(Box::new(Codec::encode(self, matrix, progress)?))
    }
    fn footprint(&self, extent: &Extent) -> Option<Footprint> {
        Codec::footprint(self, extent)
    }
}

impl<T: Transform> AnyTransform for T {
    fn stage(&self) -> Stage {
        self.params().to_stage()
    }
    fn bind(&self, basis: &LightBasis) -> Result<Box<dyn LightTransform>> {
        Ok(Box::new(Transform::bind(self, basis)?))
    }
    fn restore(&self, basis: &LightBasis, source: &mut Source) -> Result<Box<dyn LightTransform>> {
        Ok(Box::new(Transform::restore(self, basis, source)?))
    }
}

/// What a list says of the method or model with these parameters.
pub(crate) fn about<P: Params>() -> About {
    About { name: P::NAME, about: P::ABOUT.trim(), fields: P::fields() }
}

impl Registry {
    /// Knows nothing yet.
    pub fn new() -> Registry {
        Registry::default()
    }
    /// Adds a light transform.
    pub fn transform<T: Transform>(mut self) -> Registry {
        self.transforms.push(TransformEntry {
            about: about::<T::Params>,
            build: |stage| Ok(Box::new(T::new(T::Params::from_stage(stage)?)?)),
        });
        self
    }
    /// Adds a codec.
    pub fn codec<C: Codec>(mut self) -> Registry {
        self.codecs.push(CodecEntry {
            about: about::<C::Params>,
            tag: C::Encoded::TAG,
            build: |stage| Ok(Box::new(C::new(C::Params::from_stage(stage)?)?)),
            restore: |shape, source| Ok(Box::new(C::Encoded::read(shape, source)?)),
        });
        self
    }
    /// Every transform, in the order of registration.
    pub fn transforms(&self) -> Vec<About> {
        self.transforms.iter().map(|e| (e.about)()).collect()
    }
    /// Every codec, in the order of registration.
    pub fn codecs(&self) -> Vec<About> {
        self.codecs.iter().map(|e| (e.about)()).collect()
    }
    /// The method that a label describes.
    pub fn method(&self, label: &Label) -> Result<Method> {
        let transform = self.transform_named(&label.transform)?;
        let find = |e: &&CodecEntry| (e.about)().name == label.codec.name;
        let codec = self.codecs.iter().find(find).ok_or_else(|| unknown("codec", &label.codec.name, &self.codecs()))?;
        Ok(Method::from_parts(transform, (codec.build)(&label.codec)?))
    }
    /// A compressed matrix from its header and sections.
    pub fn restore(&self, header: &Header, sections: Vec<Section>) -> Result<Compressed> {
        Error::expect_size("lights of the basis", header.shape.lights, header.basis.lights())?;
        header.responses.check(header.shape)?;
        affordable(header.shape, &sections)?;
        let mut source = Source::new(sections)?;
        let transform = self.transform_named(&header.label.transform)?.restore(&header.basis, &mut source)?;
        let known = || self.codecs.iter().map(|e| e.tag).collect::<Vec<_>>().join(", ");
        let unknown = || Error::Unknown { what: "codec layout", name: header.tag.clone(), known: known() };
        let entry = self.codecs.iter().find(|e| e.tag == header.tag).ok_or_else(unknown)?;
        // The label must be that of the codec which the tag names, with parameters that it accepts.
        let written = self.method(&header.label)?.codec.tag();
        if written != entry.tag {
            return Err(Error::Unsupported {
                what: format!("codec layout of {}", header.label),
                expected: written.into(),
                found: header.tag.clone(),
            });
        }
        let shape = Shape::new(header.shape.samples, header.shape.responses, transform.output().lights())?;
        let encoded = (entry.restore)(shape, &mut source)?;
        source.finish()?;
        Ok(Compressed {
            label: header.label.clone(),
            tag: entry.tag,
            basis: header.basis.clone(),
            responses: header.responses.clone(),
            layout: header.layout,
            shape: header.shape,
            transform: transform.into(),
            encoded,
        })
    }

    fn transform_named(&self, stage: &Stage) -> Result<Box<dyn AnyTransform>> {
        let find = |e: &&TransformEntry| (e.about)().name == stage.name;
        let entry = self
            .transforms
            .iter()
            .find(find)
            .ok_or_else(|| unknown("light transform", &stage.name, &self.transforms()))?;
        (entry.build)(stage)
    }
}

/// Rows that any file may have …
const MOST_ROWS: usize = 1 << 24;
/// … and those that each byte of its sections may stand for besides: a bit for each sample and 1024 responses.
const ROWS_A_BYTE: usize = 1 << 13;

/// Refuses rows that no byte stands for, such as the samples of a single cluster without components: relighting and counting take them one by one.
fn affordable(shape: Shape, sections: &[Section]) -> Result<()> {
    let bytes: usize = sections.iter().map(|s| s.bytes.len()).sum();
    let limit = bytes.saturating_mul(ROWS_A_BYTE).saturating_add(MOST_ROWS);
    if shape.rows() <= limit {
        return Ok(());
    }
    let what = format!("rows of a matrix in sections of {bytes} bytes");
    Err(Error::TooLarge { what, limit: limit as u64, found: shape.rows() as u64 })
}

/// A sum of coefficients that single precision does not hold, as the nearest number that it does: elements are finite. What is no number, the
/// difference of two such sums, is the least.
fn saturated(value: f32) -> f32 {
    if value.is_nan() { f32::MIN } else { value.clamp(f32::MIN, f32::MAX) }
}

fn unknown(what: &'static str, name: &str, known: &[About]) -> Error {
    Error::Unknown { what, name: name.into(), known: known.iter().map(|a| a.name).collect::<Vec<_>>().join(", ") }
}

impl Method {
    /// A transform and a codec of your own choice.
    pub fn new<T: Transform, C: Codec>(transform: T, codec: C) -> Method {
        Method::from_parts(Box::new(transform), Box::new(codec))
    }
    fn from_parts(transform: Box<dyn AnyTransform>, codec: Box<dyn AnyCodec>) -> Method {
        Method { label: Label { transform: transform.stage(), codec: codec.stage() }, transform, codec }
    }
    /// The shortest label that means this method.
    pub fn label(&self) -> &Label {
        &self.label
    }
    /// Compresses `matrix`: transforms its rows, then hands them to the codec.
    pub fn encode(&self, matrix: &TransferMatrix, progress: &dyn Progress) -> Result<Compressed> {
        self.encode_transformed(matrix, &self.transformed(matrix, progress)?, progress)
    }
    /// What [`Method::encode`] of such a matrix takes in memory on rayon's current pool: [`Codec::footprint`] and C of T ≈ C·B.
    ///
    /// # Errors
    /// A basis that the light transform is not defined on.
    pub fn footprint(&self, extent: &Extent, basis: &LightBasis) -> Result<Option<Footprint>> {
        let transform = self.bind(basis)?;
        if extent.is_boundless() {
            return Ok(Some(Footprint::BOUNDLESS));
        }
        if transform.is_identity() {
            return Ok(self.codec.footprint(extent));
        }
        let (coefficients, making) = rows::footprint(extent, &*transform);
        // What the transform derives from the basis, and what that is made of.
        let derived = transform.derived_bytes() as u64;
        let of_codec = self.codec.footprint(&coefficients);
        Ok(of_codec.map(|Footprint { peak, result }| Footprint {
            peak: making.max(coefficients.bytes() + peak) + 4 * derived,
            result: result + derived,
        }))
    }
    /// The light transform on a basis: what makes C's rows of T's.
    pub fn bind(&self, basis: &LightBasis) -> Result<Box<dyn LightTransform>> {
        self.transform.bind(basis)
    }
    /// As [`Method::encode`] of T, given C of T ≈ C·B: for a T that was transformed row by row and never held as a whole. `basis` is T's.
    ///
    /// # Errors
    /// Coefficients of another number or kind than the transform makes on `basis`.
    pub fn encode_coefficients(
        &self,
        coefficients: &TransferMatrix,
        basis: &LightBasis,
        progress: &dyn Progress,
    ) -> Result<Compressed> {
        let transform = self.bind(basis)?;
        if *coefficients.basis() != transform.output() {
            return Err(Error::Unsupported {
                what: format!("coefficients of {} on {basis}", self.label.transform),
                expected: transform.output().to_string(),
                found: coefficients.basis().to_string(),
            });
        }
        let encoded = self.codec.encode(coefficients, progress)?;
        Ok(self.compressed(coefficients, basis, transform.into(), encoded))
    }

    fn compressed(
        &self,
        of: &TransferMatrix,
        basis: &LightBasis,
        transform: Arc<dyn LightTransform>,
        encoded: Box<dyn Encoded>,
    ) -> Compressed {
        Compressed {
            label: self.label.clone(),
            tag: self.codec.tag(),
            basis: basis.clone(),
            responses: of.responses().clone(),
            layout: of.layout(),
            shape: Shape { lights: basis.lights(), ..of.shape() },
            transform,
            encoded,
        }
    }
}

impl Compressed {
    /// The method's label.
    pub fn label(&self) -> &Label {
        &self.label
    }
    /// Shape of T.
    pub fn shape(&self) -> Shape {
        self.shape
    }
    /// What T's columns stand for.
    pub fn basis(&self) -> &LightBasis {
        &self.basis
    }
    /// What the responses of a sample stand for.
    pub fn responses(&self) -> &ResponseBasis {
        &self.responses
    }
    /// How T came.
    pub fn layout(&self) -> Layout {
        self.layout
    }
    /// What the light transform and the codec have to say beyond the label: [`LightTransform::note`], [`Encoded::note`].
    pub fn note(&self) -> Option<String> {
        let notes: Vec<String> = [self.transform.note(), self.encoded.note()].into_iter().flatten().collect();
        (!notes.is_empty()).then(|| notes.join("\n"))
    }
    /// Everything that a file says before the sections.
    pub fn header(&self) -> Header {
        Header {
            label: self.label.clone(),
            tag: self.tag.into(),
            shape: self.shape,
            basis: self.basis.clone(),
            responses: self.responses.clone(),
            layout: self.layout,
        }
    }
    /// What the method writes to a file, section by section.
    pub fn sections(&self) -> Sink {
        let mut sink = Sink::new();
        self.transform.write(&mut sink);
        self.encoded.write(&mut sink);
        sink
    }
    /// What relighting holds in memory, array by array, except what the transform derives from its label and basis.
    pub fn held(&self) -> Sink {
        let mut sink = Sink::new();
        self.transform.write(&mut sink);
        self.encoded.hold(&mut sink);
        sink
    }
    /// Bytes that relighting holds in memory: [`Compressed::held`], and what the transform derives.
    pub fn resident_bytes(&self) -> usize {
        self.held().resident_bytes() + self.transform.derived_bytes()
    }
    /// Relights: `out` (rows x channels) = T̃ · `lights` (lights x channels).
    pub fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        check_apply(self.shape, &lights, &out)?;
        if self.transform.is_identity() {
            return self.encoded.apply_into(lights, out);
        }
        let mut transformed = Array2::zeros((self.encoded.shape().lights, lights.ncols()));
        self.transform.light_into(lights, transformed.view_mut());
        self.encoded.apply_into(transformed.view(), out)
    }
    /// As [`Compressed::apply_into`], with a light whose coefficients the transform does not have to make: `out` (rows x channels) = C ·
    /// `coefficients` (C's columns x channels).
    pub fn apply_coefficients_into(&self, coefficients: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        let shape = Shape { lights: self.encoded.shape().lights, ..self.shape };
        check_apply(shape, &coefficients, &out)?;
        self.encoded.apply_into(coefficients, out)
    }
    /// Reconstructs rows of C of T̃ = C·B from `first` on, which [`Compressed::rows_into`] takes back to T's columns; `out` has C's columns.
    pub fn coefficient_rows_into(&self, first: usize, out: ArrayViewMut2<f32>) {
        self.encoded.rows_into(first, out);
    }
    /// Reconstructs rows of T̃ from `first` on, one a row of `out` (rows x lights); many at once take less time than one after the other.
    pub fn rows_into(&self, first: usize, mut out: ArrayViewMut2<f32>) {
        if self.transform.is_identity() {
            return self.encoded.rows_into(first, out);
        }
        let mut coefficients = Array2::zeros((out.nrows(), self.encoded.shape().lights));
        self.encoded.rows_into(first, coefficients.view_mut());
        self.transform.restore_rows_into(coefficients.view(), out.view_mut());
        out.mapv_inplace(saturated);
    }
    /// Reconstructs a row of T̃; `out.len()` = lights.
    pub fn row_into(&self, row: usize, out: &mut [f32]) {
        if self.transform.is_identity() {
            return self.encoded.row_into(row, out);
        }
        let mut coefficients = vec![0f32; self.encoded.shape().lights];
        self.encoded.row_into(row, &mut coefficients);
        self.transform.restore_row_into(&coefficients, out);
        out.iter_mut().for_each(|v| *v = saturated(*v));
    }
    /// Operations of relighting with one channel: the transform of the light and the product, counted as they run.
    pub fn flops(&self, light: &[f32]) -> Result<Flops> {
        Error::expect_size("light coefficients", self.shape.lights, light.len())?;
        if self.transform.is_identity() {
            return Ok(self.encoded.flops(light));
        }
        let mut transformed = Array2::zeros((self.encoded.shape().lights, 1));
        let column = ArrayView2::from_shape((light.len(), 1), light).expect("a slice is a column");
        self.transform.light_into(column, transformed.view_mut());
        let transformed = transformed.into_raw_vec_and_offset().0;
        Ok(self.transform.flops(light) + self.encoded.flops(&transformed))
    }
}
