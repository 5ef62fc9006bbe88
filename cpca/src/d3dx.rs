//! The compressed PRT buffer of D3DX (`.pca`), as `D3DXSavePRTCompBufferToFile` writes it.
//!
//! Eight little-endian `u32`: samples, coefficients, channels, texture width, texture height, whether samples are
//! texels, clusters, components. Then in `f32` for each cluster its mean and its components, each of them channels x
//! coefficients; then the weights of each sample; then, with several clusters, the cluster of each sample as `u32`. The
//! documentation gives header and lengths; in which order numbers lie within a block follows from the buffers that
//! programs get from it (`ID3DXPRTCompBuffer::ExtractBasis`).
//!
//! A channel is a colour of diffuse transfer: one of our responses, each with a row of its own. A coefficient is one of
//! our lights. Every cluster has as many components there: those with fewer are filled up with zeros.

use crate::model::{Cluster, Model};
use prt_transfer::{Error, Result, Shape};

/// Numbers of the header.
const HEADER: usize = 8;

/// Bytes of a compressed PRT buffer, per vertex rather than per texel.
///
/// # Errors
/// A model that [`Model::check`] refuses, one without samples or lights, responses other than 1 or 3, sizes beyond 32
/// bits, or more than 2¹⁸ samples of one cluster without components.
pub fn to_d3dx(model: &Model) -> Result<Vec<u8>> {
    model.check()?;
    let Shape { samples, responses, lights } = model.shape;
    if !matches!(responses, 1 | 3) || samples == 0 || lights == 0 {
        return Err(Error::Unsupported {
            what: "D3DX compressed PRT buffer".into(),
            expected: "1 response of each sample, or 3 (a channel is a colour of diffuse transfer), samples and lights"
                .into(),
            found: format!("{samples} samples x {responses} responses x {lights} lights"),
        });
    }
    let clusters = model.clusters.len();
    let (n, most) = (model.dimension(), (0..clusters).map(|k| model.components(k)).max().unwrap_or_default());
    if clusters == 1 && most == 0 && samples > MOST_WITHOUT_NUMBERS {
        return Err(without_numbers(samples as u64));
    }
    let mut bytes = Vec::new();
    for number in [samples, lights, responses, 0, 0, 0, clusters, most] {
        let number = u32::try_from(number).map_err(|_| Error::TooLarge {
            what: "a size of a D3DX compressed PRT buffer".into(),
            limit: u32::MAX.into(),
            found: number as u64,
        })?;
        bytes.extend(number.to_le_bytes());
    }
    let mut put = |numbers: &[f32], count: usize| {
        let zeros = std::iter::repeat_n(&0f32, count - numbers.len());
        numbers.iter().chain(zeros).for_each(|v| bytes.extend(v.to_le_bytes()));
    };
    for cluster in &model.clusters {
        put(&cluster.mean, n);
        put(&cluster.components, most * n);
    }
    let mut weights = &model.weights[..];
    for &cluster in &model.members {
        let (own, rest) = weights.split_at(model.components(cluster as usize));
        put(own, most);
        weights = rest;
    }
    if clusters > 1 {
        model.members.iter().for_each(|id| bytes.extend(id.to_le_bytes()));
    }
    Ok(bytes)
}

/// Samples of one cluster without components: no byte stands for them, and whoever reads them takes them one by one.
const MOST_WITHOUT_NUMBERS: usize = 1 << 18;

