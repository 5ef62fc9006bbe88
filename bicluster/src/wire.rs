//! Sections of shared sums.

use crate::sums::{Columns, Sums};
use prt_transfer::compact::EncodedCompact;
use prt_transfer::sections::broken;
use prt_transfer::{Encoded, Restore, Result, Shape, Sink, Source};

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
    if !sums.regions.is_empty() {
        sink.put("index/regions", &sums.regions);
    }
    if let Some(rest) = &sums.rest {
        sink.nest("rest", |sink| rest.write(sink));
    }
}

/// Reads what [`write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<Sums> {
    let mut sums = Sums {
        shape,
        slots: source.take_exact("index/slots", shape.rows())?,
        blocks: triples(source.take("index/blocks")?)?,
        factors: source.take("weights/factors")?,
        runs: source.take("index/runs")?,
        columns: match Columns::up_to(shape.lights) {
            Columns::U16(_) => Columns::U16(source.take("index/columns")?),
            Columns::U32(_) => Columns::U32(source.take("index/columns")?),
        },
        arities: if source.has("index/arities") { source.take("index/arities")? } else { Vec::new() },
        inputs: source.take("index/inputs")?,
        groups: source.take("index/groups")?.as_chunks::<2>().0.to_vec(),
        terms: source.take("index/terms")?,
        regions: if source.has("index/regions") { source.take_exact("index/regions", shape.lights)? } else { Vec::new() },
        rest: match source.nested("rest") {
            Some(mut nested) => {
                let rest = EncodedCompact::read(shape, &mut nested)?;
                nested.finish()?;
                Some(Box::new(rest))
            }
            None => None,
        },
        starts: Vec::new(),
    };
    sums.starts = sums
        .find_starts()
        .ok_or_else(|| broken("index/blocks", "counts that add up to the other sections", format!("{} blocks", sums.blocks.len())))?;
    Ok(sums)
}

fn triples(numbers: Vec<u32>) -> Result<Vec<[u32; 3]>> {
    match numbers.as_chunks::<3>() {
        (triples, []) => Ok(triples.to_vec()),
        _ => Err(broken("index/blocks", "three numbers a block", format!("{} numbers", numbers.len()))),
    }
}

impl Sums {
    /// Memory that relighting holds.
    pub(crate) fn bytes(&self) -> usize {
        let mut sink = Sink::new();
        write(self, &mut sink);
        sink.resident_bytes()
    }
}
