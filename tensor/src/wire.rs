//! Sections of a clustered tensor approximation.

use crate::encoded::{EncodedCta, rows_of_lights};
use crate::layout::Layout;
use ndarray::Array2;
use prt_transfer::ids::Ids;
use prt_transfer::numbers::{Numbers, Sections, Width};
use prt_transfer::sections::broken;
use prt_transfer::{Result, Shape, Sink, Source};

const HEADER: &str = "header/layout";
const VIEW: &str = "basis/view";
const LIGHT: Sections = Sections { numbers: "basis/light", scales: "basis/light-scales" };
const DUAL: Sections = Sections { numbers: "basis/dual", scales: "basis/dual-scales" };
const WEIGHTS: Sections = Sections { numbers: "weights/weights", scales: "weights/scales" };

/// Writes everything but the layout.
pub(crate) fn write(encoded: &EncodedCta, sink: &mut Sink) {
    let EncodedCta { layout, ids, light, dual, weights, shape, .. } = encoded;
    write_others(encoded, sink);
    light.write_sorted(sink, LIGHT, rows_of_lights(layout.end().light, shape.lights));
    dual.write_sorted(sink, DUAL, layout.rows_of_duals());
    weights.write_sorted(sink, WEIGHTS, layout.rows_of_weights(shape.samples, ids));
}

/// As relighting holds it.
pub(crate) fn hold(encoded: &EncodedCta, sink: &mut Sink) {
    write_others(encoded, sink);
    encoded.light.write(sink, LIGHT);
    encoded.dual.write(sink, DUAL);
    encoded.weights.write(sink, WEIGHTS);
}

/// Everything but numbers.
fn write_others(encoded: &EncodedCta, sink: &mut Sink) {
    let EncodedCta { layout, ids, view, light, .. } = encoded;
    let width = light.width() as u32;
    // Ids are 32 bits, so that a cluster's place fits one; responses, views and memberships are fewer.
    sink.put(HEADER, &[layout.clusters() as u32, layout.memberships as u32, layout.views as u32, width]);
    if let Some(view) = view {
        sink.put(VIEW, view.as_slice().expect("a view basis is contiguous"));
    }
    ids.write(sink);
}

/// Reads what [`write`] and [`Layout::write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<EncodedCta> {
    let header: Vec<u32> = source.take_exact(HEADER, 4)?;
    let [clusters, memberships, views] = [0, 1, 2].map(|i| header[i] as usize);
    let width = Width::of_code(header[3], HEADER)?;
    // Clusters without numbers would cost a file nothing; samples it had to earn.
    if clusters < shape.samples.min(1) || clusters > shape.samples.max(1) {
        return Err(broken(HEADER, format!("1 to {} clusters, the samples", shape.samples), clusters.to_string()));
    }
    if memberships < 1 || memberships > clusters.max(1) {
        return Err(broken(HEADER, format!("1 to {clusters} clusters of a sample"), memberships.to_string()));
    }
    if views > shape.responses || views < shape.responses.min(1) {
        return Err(broken(HEADER, format!("1 to {} views, the responses", shape.responses), views.to_string()));
    }
    let view = match source.has(VIEW) {
        true => Some(source.take_finite(VIEW, shape.responses * views)?),
        false if views == shape.responses => None,
        false => return Err(broken(VIEW, "a view basis", "none")),
    };
    let view = view.map(|v| Array2::from_shape_vec((shape.responses, views), v).expect("as many as were asked for"));
    let ids = Ids::read(source, shape.samples.saturating_mul(memberships), clusters)?;
    let layout = Layout::read(source, [clusters, views, memberships], shape, &ids)?;
    let end = layout.end();
    let of_light = rows_of_lights(end.light, shape.lights);
    let count = [end.light.saturating_mul(shape.lights), end.light];
    let light = Numbers::read_sorted(source, LIGHT, width, count, of_light)?;
    let dual = Numbers::read_sorted(source, DUAL, width, [end.dual, end.sample], layout.rows_of_duals())?;
    let count = [layout.first_weight(shape.samples, &ids), end.sample];
    let of_weights = layout.rows_of_weights(shape.samples, &ids);
    let weights = Numbers::read_sorted(source, WEIGHTS, width, count, of_weights)?;
    Ok(EncodedCta { shape, layout, ids, view, light, dual, weights, note: None })
}
