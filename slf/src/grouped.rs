//! Texels in clusters, and the parts of clusters that components are fitted to.

use crate::gram::Rows;
use crate::layout::Layout;
use crate::params::Colour;
use crate::residual::Residual;
use prt_transfer::groups::Groups;

/// What the components of a cluster go over: a channel, or all of them.
pub(crate) struct Part {
    /// The cluster among all.
    pub(crate) cluster: usize,
    /// Its place among the cluster's.
    pub(crate) number: usize,
    pub(crate) field: usize,
    /// Its cluster's place in the field.
    pub(crate) group: usize,
}

/// Clusters of every field, none of them empty unless there is no texel.
pub(crate) struct Grouped {
    pub(crate) fields: Vec<Groups>,
    /// The cluster of each texel in each field.
    pub(crate) members: Vec<u32>,
}

impl Grouped {
    /// Without the clusters that are empty.
    pub(crate) fn of(fields: Vec<Groups>, texels: usize) -> Grouped {
        let (number, mut members) = (fields.len(), vec![0u32; texels * fields.len()]);
        let mut counts = vec![0usize; number];
        for (field, groups) in fields.iter().enumerate() {
            for group in (0..groups.len()).map(|c| groups.of_cluster(c)).filter(|group| !group.is_empty()) {
                group.iter().for_each(|&texel| members[texel as usize * number + field] = counts[field] as u32);
                counts[field] += 1;
            }
        }
        let of_field = |field: usize| {
            let own: Vec<u32> = members.iter().skip(field).step_by(number).copied().collect();
            Groups::of(&own, counts[field])
        };
        Grouped { fields: (0..number).map(of_field).collect(), members }
    }

    /// One cluster in each field.
    pub(crate) fn whole(fields: usize, texels: usize) -> Grouped {
        Grouped::of((0..fields).map(|_| Groups::of(&vec![0; texels], texels.min(1))).collect(), texels)
    }

    pub(crate) fn layout(&self, residual: &Residual, colour: Colour, components: usize) -> Layout {
        let clusters: Vec<usize> = self.fields.iter().map(Groups::len).collect();
        Layout::new(colour, residual.shape, components, &clusters)
    }

    /// All parts of all clusters.
    pub(crate) fn parts(&self, layout: &Layout) -> Vec<Part> {
        let clusters =
            self.fields.iter().enumerate().flat_map(|(field, g)| (0..g.len()).map(move |group| (field, group)));
        let parts = clusters.enumerate().flat_map(|(cluster, (field, group))| {
            (0..layout.vectors()).map(move |number| Part { cluster, number, field, group })
        });
        parts.collect()
    }

    /// The members' residuals in a part.
    pub(crate) fn rows<'a>(&'a self, residual: &'a Residual, layout: &Layout, part: &Part) -> Rows<'a> {
        let stride = residual.dimension();
        let (group, length) = (self.fields[part.field].of_cluster(part.group), stride / layout.vectors());
        Rows { values: residual.field(part.field), group, stride, first: part.number * length, length }
    }
}
