//! What a figure measures, as data: curves of settings.

use prt_transfer::Params;

/// One point of a curve: a method, and the sizes by which the paper counts its storage.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The method's label in its shortest form.
    pub method: String,
    /// Clusters m_c and components n' of each; none for a method that keeps every sample as it is.
    pub size: Option<Size>,
}

/// Clusters and components of a clustered approximation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// m_c; 1 for all samples together.
    pub clusters: usize,
    /// n', beside the mean; 0 for vector quantisation.
    pub components: usize,
}

/// Settings that belong together, in the order in which they are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// As the legend shows it.
    pub name: String,
    /// Its points.
    pub settings: Vec<Setting>,
}

impl Size {
    /// Numbers that are stored for `samples` samples m_p of `dimension` numbers n: m_p n' + m_c (n' + 1) n (Sloan et al. 2003, §4.1).
    pub fn numbers(&self, samples: usize, dimension: usize) -> usize {
        samples * self.components + self.clusters * (self.components + 1) * dimension
    }
}

impl Setting {
    /// A clustered approximation with these parameters.
    pub fn new(params: &impl Params, clusters: usize, components: usize) -> Setting {
        Setting { method: params.to_stage().to_string(), size: Some(Size { clusters, components }) }
    }

    /// A method that keeps every sample as it is: what the others are compared with.
    pub fn whole(method: &str) -> Setting {
        Setting { method: method.into(), size: None }
    }

    /// Numbers that the paper counts for `samples` samples of `dimension` numbers.
    pub fn numbers(&self, samples: usize, dimension: usize) -> usize {
        self.size.map_or(samples * dimension, |size| size.numbers(samples, dimension))
    }
}

impl Curve {
    /// With the name of its legend.
    pub fn new(name: impl Into<String>, settings: impl IntoIterator<Item = Setting>) -> Curve {
        Curve { name: name.into(), settings: settings.into_iter().collect() }
    }
}
