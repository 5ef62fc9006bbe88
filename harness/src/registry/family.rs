//! What a family of models is: a label, the parameters that make its models larger and better, and the matrices that it is made for.

use prt_transfer::{LightBasis, ResponseBasis, TransferMatrix};

/// What a matrix holds, as far as it decides which methods fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Visibility by sample and local direction.
    Biscale,
    /// A row for each sample, texels of light.
    Diffuse,
    /// Exit radiance for light in harmonics.
    Glossy,
    /// Functions of a BRDF, texels of light.
    Terms,
    /// A surface light field.
    Field,
    /// A matrix that does not say.
    Other,
}

/// Parameters that are swept together, with values from the smallest model to the largest.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Each `stage:parameter`, such as `truncate:terms`.
    pub parameters: &'static [&'static str],
    /// As a label writes them.
    pub values: &'static [&'static str],
    /// Which of them a matrix has a use for.
    pub extent: Extent,
    /// The value that a search starts with.
    pub start: Start,
    /// Whether every whole number between two values is one too.
    pub whole: bool,
    /// Whether they are numbers in which a model is stored, and not another model.
    pub stored: bool,
}

/// What bounds a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Nothing.
    Free,
    /// There is no more to take than samples.
    Samples,
    /// There is no more to take than responses.
    Responses,
    /// There is no more to take than lights.
    Lights,
    /// Bands: their square is at most the lights.
    Bands,
}

/// Where along an axis a search starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At the smallest model.
    First,
    /// Half-way.
    Middle,
    /// Where what clusters hold takes about as many numbers as what samples hold: samples / (responses x lights).
    Balanced,
}

/// What the first axis of a family counts, as far as the number that a bound needs can be estimated or given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// Principal components of all samples.
    Components,
    /// The largest coefficients of each row.
    Terms,
    /// Nothing: it is a bound on the error.
    Bound,
    /// Something else.
    Other,
}

/// Models of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The label that all of them begin with.
    pub base: &'static str,
    /// Which matrices it is made for.
    pub fits: fn(Kind) -> bool,
    /// What a search can change. Along the first axis models grow and errors fall.
    pub axes: &'static [Axis],
    /// What the first axis counts.
    pub counts: Counts,
    /// The parameter that takes a bound on the error, `codec:parameter`, in place of the first axis.
    pub bounded: Option<&'static str>,
    /// Points of `prt bench --quick`.
    pub quick: &'static [&'static str],
    /// Points of `prt bench`, beside those.
    pub standard: &'static [&'static str],
    /// Points of `prt bench --full`, beside those.
    pub full: &'static [&'static str],
}

impl Family {
    /// Whether nothing is known of it but its codec's name.
    pub fn is_alone(&self) -> bool {
        self.axes.is_empty() && [self.quick, self.standard, self.full].iter().all(|points| points.is_empty())
    }
}

impl Kind {
    /// What responses say of their matrix.
    pub fn of(responses: &ResponseBasis) -> Kind {
        match responses {
            ResponseBasis::LocalDirections { .. } => Kind::Biscale,
            ResponseBasis::Irradiance { .. } => Kind::Diffuse,
            ResponseBasis::Exit { .. } => Kind::Glossy,
            ResponseBasis::Terms { .. } => Kind::Terms,
            ResponseBasis::Radiance { .. } => Kind::Field,
            ResponseBasis::Plain { .. } => Kind::Other,
        }
    }

    /// What a matrix holds; one that does not say is judged by its shape where its light is on a cubemap.
    pub fn of_matrix(matrix: &TransferMatrix) -> Kind {
        match (Kind::of(matrix.responses()), matrix.basis(), matrix.shape().responses) {
            (Kind::Other, LightBasis::Cubemap { .. }, 1) => Kind::Diffuse,
            (Kind::Other, LightBasis::Cubemap { .. }, _) => Kind::Terms,
            (kind, _, _) => kind,
        }
    }
}
