//! What `bicluster` can be asked for.

prt_transfer::choices! {
    /// What a sum has to save to be kept.
    pub enum Objective {
        /// Memory: a shared sum must save more indices than it takes.
        Bytes = "bytes",
        /// Operations (the paper's cost).
        Flops = "flops",
    }
}

impl Objective {
    /// Rows that a pair must have for its sum to save anything: it takes one addition or two indices, and saves one of either
    /// in every row.
    pub(crate) fn least_rows(self) -> u32 {
        match self {
            Objective::Flops => 2,
            Objective::Bytes => 3,
        }
    }
}

prt_transfer::choices! {
    /// How deep sums nest.
    pub enum Levels {
        /// Biclusters of light coefficients, grown as in the paper's Algorithm 1, and a residual.
        One = "1",
        /// As 1, and the memberships of rows in biclusters are biclustered again.
        Two = "2",
        /// Sums of sums to any depth, two terms at a time.
        All = "all",
    }
}

prt_transfer::choices! {
    /// Where a bicluster starts to grow (levels 1 and 2).
    pub enum Seeds {
        /// An element drawn at random, as in the paper.
        Random = "random",
        /// The row with the most elements left.
        Longest = "longest",
        /// The best of several starts.
        Best = "best",
    }
}

prt_transfer::params! {
    /// Sums that rows share are computed once: biclusters of light coefficients and rows. Exact unless max_error is given.
    pub struct BiclusterParams: "bicluster" {
        /// What a shared sum must save: bytes (memory) or flops (operations, the paper's cost).
        objective: Objective = Objective::Bytes,
        /// Nesting of sums: 1 (biclusters grown as in the paper), 2 (their memberships biclustered again), or all.
        levels: Levels = Levels::All,
        /// Where biclusters of levels=1 and 2 start: random (the paper), longest or best; none = best.
        seeds: Option<Seeds> = None,
        /// Seed of seeds=random.
        seed: u64 = 0,
        /// Bound on Σ(T-T̃)²/ΣT², 0 to 1, which may be used up for elements that cost much and matter little; none = exact.
        max_error: Option<f64> = None,
    }
}
