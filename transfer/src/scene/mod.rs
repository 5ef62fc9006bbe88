//! Scenes, visibility and signals.
