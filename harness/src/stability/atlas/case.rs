//! A way to fail, as data: one parameter from harmless to hopeless, the form in the paper and ours, and what ours promises.

use prt_transfer::Result;

/// One way to fail.
pub struct Case {
    /// On the command line and in the CSV.
    pub name: &'static str,
    /// What fails, and why.
    pub title: &'static str,
    /// Paper, section, equation; or whose formula it is.
    pub source: &'static str,
    /// What is driven from harmless to hopeless, unit included.
    pub parameter: &'static str,
    /// Its values, from harmless to hopeless; above 0.
    pub values: &'static [f64],
    /// What both forms are judged by: less is better.
    pub quantity: &'static str,
    /// The paper's form, or where the paper has none what a reader would write.
    pub printed: Form,
    /// What this workspace does.
    pub here: Form,
    /// The most that ours comes to at a value.
    pub bound: fn(f64) -> f64,
    /// The bound in words.
    pub promise: &'static str,
    /// From this value on the printed form is beyond the bound; none where it is within it everywhere.
    pub breaks: Option<f64>,
}

/// A way to compute something, and what came of it.
pub struct Form {
    /// In legends.
    pub name: &'static str,
    /// The quantity at a value of the parameter. What is no number any more is infinite or NaN.
    pub figure: fn(f64) -> Result<f64>,
}

/// Ways to fail of one kind of method.
pub struct Part {
    /// On the command line and for file names.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}
