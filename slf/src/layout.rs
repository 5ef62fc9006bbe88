//! Where the numbers of clusters and texels lie.
//!
//! A *field* is what has clusters of its own: all channels together, or each channel (`colour=separate`). Clusters of all fields are
//! numbered through. A *tile* is a cluster's view map: for each direction a run of channels x k numbers, so that a direction is read at one
//! place. A texel's weights are one run too.

use crate::params::Colour;
use prt_transfer::Shape;
use prt_transfer::ids::Ids;

/// Sizes, and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    pub(crate) colour: Colour,
    /// m, ζ and n.
    pub(crate) shape: Shape,
    /// k.
    pub(crate) components: usize,
    /// Clusters before those of each field, and all of them.
    starts: Vec<usize>,
}

impl Layout {
    /// Of so many clusters in each field.
    pub(crate) fn new(colour: Colour, shape: Shape, components: usize, clusters: &[usize]) -> Layout {
        let mut starts = vec![0];
        for clusters in clusters {
            starts.push(starts[starts.len() - 1] + clusters);
        }
        Layout { colour, shape, components, starts }
    }

    pub(crate) fn fields(&self) -> usize {
        fields(self.colour, self.shape)
    }

    /// Channels of a field.
    #[inline(always)]
    pub(crate) fn channels(&self) -> usize {
        if self.colour == Colour::Separate { 1 } else { self.shape.responses }
    }

    /// Weight vectors of a texel in a field.
    pub(crate) fn vectors(&self) -> usize {
        if self.colour == Colour::Joint { 1 } else { self.channels() }
    }

    /// Of a field.
    pub(crate) fn clusters_of(&self, field: usize) -> usize {
        self.starts[field + 1] - self.starts[field]
    }

    /// Of all fields.
    pub(crate) fn clusters(&self) -> usize {
        self.starts[self.fields()]
    }

    /// η: the clusters of the field with most.
    pub(crate) fn most_clusters(&self) -> usize {
        (0..self.fields()).map(|field| self.clusters_of(field)).max().unwrap_or(0)
    }

    /// Of all clusters, that of a texel in a field, and the channel's place in the field.
    #[inline(always)]
    pub(crate) fn cluster(&self, ids: &Ids, texel: usize, channel: usize) -> (usize, usize) {
        match self.colour {
            Colour::Separate => (self.starts[channel] + ids.at(texel * self.shape.responses + channel) as usize, 0),
            Colour::Shared | Colour::Joint => (ids.at(texel) as usize, channel),
        }
    }

    /// Of all clusters, that which the `at`th id names.
    pub(crate) fn cluster_of_id(&self, at: usize, id: u32) -> usize {
        self.starts[at % self.fields()] + id as usize
    }

    /// Numbers of a direction in a tile.
    #[inline(always)]
    pub(crate) fn run(&self) -> usize {
        self.channels() * self.components
    }

    /// The first number of a cluster's direction.
    #[inline(always)]
    pub(crate) fn view(&self, cluster: usize, direction: usize) -> usize {
        (cluster * self.shape.lights + direction) * self.run()
    }

    /// The first weight of a texel's channel.
    #[inline(always)]
    pub(crate) fn weight(&self, texel: usize, channel: usize) -> usize {
        match self.colour {
            Colour::Joint => texel * self.components,
            Colour::Shared | Colour::Separate => (texel * self.shape.responses + channel) * self.components,
        }
    }

    /// Numbers of the view maps: η ζ n k; saturated.
    pub(crate) fn view_numbers(&self) -> usize {
        self.clusters().saturating_mul(self.shape.lights).saturating_mul(self.run())
    }

    /// Numbers of the surface map: ζ m k, or m k where channels have their weights in common; saturated.
    pub(crate) fn surface_numbers(&self) -> usize {
        (self.shape.samples * self.fields() * self.vectors()).saturating_mul(self.components)
    }

    /// Components of view maps: one for each cluster and channel, k times.
    pub(crate) fn view_vectors(&self) -> usize {
        self.clusters().saturating_mul(self.run())
    }

    /// Their weights: one for each cluster and weight vector, k times.
    pub(crate) fn surface_vectors(&self) -> usize {
        self.clusters().saturating_mul(self.vectors() * self.components)
    }

    /// One for each cluster and channel.
    pub(crate) fn mean_vectors(&self) -> usize {
        self.clusters().saturating_mul(self.channels())
    }

    /// The component that each number of the view maps belongs to.
    pub(crate) fn vectors_of_views(&self) -> impl Iterator<Item = usize> + Clone {
        let (run, lights) = (self.run(), self.shape.lights);
        (0..self.clusters()).flat_map(move |cluster| (0..lights).flat_map(move |_| cluster * run..(cluster + 1) * run))
    }

    /// The vector that each weight belongs to.
    pub(crate) fn vectors_of_surface<'a>(&'a self, ids: &'a Ids) -> impl Iterator<Item = usize> + Clone + 'a {
        let run = self.vectors() * self.components;
        (0..self.shape.samples * self.fields()).flat_map(move |at| {
            let cluster = self.cluster_of_id(at, ids.at(at));
            cluster * run..(cluster + 1) * run
        })
    }

    /// The vector that each mean belongs to.
    pub(crate) fn vectors_of_means<'a>(&'a self, ids: &'a Ids) -> impl Iterator<Item = usize> + Clone + 'a {
        let run = self.channels();
        (0..self.shape.samples * self.fields()).flat_map(move |at| {
            let cluster = self.cluster_of_id(at, ids.at(at));
            cluster * run..(cluster + 1) * run
        })
    }
}

/// What has clusters of its own.
pub(crate) fn fields(colour: Colour, shape: Shape) -> usize {
    if colour == Colour::Separate { shape.responses } else { 1 }
}
