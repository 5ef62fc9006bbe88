//! Clustered principal components of radiance transfer.

mod assign;
mod bounds;
mod groups;
mod head;
pub mod model;
mod params;
mod random;
mod refit;
mod residual;
mod samples;
mod shift;
mod start;
mod subspaces;
mod sweeps;

pub use model::{Cluster, Model};
pub use params::{Allocation, Clusters, CpcaParams, Mode, Norm, PcaParams, Solver, Start, VqParams, Width};

/// trial
pub fn trial(matrix: &prt_transfer::TransferMatrix, clusters: usize, components: usize, sweeps: usize, iterative: usize) {
    use std::time::Instant;
    let t0 = Instant::now();
    let samples = samples::Samples::of(matrix, Norm::Coefficients).unwrap();
    let total: f64 = samples.values().iter().map(|v| f64::from(*v).powi(2)).sum();
    eprintln!("samples {:?}", t0.elapsed());
    let t = Instant::now();
    let head = head::Head::of(&samples).unwrap();
    eprintln!("head {} {:?}", head.size(), t.elapsed());
    let t = Instant::now();
    let start = if std::env::var("RND").is_ok() { Start::Random } else { Start::PlusPlus };
    let subspaces = start::start(&samples, &head, clusters, start, 0);
    eprintln!("start {:?}", t.elapsed());
    let search = sweeps::Search { samples: &samples, head: &head, progress: &prt_transfer::Quiet };
    let t = Instant::now();
    let n = subspaces.len();
    let mut state = search.begin(subspaces).unwrap();
    eprintln!("begin {:?}", t.elapsed());
    search.sweeps(&mut state, &vec![0; n], sweeps - 1).unwrap();
    eprintln!("lbg {:?}", t.elapsed());
    let t = Instant::now();
    let groups = groups::Groups::of(&state.assignment.members, n);
    let fin = refit::refit(&samples, &groups, &vec![true; n], &vec![components; n], &state.subspaces).unwrap();
    eprintln!("pca {:?} total {:?}", t.elapsed(), t0.elapsed());
    let error = |m: &[u32], s: &subspaces::Subspaces| {
        (0..samples.count()).map(|i| { let k = s.of(m[i] as usize); residual::explicit(samples.row(i), &k.mean, &k.components) }).sum::<f64>() / total
    };
    let stat = error(&state.assignment.members, &fin);
    eprintln!("static {stat:.6}");
    let t = Instant::now();
    for q in 1..=components {
        search.sweeps(&mut state, &vec![q; n], iterative).unwrap();
        let rounds = std::env::var("SHIFT").map_or(0, |r| r.parse::<usize>().unwrap());
        let last = std::env::var("LAST").map_or(0, |r| r.parse::<usize>().unwrap());
        for _ in 0..if q == components { rounds.max(last) } else { rounds } {
            let moved = search.shift(&mut state, &vec![q; n]).unwrap();
            search.sweeps(&mut state, &vec![q; n], 2).unwrap();
            let e = error(&state.assignment.members, &state.subspaces);
            eprintln!("  shifted {moved} {e:.6} ratio {:.4} {:?}", e / stat, t.elapsed());
        }
        let e = error(&state.assignment.members, &state.subspaces);
        let mut per = vec![(0f64, 0usize); n];
        for (m, e) in state.assignment.members.iter().zip(&state.assignment.errors) { per[*m as usize].0 += f64::from(*e); per[*m as usize].1 += 1; }
        per.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mean = per.iter().map(|p| p.0).sum::<f64>() / n as f64;
        eprintln!("relative cluster errors {:?}", (0..n).step_by(n / 16).map(|i| ((per[i].0 / mean * 100.0).round() / 100.0, per[i].1)).collect::<Vec<_>>());
        eprintln!("iterative q {q} {e:.6} ratio {:.4} {:?}", e / stat, t.elapsed());
    }
}
