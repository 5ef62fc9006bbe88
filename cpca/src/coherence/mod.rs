//! Cluster coherence (Sloan et al. 2003, §5): fewer triangles that straddle clusters.
//!
//! A cluster of CPCA is drawn with its constants in registers, and draws every triangle that it has a vertex in. A
//! triangle whose vertices are in three clusters is drawn three times: [`overdraw()`] counts. Two techniques reduce it:
//! [`reclassify()`] moves samples to the clusters of their neighbours as far as an error budget goes, and
//! [`superclusters`] are groups of clusters that are drawn as one, as many as registers hold
//! ([`clusters_by_registers`]). These work on any triangles and cluster numbers; [`recluster`] and [`optimise`] apply
//! them to a [`Model`](crate::Model) and the matrix that it came from.
//!
//! ```
//! use prt_cpca::coherence::{overdraw, reclassify, supercluster_of_samples, superclusters};
//!
//! // A strip of triangles; sample 2 is of cluster 1 between samples of cluster 0.
//! let triangles: Vec<[u32; 3]> = (0..6).map(|i| [i, i + 1, i + 2]).collect();
//! let clusters = [0, 0, 1, 0, 0, 2, 2, 2];
//! assert_eq!(overdraw(&triangles, &clusters)?.factor(), 11.0 / 6.0);
//!
//! // It costs 0.01 to have it in cluster 0, and anything else costs 1.
//! let error = |sample, cluster| if cluster == clusters[sample] { 0.0 } else if sample == 2 { 0.01 } else { 1.0 };
//! let better = reclassify(&triangles, &clusters, 0.05, error)?;
//! assert_eq!(better.clusters, [0, 0, 0, 0, 0, 2, 2, 2]);
//! assert_eq!((better.moved, better.increase), (1, 0.01));
//!
//! // Clusters 0 and 2 are drawn as one; cluster 1 is empty.
//! let groups = superclusters(&triangles, &better.clusters, 3, 2)?;
//! assert_eq!(groups, [0, 1, 0]);
//! assert_eq!(overdraw(&triangles, &supercluster_of_samples(&better.clusters, &groups)?)?.factor(), 1.0);
//! # Ok::<(), prt_transfer::Error>(())
//! ```

mod fans;
mod fit;
mod overdraw;
mod reclassify;
mod recluster;
mod supercluster;
#[cfg(test)]
mod tests;

pub use overdraw::{Overdraw, overdraw};
pub use reclassify::{Reclassified, reclassify};
pub use recluster::{Optimised, Report, optimise, recluster, squared_error};
pub use supercluster::{clusters_by_registers, supercluster_of_samples, superclusters};
