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
