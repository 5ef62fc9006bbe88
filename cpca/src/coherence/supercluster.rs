//! Superclusters: clusters that are drawn as a unit, with the constants of all of them in registers.

use super::overdraw::check;
use prt_transfer::{Error, Result};
use std::collections::{BTreeMap, BinaryHeap, btree_map::Entry};

/// The most clusters that a supercluster may have where hardware has `registers` of four channels (paper §6.2): each
/// needs one register for each of its `components` + 1 representatives and each four `responses` (one colour channel at
/// a time), or for the colour of the single response of diffuse transfer. 0 where not even one cluster fits. Of
/// clusters with different numbers of components the largest counts.
pub fn clusters_by_registers(registers: usize, components: usize, responses: usize) -> usize {
    registers / components.saturating_add(1).saturating_mul(responses.div_ceil(4).max(1))
}

/// The supercluster of each of `count` clusters, numbered from 0 in the order of their first clusters (paper §5).
///
/// Vertex i of `triangles` is of cluster `clusters[i]`. Every cluster starts as a supercluster; then the two neighbours
/// (a triangle has vertices from both) whose merging reduces overdraw most are merged, of equally good pairs the one
/// with the lowest first clusters, as long as there are two with at most `members` clusters together. Error does not
/// change, and overdraw is that of [`supercluster_of_samples`].
///
/// # Errors
/// Triangles with vertices beyond the samples, cluster numbers from `count` on, no `members`.
pub fn superclusters(triangles: &[[u32; 3]], clusters: &[u32], count: usize, members: usize) -> Result<Vec<u32>> {
    check(triangles, clusters.len())?;
    let refuse = |what: String, expected: String, found| Err(Error::Unsupported { what, expected, found });
    if let Some(sample) = clusters.iter().position(|&c| c as usize >= count) {
        let (what, found) = (format!("cluster of sample {sample}"), clusters[sample].to_string());
        return refuse(what, format!("a number below {count}"), found);
    }
    if members == 0 {
        return refuse("clusters of a supercluster".into(), "at least 1".into(), "0".into());
    }
    let mut forest = Forest::new(triangles, clusters, count, members);
    forest.merge_all();
    Ok(forest.numbered())
}

/// The supercluster of each sample, from the cluster of each sample and the supercluster of each cluster: what overdraw
/// after superclustering is counted with.
///
/// # Errors
/// A sample whose cluster has no supercluster, by number.
pub fn supercluster_of_samples(clusters: &[u32], superclusters: &[u32]) -> Result<Vec<u32>> {
    let of_sample = |(sample, &cluster): (usize, &u32)| {
        superclusters.get(cluster as usize).copied().ok_or_else(|| Error::Unsupported {
            what: format!("cluster of sample {sample}"),
            expected: format!("a number below {}, the number of clusters with a supercluster", superclusters.len()),
            found: cluster.to_string(),
        })
    };
    clusters.iter().enumerate().map(of_sample).collect()
}

/// Two superclusters by their first clusters, the lower one first.
type Pair = [u32; 2];

/// A supercluster, under the number of its first cluster.
#[derive(Default)]
struct Group {
    members: usize,
    /// The triangles that are drawn once less when this and another supercluster merge: those with vertices of both.
    shared: BTreeMap<u32, u64>,
    /// Triangles of three clusters, this one's among them, as indices. Some may have merged to two superclusters since.
    corners: Vec<usize>,
}

/// Superclusters as they grow.
struct Forest {
    groups: Vec<Group>,
    /// The supercluster that a cluster has merged into, by its first cluster, and so on; its own number where it is the
    /// first.
    parents: Vec<u32>,
    /// The superclusters of the triangles that have three: two that merge meet the third twice in each of them.
    corners: Vec<[u32; 3]>,
    members: usize,
    /// Triangles shared and the pair, descending; outdated where the pair shares another number by now.
    queue: BinaryHeap<(u64, std::cmp::Reverse<Pair>)>,
}

