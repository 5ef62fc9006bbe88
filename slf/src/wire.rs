//! Sections of a light field: those of Eq. 5, and a header.

use crate::encoded::EncodedSlf;
use crate::layout::{Layout, fields};
use crate::maps::{KINDS, Maps, images};
use crate::params::Colour;
use prt_transfer::ids::Ids;
use prt_transfer::numbers::{Numbers, Sections, Width};
use prt_transfer::sections::broken;
use prt_transfer::{Result, Shape, Sink, Source};

const HEADER: &str = "header/layout";
const MAPS: &str = "header/maps";
const IDS: &str = "index/clusters";
pub(crate) const SURFACE: Sections = Sections { numbers: "weights/surface", scales: "weights/surface-scales" };
pub(crate) const VIEWS: Sections = Sections { numbers: "basis/views", scales: "basis/views-scales" };
pub(crate) const MEANS: Sections = Sections { numbers: "weights/mean", scales: "weights/mean-scales" };

pub(crate) fn write(encoded: &EncodedSlf, sink: &mut Sink) {
    let EncodedSlf { layout, surface, views, means, maps, .. } = encoded;
    write_index(encoded, sink);
    let Some(maps) = maps else { return write_numbers(encoded, sink) };
    let images = images(layout, maps.sizes);
    for (kind, (numbers, to)) in [(surface, SURFACE), (views, VIEWS), (means, MEANS)].into_iter().enumerate() {
        // Rounded again they are the same codes: a number of single precision is much nearer to its own than to any other.
        let values = numbers.unpack(0..numbers.len(), 0, &mut Vec::new()).to_vec();
        maps.coded(layout, kind, &values).write_sorted(sink, to, images[kind].each());
    }
}

/// As memory holds it.
pub(crate) fn hold(encoded: &EncodedSlf, sink: &mut Sink) {
    write_index(encoded, sink);
    write_numbers(encoded, sink);
    if let Some(maps) = &encoded.maps {
        [SURFACE, VIEWS, MEANS].iter().zip(&maps.scales).for_each(|(to, scales)| sink.put(to.scales, scales));
    }
}

fn write_numbers(encoded: &EncodedSlf, sink: &mut Sink) {
    encoded.surface.write(sink, SURFACE);
    encoded.views.write(sink, VIEWS);
    encoded.means.write(sink, MEANS);
}

/// Header and ids.
fn write_index(encoded: &EncodedSlf, sink: &mut Sink) {
    let EncodedSlf { layout, surface, views, .. } = encoded;
    let mut header = vec![layout.colour as u32, layout.components as u32, surface.width() as u32, views.width() as u32];
    // Ids are 32 bits, so that a number of clusters fits one.
    header.extend((0..layout.fields()).map(|field| layout.clusters_of(field) as u32));
    sink.put(HEADER, &header);
    if let Some(maps) = &encoded.maps {
        let waves = maps.waves.iter().enumerate().map(|(kind, waves)| u32::from(*waves) << kind).sum();
        // Sizes are those of a matrix, whose sides are below 2^32 where it has elements.
        let sizes = maps.sizes.as_flattened().iter().map(|size| *size as u32);
        sink.put(MAPS, &sizes.chain([waves]).collect::<Vec<u32>>());
    }
    encoded.ids.write_to(sink, IDS);
}

/// Reads what [`write`] wrote.
pub(crate) fn read(shape: Shape, source: &mut Source) -> Result<EncodedSlf> {
    let header: Vec<u32> = source.take(HEADER)?;
    let (&[colour, components, surface, views], clusters) =
        header.split_first_chunk().ok_or_else(|| broken(HEADER, "5 numbers or more", header.len().to_string()))?;
    let layout = layout(shape, colour, components as usize, clusters)?;
    let [of_surface, of_views] = [Width::of_code(surface, HEADER)?, Width::of_code(views, HEADER)?];
    let ids = read_ids(source, &layout)?;
    if source.has(MAPS) {
        if [of_surface, of_views] != [Width::F32; 2] {
            return Err(broken(HEADER, "widths 0 (f32) of rounded images", format!("{surface} and {views}")));
        }
        return read_maps(source, layout, ids);
    }
    let count = [layout.surface_numbers(), layout.surface_vectors()];
    let surface = Numbers::read(source, SURFACE, of_surface, count, layout.vectors_of_surface(&ids))?;
    let count = [layout.view_numbers(), layout.view_vectors()];
    let views = Numbers::read(source, VIEWS, of_views, count, layout.vectors_of_views())?;
    let count = [shape.rows(), layout.mean_vectors()];
    let means = Numbers::read(source, MEANS, of_surface, count, layout.vectors_of_means(&ids))?;
    Ok(EncodedSlf { layout, ids, surface, views, means, maps: None, note: None })
}

