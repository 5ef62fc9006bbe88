//! Where the vectors of a cluster and the weights of a sample lie.

use prt_transfer::ids::Ids;
use prt_transfer::sections::broken;
use prt_transfer::{Result, Shape, Sink, Source};

/// Samples whose weights are found from one stored place.
pub(crate) const BLOCK: usize = 64;

const SECTION: &str = "index/components";

/// Representatives follow each other cluster after cluster, a mean and its components; weights sample after sample.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    clusters: usize,
    /// n'_k, the components of each cluster; a single number where all have as many.
    components: Vec<u32>,
    /// Representatives before each cluster; derived, and empty where all clusters have as many components.
    vectors: Vec<u64>,
    /// Weights before each block of samples, the one behind the last included if it is empty; derived, and empty where
    /// all clusters have as many components.
    weights: Vec<u64>,
}

impl Layout {
    /// Of clusters with so many components each.
    pub(crate) fn of(components: &[u32], samples: usize, ids: &Ids) -> Layout {
        let uneven = components.windows(2).any(|pair| pair[0] != pair[1]);
        let stored = if uneven { components.to_vec() } else { vec![components.first().copied().unwrap_or_default()] };
        Layout::of_stored(components.len(), stored, samples, ids)
    }

    fn of_stored(clusters: usize, components: Vec<u32>, samples: usize, ids: &Ids) -> Layout {
        let mut layout = Layout { clusters, components, vectors: Vec::new(), weights: Vec::new() };
        if layout.even().is_none() {
            let of_cluster = |k: usize| 1 + layout.components(k);
            let of_block = |block: usize| {
                let samples = block * BLOCK..samples.min((block + 1) * BLOCK);
                samples.map(|p| layout.components(ids.at(p) as usize)).sum()
            };
            (layout.vectors, layout.weights) =
                (sums_before(clusters, of_cluster), sums_before(samples / BLOCK + 1, of_block));
        }
        layout
    }

    pub(crate) fn clusters(&self) -> usize {
        self.clusters
    }

    /// The number of components of all clusters, where they have as many.
    pub(crate) fn even(&self) -> Option<usize> {
        match self.components[..] {
            [all] => Some(all as usize),
            _ => None,
        }
    }

    /// n'_k.
    #[inline(always)]
    pub(crate) fn components(&self, cluster: usize) -> usize {
        match self.components[..] {
            [all] => all as usize,
            _ => self.components[cluster] as usize,
        }
    }

    /// Representatives before a cluster: its mean is the next, then come its components.
    #[inline(always)]
    pub(crate) fn first_vector(&self, cluster: usize) -> usize {
        match self.components[..] {
            [all] => cluster * (1 + all as usize),
            _ => self.vectors[cluster] as usize,
        }
    }

    /// Means and components of all clusters: Σ (1 + n'_k).
    pub(crate) fn vectors(&self) -> usize {
        (0..self.clusters).next_back().map_or(0, |last| self.first_vector(last) + 1 + self.components(last))
    }

    /// Weights before a sample.
    pub(crate) fn first_weight(&self, sample: usize, ids: &Ids) -> usize {
        if let [all] = self.components[..] {
            return sample * all as usize;
        }
        let before = sample / BLOCK * BLOCK..sample;
        self.weights[sample / BLOCK] as usize + before.map(|p| self.components(ids.at(p) as usize)).sum::<usize>()
    }

    /// For each weight, sample after sample, which of the components of all clusters it multiplies.
    pub(crate) fn components_of_weights(&self, samples: usize, ids: &Ids) -> impl Iterator<Item = usize> + Clone {
        (0..samples).flat_map(move |sample| {
            let cluster = ids.at(sample) as usize;
            let first = self.first_vector(cluster) - cluster;
            first..first + self.components(cluster)
        })
    }

    pub(crate) fn write(&self, sink: &mut Sink) {
        sink.put(SECTION, &self.components);
    }

    /// What is held beside what is written.
    pub(crate) fn hold(&self, sink: &mut Sink) {
        self.write(sink);
        if self.components.len() > 1 {
            sink.put("index/vector-starts", &self.vectors);
            sink.put("index/weight-starts", &self.weights);
        }
    }

    /// Reads what [`Layout::write`] wrote; no cluster has more components than samples have numbers.
    pub(crate) fn read(source: &mut Source, clusters: usize, shape: Shape, ids: &Ids) -> Result<Layout> {
        let components: Vec<u32> = source.take(SECTION)?;
        let uneven = components.len() == clusters && components.windows(2).any(|pair| pair[0] != pair[1]);
        if components.len() != 1 && !uneven {
            let expected = format!("1 number, or {clusters} that are not all equal");
            return Err(broken(SECTION, expected, format!("{} numbers", components.len())));
        }
        let most = shape.responses * shape.lights;
        if let Some(found) = components.iter().find(|&&n| n as usize > most) {
            return Err(broken(SECTION, format!("0 to {most} components"), found.to_string()));
        }
        // Samples x numbers of a sample fit memory, as the shape says: so do sums of components over samples.
        Ok(Layout::of_stored(clusters, components, shape.samples, ids))
    }
}

/// For each of `count` terms the sum of those before it.
fn sums_before(count: usize, term: impl Fn(usize) -> usize) -> Vec<u64> {
    let (mut sums, mut sum) = (Vec::with_capacity(count), 0);
    for i in 0..count {
        sums.push(sum);
        sum += term(i) as u64;
    }
    sums
}