/// The model of a compressed PRT buffer. Texture sizes are checked and forgotten: samples are texels row by row.
///
/// # Errors
/// Bytes that are no such buffer, numbers that are not finite, or a model that [`Model::check`] refuses.
pub fn from_d3dx(bytes: &[u8]) -> Result<Model> {
    let (words, rest) = bytes.as_chunks::<4>();
    let header: Option<&[[u8; 4]; HEADER]> = words.first_chunk();
    let Some(header) = header.filter(|_| rest.is_empty()) else {
        return Err(broken("length", "a header of 32 bytes and numbers of 4", format!("{} bytes", bytes.len())));
    };
    let [samples, lights, responses, texture_width, texture_height, is_texture, clusters, components] =
        header.map(u32::from_le_bytes);
    if [samples, lights, clusters].contains(&0) || !matches!(responses, 1 | 3) {
        let found = format!("{samples} samples, {lights} coefficients, {responses} channels, {clusters} clusters");
        return Err(broken("header", "at least 1 sample, coefficient and cluster, 1 or 3 channels", found));
    }
    let texels = u64::from(texture_width) * u64::from(texture_height);
    if is_texture != 0 && texels != u64::from(samples) {
        return Err(broken("header", format!("{texels} samples, one for each texel"), samples.to_string()));
    }
    // (2^32 - 1)³ · 2^32 at most: below 2^128.
    let [samples, clusters, components] = [samples, clusters, components].map(u128::from);
    let basis = clusters * (1 + components) * u128::from(lights) * u128::from(responses);
    let (weights, ids) = (samples * components, if clusters > 1 { samples } else { 0 });
    let found = (words.len() - HEADER) as u128;
    if basis.checked_add(weights + ids) != Some(found) {
        let expected = format!("{basis} numbers of the basis, {weights} weights, {ids} clusters of samples");
        return Err(broken("length", expected, format!("{found} numbers")));
    }
    // Without components and with one cluster nothing else is there of a sample.
    if weights + ids == 0 && samples > MOST_WITHOUT_NUMBERS as u128 {
        return Err(without_numbers(samples as u64));
    }
    // The numbers are there, so that their counts fit memory.
    let shape = Shape::new(samples as usize, responses as usize, lights as usize)?;
    let (basis, rest) = words[HEADER..].split_at(basis as usize);
    let (weights, ids) = rest.split_at(weights as usize);
    let numbers = |words: &[[u8; 4]]| words.iter().map(|&w| f32::from_le_bytes(w)).collect::<Vec<f32>>();
    let n = shape.responses * shape.lights;
    let cluster = |own: &[[u8; 4]]| Cluster { mean: numbers(&own[..n]), components: numbers(&own[n..]) };
    let model = Model {
        shape,
        clusters: basis.chunks_exact((1 + components as usize) * n).map(cluster).collect(),
        members: match ids.len() {
            0 => vec![0; shape.samples],
            _ => ids.iter().map(|&id| u32::from_le_bytes(id)).collect(),
        },
        weights: numbers(weights),
    };
    model.check()?;
    Ok(model)
}

/// Between the spherical harmonics of this workspace and those of D3DX, in place and in both directions: D3DX's have
/// the Condon-Shortley phase, so that coefficient l(l+1)+m changes its sign where m is odd.
pub fn change_phase(model: &mut Model) {
    let lights = model.shape.lights;
    let vectors = model.clusters.iter_mut().flat_map(|c| [&mut c.mean, &mut c.components]);
    for row in vectors.flat_map(|numbers| numbers.chunks_mut(lights.max(1))) {
        for (i, value) in row.iter_mut().enumerate() {
            // m = i - l(l+1) is odd where i is, l(l+1) being even.
            if i % 2 == 1 {
                *value = -*value;
            }
        }
    }
}

fn without_numbers(found: u64) -> Error {
    let what = "samples of a D3DX compressed PRT buffer that has no numbers of them".into();
    Error::TooLarge { what, limit: MOST_WITHOUT_NUMBERS as u64, found }
}

