//! What both layouts write and check alike.

use crate::stored::Value;
use prt_transfer::sections::broken;
use prt_transfer::{Result, Sink, Source};

/// The steps that a layout keeps: one for each row, none where values are stored as they are.
pub(crate) fn steps_of<V: Value>(steps: Vec<f32>) -> Vec<f32> {
    if V::LARGEST.is_some() { steps } else { Vec::new() }
}

/// Writes values, and steps where there are any.
pub(crate) fn put_values<V: Value>(sink: &mut Sink, values: &[V], steps: &[f32]) {
    sink.put("weights/values", values);
    if V::LARGEST.is_some() {
        sink.put("weights/steps", steps);
    }
}

/// `count` values, each a finite number.
pub(crate) fn take_values<V: Value>(source: &mut Source, count: usize) -> Result<Vec<V>> {
    let values: Vec<V> = source.take_exact("weights/values", count)?;
    match values.iter().position(|v| !v.number().is_finite()) {
        Some(at) => Err(broken("weights/values", "finite numbers", format!("{} at {at}", values[at].number()))),
        None => Ok(values),
    }
}

/// The step of each row, where values are multiples of one: not negative, and so small that every multiple is finite.
pub(crate) fn take_steps<V: Value>(source: &mut Source, rows: usize) -> Result<Vec<f32>> {
    let Some(largest) = V::LARGEST else {
        return Ok(Vec::new());
    };
    let steps = source.take_finite("weights/steps", rows)?;
    // The most negative integer is one beyond the largest.
    match steps.iter().position(|&step| step < 0.0 || !(step * (largest + 1.0)).is_finite()) {
        Some(row) => {
            let expected = format!("from 0 to {:e}", f32::MAX / (largest + 1.0));
            Err(broken("weights/steps", expected, format!("{:e} in row {row}", steps[row])))
        }
        None => Ok(steps),
    }
}

/// Refuses indices that do not ascend strictly or reach `limit`.
pub(crate) fn check_ascending(
    section: &str,
    place: impl Fn() -> String,
    indices: impl Iterator<Item = usize>,
    limit: usize,
) -> Result<()> {
    let mut least = 0;
    for (position, index) in indices.enumerate() {
        if index < least || index >= limit {
            let expected = format!("{least} to {} at position {position} of {}", limit.saturating_sub(1), place());
            return Err(broken(section, expected, index.to_string()));
        }
        least = index + 1;
    }
    Ok(())
}
