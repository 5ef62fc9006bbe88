//! Every element as f32.
