//! Reads what was written, trusting nothing.

use super::frame::Frame;
use super::sky::Sky;
use super::{BLOCK_SAMPLES, EncodedVisibility, MAX_LEVELS};
use crate::codec::Restore;
use crate::error::Result;
use crate::hemisphere::MAX_EDGE;
use crate::matrix::Shape;
use crate::narrow::Whole;
use crate::sections::{Source, broken};

const LAYOUT: &str = "header/layout";

impl Restore for EncodedVisibility {
    const TAG: &'static str = "visibility.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedVisibility> {
        let header: Vec<i32> = source.take_exact(LAYOUT, 3)?;
        let sky = usize::try_from(header[0]).ok().filter(|edge| (1..=Sky::MAX_EDGE).contains(edge));
        let sky = sky.and_then(|edge| Sky::with_texels(shape.lights, edge)).ok_or_else(|| {
            let expected = format!("1 to {} samples along an edge of a cubemap's texel", Sky::MAX_EDGE);
            broken(LAYOUT, expected, format!("{} for {} lights", header[0], shape.lights))
        })?;
        if shape.responses > MAX_EDGE * MAX_EDGE {
            return Err(broken(
                LAYOUT,
                format!("at most {MAX_EDGE} x {MAX_EDGE} responses"),
                shape.responses.to_string(),
            ));
        }
        let encoded = EncodedVisibility {
            shape,
            sky,
            directions: source.take_exact("basis/directions", shape.responses)?,
            frames: source.take_exact("basis/frames", shape.samples)?,
            levels: source.take("weights/levels")?,
            counts: Whole::read(source, "index/counts", LAYOUT, header[1])?,
            starts: source.take_exact("index/starts", shape.samples.div_ceil(BLOCK_SAMPLES))?,
            lengths: source.take("index/lengths")?,
            symbols: Whole::read(source, "weights/symbols", LAYOUT, header[2])?,
            exceptions: source.take("index/exceptions")?,
        };
        encoded.check_numbers()?;
        encoded.check_runs()?;
        encoded.check_exceptions()?;
        Ok(encoded)
    }
}

impl EncodedVisibility {
    /// Directions near unit length, frames that are rotations, levels that are distinct numbers.
    fn check_numbers(&self) -> Result<()> {
        let unit = |d: &[f32; 3]| (d.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5;
        if let Some(i) = self.directions.iter().position(|d| !unit(d)) {
            return Err(broken("basis/directions", "unit vectors", format!("{:?} at {i}", self.directions[i])));
        }
        if let Some(i) = self.frames.iter().position(|f| *f == Frame([0; 4])) {
            return Err(broken("basis/frames", "quaternions other than 0", format!("0 at {i}")));
        }
        let good = self.levels.iter().all(|l| l.is_finite() && *l != 0.0) && self.levels.is_sorted_by(|a, b| a < b);
        if !good || self.levels.len() > MAX_LEVELS {
            let expected = format!("at most {MAX_LEVELS} ascending finite numbers other than 0");
            return Err(broken("weights/levels", expected, format!("{} others", self.levels.len())));
        }
        Ok(())
    }

    /// Every sample's runs add up to the lights and have symbols that there are.
    fn check_runs(&self) -> Result<()> {
        let numbers = |section, expected, found| match expected == found {
            true => Ok(()),
            false => Err(broken(section, format!("{expected} numbers"), format!("{found} numbers"))),
        };
        numbers("index/counts", self.shape.samples, self.counts.len())?;
        numbers("weights/symbols", self.lengths.len(), self.symbols.len())?;
        let mut start = 0;
        for sample in 0..self.shape.samples {
            if sample % BLOCK_SAMPLES == 0 && self.starts[sample / BLOCK_SAMPLES] != start as u64 {
                let found = self.starts[sample / BLOCK_SAMPLES].to_string();
                return Err(broken("index/starts", format!("{start}, the runs before sample {sample}"), found));
            }
            // No overflow: a count is below 2^32, and start at most the number of runs.
            let end = start + self.counts.at(sample);
            let lengths = self.lengths.get(start..end).ok_or_else(|| {
                let found = format!("{} runs", self.lengths.len());
                broken("index/lengths", format!("at least {end} runs, up to sample {sample}"), found)
            })?;
            let columns: usize = lengths.iter().map(|&length| usize::from(length) + 1).sum();
            if columns != self.shape.lights {
                let expected = format!("runs of {} columns in sample {sample}", self.shape.lights);
                return Err(broken("index/lengths", expected, columns.to_string()));
            }
            start = end;
        }
        numbers("index/lengths", start, self.lengths.len())?;
        let symbols = 2 + 2 * self.levels.len();
        match self.symbols.len() > 0 && self.symbols.max() >= symbols {
            true => Err(broken("weights/symbols", format!("below {symbols}"), self.symbols.max().to_string())),
            false => Ok(()),
        }
    }

    /// Exceptions ascend and name samples, columns and responses that there are.
    fn check_exceptions(&self) -> Result<()> {
        let Shape { samples, responses, lights } = self.shape;
        let inside =
            |e: &[u32; 3]| (e[0] as usize) < samples && (e[1] as usize) < lights && (e[2] as usize) < responses;
        let ascending = self.exceptions.is_sorted_by(|a, b| a[..2] < b[..2]);
        match ascending && self.exceptions.iter().all(inside) {
            true => Ok(()),
            false => {
                let expected = format!("samples below {samples} and columns below {lights} ascending, responses below");
                Err(broken("index/exceptions", format!("{expected} {responses}"), "others"))
            }
        }
    }
}
