//! Where the vectors of a cluster and the weights of a sample lie.

use prt_transfer::ids::Ids;
use prt_transfer::sections::broken;
use prt_transfer::{Result, Shape, Sink, Source};

/// Samples whose weights are found from one stored place.
pub(crate) const BLOCK: usize = 64;

const RANKS: &str = "index/ranks";

/// Bases follow each other cluster after cluster, weights sample after sample.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// R_light and R_vert of each cluster; a single pair where all have the same.
    ranks: Vec<[u32; 2]>,
    /// Of each cluster; derived.
    places: Vec<Place>,
    /// Weights before each block of samples; derived, and empty where all clusters have the same ranks.
    weights: Vec<u64>,
    pub(crate) views: usize,
    pub(crate) memberships: usize,
}

/// Of a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// Rows of light bases before its own.
    pub(crate) light: usize,
    /// R_light.
    pub(crate) light_rank: usize,
    /// Rows of dual bases before its own.
    pub(crate) sample: usize,
    /// R_vert.
    pub(crate) sample_rank: usize,
    /// Numbers of dual bases before its own.
    pub(crate) dual: usize,
}

impl Layout {
    pub(crate) fn of(ranks: &[[usize; 2]], views: usize, memberships: usize, samples: usize, ids: &Ids) -> Layout {
        let ranks: Vec<[u32; 2]> = ranks.iter().map(|pair| pair.map(|rank| rank as u32)).collect();
        let even = ranks.windows(2).all(|pair| pair[0] == pair[1]);
        let stored = if even { ranks.first().copied().into_iter().collect() } else { ranks.clone() };
        let mut layout =
            Layout { ranks: stored, places: places(&ranks, views), weights: Vec::new(), views, memberships };
        if !even {
            let block = |block: usize| layout.weights_of(block * BLOCK..samples.min((block + 1) * BLOCK), ids);
            let counts: Vec<usize> = (0..samples / BLOCK + 1).map(block).collect();
            let mut sum = 0u64;
            for count in counts {
                layout.weights.push(sum);
                sum += count as u64;
            }
        }
        layout
    }

    pub(crate) fn clusters(&self) -> usize {
        self.places.len()
    }

    pub(crate) fn place(&self, cluster: usize) -> &Place {
        &self.places[cluster]
    }

    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// Behind the last cluster.
    pub(crate) fn end(&self) -> Place {
        self.places.last().map_or(Place::default(), |last| Place {
            light: last.light.saturating_add(last.light_rank),
            sample: last.sample.saturating_add(last.sample_rank),
            dual: last.dual.saturating_add(last.sample_rank.saturating_mul(self.views).saturating_mul(last.light_rank)),
            ..Place::default()
        })
    }

    fn weights_of(&self, samples: std::ops::Range<usize>, ids: &Ids) -> usize {
        let members = samples.start * self.memberships..samples.end * self.memberships;
        members.map(|at| self.places[ids.at(at) as usize].sample_rank).sum()
    }

    /// Weights before a sample.
    pub(crate) fn first_weight(&self, sample: usize, ids: &Ids) -> usize {
        match self.ranks[..] {
            [] => 0,
            [[_, rank]] if self.weights.is_empty() => {
                sample.saturating_mul(self.memberships).saturating_mul(rank as usize)
            }
            _ => self.weights[sample / BLOCK] as usize + self.weights_of(sample / BLOCK * BLOCK..sample, ids),
        }
    }

    /// For each number of the dual bases, which of their rows it belongs to.
    pub(crate) fn rows_of_duals(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.places.iter().flat_map(|place| {
            let rows = place.sample..place.sample + place.sample_rank;
            rows.flat_map(|row| std::iter::repeat_n(row, self.views * place.light_rank))
        })
    }

    /// For each weight, which row of the dual bases it multiplies.
    pub(crate) fn rows_of_weights(&self, samples: usize, ids: &Ids) -> impl Iterator<Item = usize> + Clone {
        (0..samples * self.memberships).flat_map(move |at| {
            let place = self.places[ids.at(at) as usize];
            place.sample..place.sample + place.sample_rank
        })
    }

    pub(crate) fn write(&self, sink: &mut Sink) {
        sink.put(RANKS, self.ranks.as_flattened());
    }

    /// What is held beside what is written: five numbers of each cluster, and where blocks of weights begin.
    pub(crate) fn hold(&self, sink: &mut Sink) {
        self.write(sink);
        let place = |p: &Place| [p.light, p.light_rank, p.sample, p.sample_rank, p.dual].map(|v| v as u64);
        sink.put("index/places", self.places.iter().map(place).collect::<Vec<_>>().as_flattened());
        if !self.weights.is_empty() {
            sink.put("index/weight-starts", &self.weights);
        }
    }

    /// Reads what [`Layout::write`] wrote. No rank is above what a matrix of this shape can have.
    pub(crate) fn read(
        source: &mut Source,
        [clusters, views, memberships]: [usize; 3],
        shape: Shape,
        ids: &Ids,
    ) -> Result<Layout> {
        let stored: Vec<u32> = source.take(RANKS)?;
        let stored: Vec<[usize; 2]> = stored.as_chunks::<2>().0.iter().map(|pair| pair.map(|r| r as usize)).collect();
        let fits = match stored.len() {
            0 => clusters == 0,
            1 => clusters > 0,
            many => many == clusters && stored.windows(2).any(|pair| pair[0] != pair[1]),
        };
        if !fits {
            let expected = format!("one pair, or {clusters} that are not all equal");
            return Err(broken(RANKS, expected, format!("{} pairs", stored.len())));
        }
        let most = [shape.lights, shape.responses * shape.lights];
        if let Some(found) = stored.iter().find(|pair| pair[0] > most[0] || pair[1] > most[1]) {
            return Err(broken(RANKS, format!("ranks up to {most:?}"), format!("{found:?}")));
        }
        let ranks: Vec<[usize; 2]> = (0..clusters).map(|k| stored[k.min(stored.len() - 1)]).collect();
        Ok(Layout::of(&ranks, views, memberships, shape.samples, ids))
    }
}

fn places(ranks: &[[u32; 2]], views: usize) -> Vec<Place> {
    let mut next = Place::default();
    let place = |ranks: &[u32; 2]| {
        let [light_rank, sample_rank] = ranks.map(|rank| rank as usize);
        let place = Place { light_rank, sample_rank, ..next };
        // Saturated, a count is one that no section of a file has.
        next.light = next.light.saturating_add(light_rank);
        next.sample = next.sample.saturating_add(sample_rank);
        next.dual = next.dual.saturating_add(sample_rank.saturating_mul(views).saturating_mul(light_rank));
        place
    };
    ranks.iter().map(place).collect()
}
