//! Tucker decompositions of arrays of any number of modes.