impl Forest {
    fn new(triangles: &[[u32; 3]], clusters: &[u32], count: usize, members: usize) -> Forest {
        let groups: Vec<Group> = (0..count).map(|_| Group { members: 1, ..Group::default() }).collect();
        let parents = (0..count as u32).collect();
        let mut forest = Forest { groups, parents, corners: Vec::new(), members, queue: BinaryHeap::new() };
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| clusters[v as usize]);
            let pairs = [[a, b], [b, c], [c, a]];
            if pairs.iter().all(|[a, b]| a != b) {
                [a, b, c].iter().for_each(|&g| forest.groups[g as usize].corners.push(forest.corners.len()));
                forest.corners.push([a, b, c]);
                pairs.iter().for_each(|&pair| forest.share(pair));
            } else if let Some(&pair) = pairs.iter().find(|[a, b]| a != b) {
                forest.share(pair);
            }
        }
        for first in 0..count as u32 {
            let above = forest.groups[first as usize].shared.range(first..);
            let pairs: Vec<(u64, Pair)> = above.map(|(&other, &triangles)| (triangles, [first, other])).collect();
            pairs.into_iter().for_each(|(triangles, pair)| forest.offer(triangles, pair));
        }
        forest
    }

    /// Counts a triangle with vertices of both.
    fn share(&mut self, [a, b]: Pair) {
        *self.groups[a as usize].shared.entry(b).or_default() += 1;
        *self.groups[b as usize].shared.entry(a).or_default() += 1;
    }

    /// Queues a pair, unless the two are too large together, which they then stay.
    fn offer(&mut self, triangles: u64, [a, b]: Pair) {
        if self.groups[a as usize].members + self.groups[b as usize].members <= self.members {
            self.queue.push((triangles, std::cmp::Reverse([a.min(b), a.max(b)])));
        }
    }

    fn merge_all(&mut self) {
        while let Some((triangles, std::cmp::Reverse([a, b]))) = self.queue.pop() {
            // A supercluster that has merged into another shares nothing any more.
            let fits = self.groups[a as usize].members + self.groups[b as usize].members <= self.members;
            if fits && self.groups[a as usize].shared.get(&b) == Some(&triangles) {
                self.merge(a, b);
            }
        }
    }

    /// Merges b into a. What the two share with a third adds up, except for triangles of all three, which both have
    /// counted.
    fn merge(&mut self, a: u32, b: u32) {
        let Group { members, shared, corners } = std::mem::take(&mut self.groups[b as usize]);
        self.parents[b as usize] = a;
        self.groups[a as usize].members += members;
        self.groups[a as usize].shared.remove(&b);
        let mut twice: BTreeMap<u32, u64> = BTreeMap::new();
        for &corner in &corners {
            // A triangle that had two corners here is listed twice, and has no b left the second time.
            let triangle = &mut self.corners[corner];
            let third = triangle.iter().copied().find(|&g| g != a && g != b);
            if let (true, true, Some(third)) = (triangle.contains(&a), triangle.contains(&b), third) {
                *twice.entry(third).or_default() += 1;
            }
            triangle.iter_mut().filter(|g| **g == b).for_each(|g| *g = a);
        }
        self.groups[a as usize].corners.extend(corners);
        for (third, triangles) in shared.into_iter().filter(|&(third, _)| third != a) {
            let triangles = triangles - twice.get(&third).copied().unwrap_or_default();
            self.groups[third as usize].shared.remove(&b);
            let both = match self.groups[a as usize].shared.entry(third) {
                Entry::Occupied(mut with_a) => {
                    *with_a.get_mut() += triangles;
                    *with_a.get()
                }
                Entry::Vacant(none) => *none.insert(triangles),
            };
            self.groups[third as usize].shared.insert(a, both);
            self.offer(both, [a, third]);
        }
    }

    /// The number of each cluster's supercluster.
    fn numbered(&self) -> Vec<u32> {
        let (mut numbers, mut next) = (vec![0; self.parents.len()], 0);
        for cluster in 0..self.parents.len() {
            // Parents are lower, so theirs are known.
            let parent = self.parents[cluster] as usize;
            if parent == cluster {
                numbers[cluster] = next;
                next += 1;
            } else {
                numbers[cluster] = numbers[parent];
            }
        }
        numbers
    }
}
