//! Samples by cluster.

/// Samples by cluster.
pub struct Groups {
    starts: Vec<usize>,
    samples: Vec<u32>,
}

impl Groups {
    /// Of the cluster of each sample; in a group, samples ascend.
    pub fn of(members: &[u32], clusters: usize) -> Groups {
        let mut starts = vec![0usize; clusters + 1];
        members.iter().for_each(|&c| starts[c as usize + 1] += 1);
        (1..=clusters).for_each(|k| starts[k] += starts[k - 1]);
        let mut places = starts.clone();
        let mut samples = vec![0u32; members.len()];
        for (sample, &cluster) in members.iter().enumerate() {
            samples[places[cluster as usize]] = sample as u32;
            places[cluster as usize] += 1;
        }
        Groups { starts, samples }
    }

    /// How many clusters.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples of one, ascending.
    pub fn of_cluster(&self, cluster: usize) -> &[u32] {
        &self.samples[self.starts[cluster]..self.starts[cluster + 1]]
    }
}
