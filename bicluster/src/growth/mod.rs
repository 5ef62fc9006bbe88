//! Growth of biclusters: the paper's Algorithm 1.