/// Maps that are rounded images.
fn read_maps(source: &mut Source, layout: Layout, ids: Ids) -> Result<EncodedSlf> {
    let header: Vec<u32> = source.take_exact(MAPS, 5)?;
    let sizes = [0, 2].map(|i| [header[i] as usize, header[i + 1] as usize]);
    for (size, count) in sizes.iter().zip([layout.shape.samples, layout.shape.lights]) {
        if size[0].checked_mul(size[1]) != Some(count) {
            return Err(broken(MAPS, format!("images of {count} pixels"), format!("{} x {}", size[0], size[1])));
        }
    }
    if header[4] >= 1 << KINDS {
        return Err(broken(MAPS, format!("flags below {}", 1 << KINDS), header[4].to_string()));
    }
    let waves = std::array::from_fn(|kind| header[4] >> kind & 1 == 1);
    let mut maps = Maps { sizes, waves, scales: std::array::from_fn(|_| Vec::new()) };
    let (images, counts) =
        (images(&layout, sizes), [layout.surface_numbers(), layout.view_numbers(), layout.shape.rows()]);
    let mut read = |kind: usize, from: Sections| {
        let count = [counts[kind], images[kind].count()];
        let codes = Numbers::read_sorted(source, from, Width::I16, count, images[kind].each())?;
        maps.scales[kind] = codes.scales().unwrap_or_default().to_vec();
        Ok(Numbers::F32(maps.restored(&layout, kind, &codes)))
    };
    let (surface, views, means) = (read(0, SURFACE)?, read(1, VIEWS)?, read(2, MEANS)?);
    Ok(EncodedSlf { layout, ids, surface, views, means, maps: Some(maps), note: None })
}

fn layout(shape: Shape, colour: u32, components: usize, clusters: &[u32]) -> Result<Layout> {
    let colour = [Colour::Shared, Colour::Separate, Colour::Joint]
        .into_iter()
        .find(|known| *known as u32 == colour)
        .ok_or_else(|| broken(HEADER, "colours 0 (shared), 1 (separate) or 2 (joint)", colour.to_string()))?;
    let fields = fields(colour, shape);
    if clusters.len() != fields {
        return Err(broken(HEADER, format!("clusters of {fields} fields"), clusters.len().to_string()));
    }
    // Clusters without numbers would cost a file nothing; texels it had to earn.
    let (least, most) = (shape.samples.min(1), shape.samples);
    if let Some(found) = clusters.iter().find(|&&c| (c as usize) < least || c as usize > most) {
        return Err(broken(HEADER, format!("{least} to {most} clusters, the texels"), found.to_string()));
    }
    let numbers = if colour == Colour::Joint { shape.responses * shape.lights } else { shape.lights };
    let most = numbers.min(shape.samples);
    if components > most {
        return Err(broken(HEADER, format!("0 to {most} components"), components.to_string()));
    }
    let clusters: Vec<usize> = clusters.iter().map(|&c| c as usize).collect();
    Ok(Layout::new(colour, shape, components, &clusters))
}

fn read_ids(source: &mut Source, layout: &Layout) -> Result<Ids> {
    let (fields, count) = (layout.fields(), layout.shape.samples * layout.fields());
    let ids = Ids::read_from(source, IDS, count, layout.most_clusters())?;
    // One cluster has no ids, and texels that no byte stands for may be without number.
    let given = if layout.most_clusters() > 1 { count } else { 0 };
    match (0..given).find(|&at| ids.at(at) as usize >= layout.clusters_of(at % fields)) {
        Some(at) => {
            let found = format!("{} of texel {}, channel {}", ids.at(at), at / fields, at % fields);
            Err(broken(IDS, format!("clusters below {}", layout.clusters_of(at % fields)), found))
        }
        None => Ok(ids),
    }
}
