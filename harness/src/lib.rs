//! The `prt` program as a library: the registry of every method, measuring on the reloaded object, charts and reports.
//!
//! [`registry::registry`] knows every transform and codec of the workspace; [`measure::Bench`] takes a method through
//! its file and fills a [`row::Row`]; [`mod@bench`] does so for a whole [`suite::Suite`] and draws what came out;
//! [`tables`] does so for the tables of a paper, [`figures`] for its figures, [`stability`] for matrices on which methods fail.

pub mod assets;
pub mod bench;
pub mod cache;
pub mod charts;
pub mod cli;
pub mod coherence;
pub mod compare;
pub mod compute;
pub mod decode;
pub mod encode;
pub mod error_sums;
pub mod family;
pub mod figures;
pub mod files;
pub mod fingerprint;
pub mod fit_light;
pub mod forecast;
pub mod frontier;
pub mod info;
pub mod interchange;
pub mod labels;
pub mod light_field;
pub mod lights;
pub mod list;
pub mod lobe_file;
pub mod machine;
pub mod measure;
pub mod memory;
pub mod number;
pub mod operator;
pub mod pictures;
pub mod png;
pub mod precompute;
pub mod progress;
pub mod registry;
pub mod relight;
pub mod render;
pub mod report;
pub mod results;
pub mod row;
pub mod scenes;
pub mod select;
pub mod signal;
pub mod stability;
pub mod suite;
pub mod table;
pub mod tables;
pub mod terminal;
pub mod timing;
pub mod verify;
pub mod worlds;
