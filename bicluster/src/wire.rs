//! Sections of shared sums.

use crate::sums::{Columns, Sums};
use crate::symbols::SYMBOLS;
use prt_transfer::compact::EncodedCompact;
use prt_transfer::sections::broken;
use prt_transfer::{Encoded, Restore, Result, Shape, Sink, Source};

/// How often a sum or row may name each leaf of its block, on average: once, and again for each residual.
const REPEATS: usize = 256;

/// Writes the arrays as they are.
pub(crate) fn write(sums: &Sums, sink: &mut Sink) {
    sink.put("index/slots", &sums.slots);
    sink.put("index/blocks", sums.blocks.as_flattened());
    sink.put("weights/factors", &sums.factors);
    sink.put("index/runs", &sums.runs);
    match &sums.columns {
        Columns::U16(columns) => sink.put("index/columns", columns),
        Columns::U32(columns) => sink.put("index/columns", columns),
    }
    if !sums.arities.is_empty() {
        sink.put("index/arities", &sums.arities);
    }
    sink.put("index/inputs", &sums.inputs);
    sink.put("index/groups", sums.groups.as_flattened());
    sink.put("index/terms", &sums.terms);
    if let Some(rest) = &sums.rest {
        sink.put("header/products", &[rest.shape().rows() as u32]);
        sink.nest("rest", |sink| rest.write(sink));
    }
}

/// As [`write`], with what the archive form needs besides.
pub(crate) fn hold(sums: &Sums, sink: &mut Sink) {
    write(sums, sink);
    if !sums.regions.is_empty() {
        sink.put("index/regions", &sums.regions);
    }
}

/// Reads what [`write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<Sums> {
    let mut sums = Sums {
        shape,
        slots: source.take_exact("index/slots", shape.rows())?,
        blocks: tuples("index/blocks", source.take("index/blocks")?)?,
        factors: source.take("weights/factors")?,
        runs: source.take("index/runs")?,
        columns: match Columns::up_to(shape.lights) {
            Columns::U16(_) => Columns::U16(source.take("index/columns")?),
            Columns::U32(_) => Columns::U32(source.take("index/columns")?),
        },
        arities: if source.has("index/arities") { source.take("index/arities")? } else { Vec::new() },
        inputs: source.take("index/inputs")?,
        groups: tuples("index/groups", source.take("index/groups")?)?,
        terms: source.take("index/terms")?,
        regions: Vec::new(),
        rest: read_rest(shape, source)?,
        starts: Vec::new(),
    };
    sums.starts = sums.find_starts().ok_or_else(|| {
        broken("index/blocks", "counts that add up to the other sections", format!("{} blocks", sums.blocks.len()))
    })?;
    sums.check()?;
    Ok(sums)
}

/// The elements that no sum covers: a row for each product, of which there are no more than rows of the matrix.
fn read_rest(shape: Shape, source: &mut Source) -> Result<Option<Box<EncodedCompact>>> {
    if !source.has("header/products") {
        return Ok(None);
    }
    let products = source.take_exact::<u32>("header/products", 1)?[0] as usize;
    let mut nested = source.nested("rest").ok_or_else(|| broken("header/products", "elements beside", "none"))?;
    if products > shape.rows() {
        return Err(broken("header/products", format!("at most {} rows", shape.rows()), products.to_string()));
    }
    let rest = EncodedCompact::read(Shape::new(products, 1, shape.lights)?, &mut nested)?;
    nested.finish()?;
    Ok(Some(Box::new(rest)))
}

fn tuples<const N: usize>(section: &str, numbers: Vec<u32>) -> Result<Vec<[u32; N]>> {
    match numbers.as_chunks::<N>() {
        (tuples, []) => Ok(tuples.to_vec()),
        _ => Err(broken(section, format!("{N} numbers each"), format!("{} numbers", numbers.len()))),
    }
}

impl Sums {
    /// Refuses sections that would lead relighting out of bounds or to values that are not numbers.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |section: &str, expected: String, found: String| Err(broken(section, expected, found));
        let with_terms = self.starts[self.blocks.len()].product;
        if self.products() < with_terms {
            return refuse("header/products", format!("at least {with_terms}"), self.products().to_string());
        }
        if let Some(slot) = self.slots.iter().find(|&&s| s as usize > self.products()) {
            return refuse("index/slots", format!("products up to {}", self.products()), slot.to_string());
        }
        if let Some(factor) = self.factors.iter().find(|f| !f.is_finite()) {
            return refuse("weights/factors", "finite numbers".into(), factor.to_string());
        }
        if let Some(leaf) = (0..self.columns.len()).find(|&leaf| self.columns.at(leaf) >= self.shape.lights) {
            let found = self.columns.at(leaf).to_string();
            return refuse("index/columns", format!("columns below {}", self.shape.lights), found);
        }
        if let Some(arity) = self.arities.iter().find(|&&n| n < 2) {
            return refuse("index/arities", "sums of at least 2 terms".into(), arity.to_string());
        }
        if let Some(group) = self.groups.iter().find(|g| g[0] == 0) {
            return refuse("index/groups", "rows of at least 1 term".into(), format!("{group:?}"));
        }
        for (block, ends) in self.starts.windows(2).enumerate() {
            let (start, end) = (ends[0], ends[1]);
            let leaves = end.leaf - start.leaf;
            let symbols = leaves + end.sum - start.sum;
            if symbols > SYMBOLS {
                return refuse(
                    "index/blocks",
                    format!("at most {SYMBOLS} symbols"),
                    format!("{symbols} in block {block}"),
                );
            }
            // Sums of sums could name more leaves than a decoder ever finishes with.
            let most = REPEATS * leaves.min(self.shape.lights);
            let mut expanded = vec![1usize; leaves];
            let mut inputs = &self.inputs[start.input..end.input];
            for sum in start.sum..end.sum {
                let (terms, rest) = inputs.split_at(self.arity(sum));
                inputs = rest;
                let known = leaves + sum - start.sum;
                if let Some(term) = terms.iter().find(|&&t| usize::from(t) >= known) {
                    return refuse("index/inputs", format!("symbols below {known} in block {block}"), term.to_string());
                }
                let own: usize = terms.iter().map(|&t| expanded[usize::from(t)]).sum();
                if own > most {
                    return refuse("index/inputs", format!("at most {most} leaves in a sum"), own.to_string());
                }
                expanded.push(own);
            }
            if let Some(term) = self.terms[start.term..end.term].iter().find(|&&t| usize::from(t) >= symbols) {
                return refuse("index/terms", format!("symbols below {symbols} in block {block}"), term.to_string());
            }
            for product in start.product..end.product {
                let own: usize = self.terms_of(product).1.iter().map(|&t| expanded[usize::from(t)]).sum();
                if own > most {
                    return refuse("index/terms", format!("at most {most} leaves in a row"), own.to_string());
                }
            }
        }
        Ok(())
    }
}