fn broken(place: &str, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Format { format: "pca", place: place.into(), expected: expected.into(), found: found.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(count: usize, first: f32) -> Vec<f32> {
        (0..count).map(|i| first + i as f32).collect()
    }

    /// Clusters with these numbers of components, samples in them by turns.
    fn model([samples, responses, lights]: [usize; 3], components: &[usize]) -> Model {
        let shape = Shape::new(samples, responses, lights).unwrap();
        let n = responses * lights;
        let cluster = |(k, c): (usize, &usize)| Cluster {
            mean: vector(n, 100.0 * k as f32),
            components: vector(c * n, 100.0 * k as f32 + 50.0),
        };
        let members: Vec<u32> = (0..samples).map(|p| (p % components.len()) as u32).collect();
        let weights = members.iter().map(|&k| components[k as usize]).sum();
        Model {
            shape,
            clusters: components.iter().enumerate().map(cluster).collect(),
            members,
            weights: vector(weights, -0.5),
        }
    }

    /// The layout written number by number, from its documentation.
    fn by_hand(model: &Model, components: usize) -> Vec<u8> {
        let (mut bytes, Shape { samples, responses, lights }) = (Vec::new(), model.shape);
        let clusters = model.clusters.len();
        for number in [samples, lights, responses, 0, 0, 0, clusters, components] {
            bytes.extend((number as u32).to_le_bytes());
        }
        for cluster in 0..clusters {
            for vector in 0..=components {
                for channel in 0..responses {
                    for coefficient in 0..lights {
                        let (at, own) = (channel * lights + coefficient, &model.clusters[cluster]);
                        let value = match vector {
                            0 => own.mean[at],
                            j => own.components.get((j - 1) * responses * lights + at).copied().unwrap_or(0.0),
                        };
                        bytes.extend(value.to_le_bytes());
                    }
                }
            }
        }
        let mut next = model.weights.iter();
        for &cluster in &model.members {
            let own = model.components(cluster as usize);
            (0..components).for_each(|j| bytes.extend(if j < own { *next.next().unwrap() } else { 0.0 }.to_le_bytes()));
        }
        if clusters > 1 {
            model.members.iter().for_each(|id| bytes.extend(id.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn bytes_are_those_of_the_documented_layout_and_lead_back_to_the_model() {
        for (shape, components) in
            [([5, 1, 4], &[2, 2][..]), ([4, 3, 9], &[1; 3]), ([3, 3, 4], &[2]), ([2, 1, 1], &[0, 0])]
        {
            let model = model(shape, components);
            let bytes = to_d3dx(&model).unwrap();
            assert_eq!(bytes, by_hand(&model, components[0]));
            assert_eq!(from_d3dx(&bytes).unwrap(), model);
        }
    }

    #[test]
    fn clusters_with_fewer_components_are_filled_up_with_zeros() {
        let uneven = model([5, 3, 4], &[0, 3, 1]);
        let bytes = to_d3dx(&uneven).unwrap();
        assert_eq!(bytes, by_hand(&uneven, 3));
        let read = from_d3dx(&bytes).unwrap();
        assert_eq!(read.clusters[2].components, [&uneven.clusters[2].components[..], &[0.0; 24]].concat());
        assert_eq!((read.weights.len(), &read.weights[6..9]), (15, &[uneven.weights[3], 0.0, 0.0][..]));
    }

    #[test]
    fn what_the_format_does_not_have_is_refused() {
        for shape in [[4, 2, 3], [4, 24, 25], [0, 1, 3], [4, 1, 0]] {
            let told = to_d3dx(&model(shape, &[0])).unwrap_err().to_string();
            assert!(told.contains("a channel is a colour"), "{told}");
        }
    }

    #[test]
    fn a_texture_has_as_many_texels_as_samples() {
        let bytes = to_d3dx(&model([6, 1, 4], &[1])).unwrap();
        let texture = |width: u32| {
            let sizes = [width, 3, 1].map(u32::to_le_bytes).concat();
            from_d3dx(&[&bytes[..12], &sizes, &bytes[24..]].concat())
        };
        assert_eq!(texture(2).unwrap(), model([6, 1, 4], &[1]));
        assert!(texture(3).unwrap_err().to_string().contains("9 samples"));
    }

    #[test]
    fn harmonics_of_odd_order_change_sign_and_back() {
        let mut changed = model([2, 3, 9], &[1]);
        change_phase(&mut changed);
        let mean = &changed.clusters[0].mean[9..18];
        // l, m = 0,0; 1,-1; 1,0; 1,1; 2,-2; 2,-1; 2,0; 2,1; 2,2.
        assert_eq!(mean, [9.0, -10.0, 11.0, -12.0, 13.0, -14.0, 15.0, -16.0, 17.0]);
        change_phase(&mut changed);
        assert_eq!(changed, model([2, 3, 9], &[1]));
    }

    #[test]
    fn samples_that_take_no_bytes_are_bounded() {
        let bytes = |samples: usize| to_d3dx(&model([samples, 1, 4], &[0]));
        let (mut most, refused) =
            (bytes(MOST_WITHOUT_NUMBERS).unwrap(), |found| matches!(found, Error::TooLarge { .. }));
        assert_eq!(from_d3dx(&most).unwrap().members.len(), MOST_WITHOUT_NUMBERS);
        assert!(refused(bytes(MOST_WITHOUT_NUMBERS + 1).unwrap_err()));
        for samples in [MOST_WITHOUT_NUMBERS as u32 + 1, u32::MAX] {
            most[..4].copy_from_slice(&samples.to_le_bytes());
            assert!(refused(from_d3dx(&most).unwrap_err()));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn damaged_bytes_are_refused_or_a_model(
            at in any::<prop::sample::Index>(), byte in 1u8.., length in any::<prop::sample::Index>(),
        ) {
            let bytes = to_d3dx(&model([5, 1, 4], &[2, 1])).unwrap();
            prop_assert!(from_d3dx(&bytes[..length.index(bytes.len())]).is_err());
            let (mut damaged, at) = (bytes.clone(), at.index(bytes.len()));
            damaged[at] ^= byte;
            // Of the header, only what says nothing of a buffer that is no texture may be anything.
            match from_d3dx(&damaged) {
                Ok(model) => prop_assert!(model.check().is_ok() && !(0..12).contains(&at) && !(24..28).contains(&at)),
                Err(error) => prop_assert!(!error.to_string().is_empty()),
            }
        }
    }
}
