//! What is tried of each method: a family is a label, the parameters that make its models larger and better, and the points of
//! `prt bench`. A codec that has no family here is a family of its own with one point, its defaults.

pub use super::family::{Axis, Counts, Extent, Family, Kind, Start};

use prt_transfer::{Label, Registry, Result};

/// Every family that fits a matrix, those of codecs without an entry last.
pub fn families(registry: &Registry, kind: Kind) -> Vec<Family> {
    let listed = |name: &str| FAMILIES.iter().any(|f| codec_of(f.base) == name);
    let codecs = registry.codecs();
    let others = codecs.iter().filter(|about| !listed(about.name)).map(|about| alone(about.name));
    FAMILIES.iter().copied().chain(others).filter(|family| (family.fits)(kind)).collect()
}

/// The family that a label belongs to, and what all of its labels begin with: the family's own parameters, and over them those of the label. A
/// label that belongs to none is a family of its own with one model.
///
/// # Errors
/// A label that describes no method.
pub fn named(registry: &Registry, label: &str) -> Result<(Family, Label)> {
    let given: Label = label.parse()?;
    registry.method(&given)?;
    if let Some(family) = FAMILIES.iter().find(|family| family.base == label) {
        return Ok((*family, given));
    }
    for family in &FAMILIES {
        let mut base: Label = family.base.parse()?;
        if [&base.transform.name, &base.codec.name] == [&given.transform.name, &given.codec.name] {
            for (own, given) in [(&mut base.transform, &given.transform), (&mut base.codec, &given.codec)] {
                own.params.retain(|(name, _)| given.params.iter().all(|(other, _)| other != name));
                own.params.extend(given.params.iter().cloned());
            }
            return Ok((*family, base));
        }
    }
    Ok((EVERYWHERE, given))
}

/// The codec's name in a label.
fn codec_of(label: &str) -> &str {
    let codec = label.rsplit('+').next().unwrap_or(label);
    codec.split(':').next().unwrap_or(codec)
}

fn alone(codec: &'static str) -> Family {
    Family { base: codec, ..EVERYWHERE }
}

fn any(_: Kind) -> bool {
    true
}
fn visibility(kind: Kind) -> bool {
    kind == Kind::Biscale
}
fn field(kind: Kind) -> bool {
    kind == Kind::Field
}
fn transfer(kind: Kind) -> bool {
    kind != Kind::Field
}
/// Light on a cubemap.
fn cubemap(kind: Kind) -> bool {
    matches!(kind, Kind::Biscale | Kind::Diffuse | Kind::Terms)
}
/// A sample of `biscale`, D² x lights numbers, is too long a vector to be clustered.
fn vectors(kind: Kind) -> bool {
    kind != Kind::Biscale
}
/// One of `terms` is so too, unless its light is transformed first.
fn short_vectors(kind: Kind) -> bool {
    vectors(kind) && kind != Kind::Terms
}
/// Transfer whose light can be transformed before samples are clustered.
fn transformed_vectors(kind: Kind) -> bool {
    matches!(kind, Kind::Diffuse | Kind::Terms)
}
/// Samples of several responses.
fn tensors(kind: Kind) -> bool {
    matches!(kind, Kind::Glossy | Kind::Other)
}

const EVERYWHERE: Family = Family {
    base: "",
    fits: any,
    axes: &[],
    counts: Counts::Other,
    bounded: None,
    quick: &[],
    standard: &[],
    full: &[],
};
const ON_CUBEMAPS: Family = Family { fits: cubemap, ..EVERYWHERE };
const OF_VECTORS: Family = Family { fits: vectors, ..EVERYWHERE };

const TERMS: &[&str] = &[
    "1", "2", "3", "4", "6", "8", "10", "12", "16", "20", "24", "32", "40", "48", "64", "80", "96", "128", "160",
    "192", "256", "320", "384", "512", "640", "768", "1024", "1280", "1536",
];
const COMPONENTS: &[&str] =
    &["1", "2", "3", "4", "5", "6", "8", "10", "12", "14", "16", "20", "24", "28", "32", "40", "48", "64"];

const AXIS: Axis =
    Axis { parameters: &[], values: &[], extent: Extent::Free, start: Start::Middle, whole: false, stored: false };
const TERMS_AXIS: Axis =
    Axis { parameters: &["truncate:terms"], values: TERMS, extent: Extent::Lights, whole: true, ..AXIS };
const BITS_AXIS: Axis = Axis { parameters: &["truncate:bits"], values: &["8", "16", "32"], ..NUMBERS_AXIS };
const ORDER_AXIS: Axis = Axis {
    parameters: &["sh:order"],
    values: &["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "12", "14", "16", "18", "20", "22", "24"],
    extent: Extent::Bands,
    whole: true,
    ..AXIS
};
const CENTRES_AXIS: Axis =
    Axis { parameters: &["srbf:centers"], values: &["12", "42", "162", "642", "2562"], extent: Extent::Lights, ..AXIS };
const COMPONENTS_AXIS: Axis = Axis { values: COMPONENTS, extent: Extent::Samples, whole: true, ..AXIS };
const CLUSTERS_AXIS: Axis = Axis {
    values: &["1", "2", "4", "8", "16", "32", "64", "128", "256"],
    extent: Extent::Samples,
    start: Start::Balanced,
    ..AXIS
};
/// How numbers are stored.
const NUMBERS_AXIS: Axis = Axis { values: &["i16", "f32"], start: Start::First, stored: true, ..AXIS };
const CPCA_COMPONENTS: Axis = Axis { parameters: &["cpca:components"], ..COMPONENTS_AXIS };
const CPCA_CLUSTERS: Axis = Axis { parameters: &["cpca:clusters"], ..CLUSTERS_AXIS };
const CPCA_NUMBERS: Axis = Axis { parameters: &["cpca:weights", "cpca:representatives"], ..NUMBERS_AXIS };
const CTA_AXES: &[Axis] = &[
    Axis {
        parameters: &["cta:sample"],
        values: &["1", "2", "3", "4", "6", "8", "12", "16", "24", "32", "48"],
        extent: Extent::Samples,
        whole: true,
        ..AXIS
    },
    Axis { parameters: &["cta:clusters"], values: &["1", "2", "4", "8", "16", "32", "64"], ..CLUSTERS_AXIS },
    Axis { parameters: &["cta:light"], values: &["8", "16", "24", "48", "96"], extent: Extent::Lights, ..AXIS },
    Axis { parameters: &["cta:view"], values: &["4", "8", "16"], extent: Extent::Responses, ..AXIS },
    Axis { parameters: &["cta:numbers"], values: &["coded", "i16"], ..NUMBERS_AXIS },
];

static FAMILIES: [Family; 23] = [
    // The rivals that a reader will think of. Every element of `biscale` would take gigabytes.
    Family { base: "dense", quick: &["dense"], ..OF_VECTORS },
    Family { base: "csr", quick: &["csr"], ..EVERYWHERE },
    Family { base: "compact", quick: &["compact"], ..EVERYWHERE },
    Family { base: "runs", quick: &["runs"], ..EVERYWHERE },
    Family { base: "f16", quick: &["f16"], ..EVERYWHERE },
    // An archive of visibility, which knows no other signal.
    Family { base: "visibility", fits: visibility, quick: &["visibility"], ..EVERYWHERE },
    Family { base: "bicluster", fits: transfer, quick: &["bicluster"], ..EVERYWHERE },
    Family {
        base: "bicluster:max_error=0.01",
        fits: visibility,
        axes: &[Axis {
            parameters: &["bicluster:max_error"],
            values: &["0.3", "0.2", "0.1", "0.05", "0.03", "0.02", "0.01", "5e-3", "2e-3", "1e-3", "3e-4", "1e-4"],
            ..AXIS
        }],
        counts: Counts::Bound,
        bounded: Some("bicluster:max_error"),
        standard: &["bicluster:max_error=0.01", "bicluster:max_error=0.1"],
        ..EVERYWHERE
    },
    Family {
        base: "bicluster:levels=1",
        fits: visibility,
        standard: &["bicluster:levels=1"],
        full: &["bicluster:objective=flops", "bicluster:levels=2", "bicluster:levels=1:seeds=random"],
        ..EVERYWHERE
    },
    Family {
        base: "truncate",
        axes: &[TERMS_AXIS, BITS_AXIS],
        counts: Counts::Terms,
        bounded: Some("truncate:max_error"),
        standard: &["truncate:terms=256"],
        full: &["truncate:terms=16", "truncate"],
        ..ON_CUBEMAPS
    },
    Family {
        base: "haar+truncate",
        axes: &[
            TERMS_AXIS,
            BITS_AXIS,
            Axis { parameters: &["haar:scale"], values: &["none", "sphere"], start: Start::First, ..AXIS },
        ],
        counts: Counts::Terms,
        bounded: Some("truncate:max_error"),
        quick: &["haar+truncate:terms=16", "haar+truncate"],
        standard: &[
            "haar+truncate:terms=32",
            "haar+truncate:terms=128",
            "haar+truncate:terms=256",
            "haar+truncate:bits=8",
        ],
        full: &[
            "haar+truncate:terms=512",
            "haar:scale=sphere+truncate",
            "haar:scale=sphere+truncate:terms=256",
            "haar+csr",
        ],
        ..ON_CUBEMAPS
    },
    Family {
        base: "sh+dense",
        axes: &[ORDER_AXIS],
        quick: &["sh+dense"],
        standard: &["sh:order=3+dense", "sh:order=8+dense"],
        full: &["sh:order=10+dense", "sh:order=16+dense", "sh:order=24+dense"],
        ..ON_CUBEMAPS
    },
    Family { base: "sh+f16", axes: &[ORDER_AXIS], full: &["sh:order=10+f16"], ..ON_CUBEMAPS },
    Family {
        base: "srbf+dense",
        fits: transformed_vectors,
        axes: &[CENTRES_AXIS],
        standard: &["srbf:centers=162+dense", "srbf+dense"],
        full: &["srbf:centers=2562+dense"],
        ..EVERYWHERE
    },
    Family {
        base: "srbf+f16",
        fits: transformed_vectors,
        axes: &[CENTRES_AXIS],
        standard: &["srbf+f16"],
        ..EVERYWHERE
    },
    Family {
        base: "vq:representatives=i16",
        fits: short_vectors,
        axes: &[Axis {
            parameters: &["vq:clusters"],
            values: &[
                "2", "3", "4", "6", "8", "12", "16", "24", "32", "48", "64", "96", "128", "192", "256", "384", "512",
                "768", "1024",
            ],
            extent: Extent::Samples,
            whole: true,
            ..AXIS
        }],
        standard: &["vq:clusters=32", "vq:clusters=128"],
        full: &["vq:clusters=512"],
        ..OF_VECTORS
    },
    Family {
        base: "pca",
        fits: short_vectors,
        axes: &[
            Axis {
                parameters: &["pca:components"],
                values: &[
                    "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "14", "16", "18", "20", "22", "24",
                    "28", "32", "36", "40", "44", "48", "56", "64", "72", "80", "96", "112", "128", "144", "160",
                    "192", "224", "256",
                ],
                ..COMPONENTS_AXIS
            },
            Axis {
                parameters: &["pca:weights", "pca:representatives"],
                values: &["i16", "f16", "f32"],
                ..NUMBERS_AXIS
            },
        ],
        counts: Counts::Components,
        bounded: Some("pca:max_error"),
        quick: &["pca"],
        standard: &["pca:components=32", "pca:weights=i16:representatives=i16:max_error=1e-3"],
        full: &["pca:components=128"],
    },
    Family {
        base: "cpca",
        fits: short_vectors,
        axes: &[
            CPCA_COMPONENTS,
            CPCA_CLUSTERS,
            CPCA_NUMBERS,
            Axis { parameters: &["cpca:mode"], values: &["static", "iterative"], start: Start::First, ..AXIS },
        ],
        counts: Counts::Components,
        bounded: Some("cpca:max_error"),
        quick: &["cpca:clusters=16"],
        standard: &[
            "cpca:clusters=4",
            "cpca:clusters=16:mode=iterative",
            "cpca:clusters=16:mode=adaptive:weights=i16:representatives=i16",
            "cpca:clusters=auto:max_error=0.01",
        ],
        full: &["cpca:clusters=64", "cpca:clusters=64:mode=iterative", "cpca:clusters=64:norm=radiance"],
    },
    Family {
        base: "srbf+cpca",
        fits: transformed_vectors,
        axes: &[CPCA_COMPONENTS, CPCA_CLUSTERS, CPCA_NUMBERS, Axis { values: &["162", "642", "2562"], ..CENTRES_AXIS }],
        standard: &["srbf+cpca:clusters=16:weights=i16:representatives=i16"],
        full: &["srbf+cpca:clusters=64", "srbf+cpca:clusters=64:mode=iterative"],
        ..OF_VECTORS
    },
    Family {
        base: "tucker",
        fits: vectors,
        axes: &[
            Axis {
                parameters: &["tucker:max_error"],
                values: &[
                    "0.5", "0.3", "0.2", "0.15", "0.1", "0.07", "0.05", "0.03", "0.02", "0.015", "0.01", "7e-3",
                    "5e-3", "3e-3", "2e-3", "1.5e-3", "1e-3", "7e-4", "5e-4", "3e-4", "2e-4", "1e-4", "3e-5", "1e-5",
                ],
                ..AXIS
            },
            Axis { parameters: &["tucker:numbers"], values: &["coded", "i16", "f32"], ..NUMBERS_AXIS },
        ],
        counts: Counts::Bound,
        bounded: Some("tucker:max_error"),
        standard: &["tucker:max_error=0.01", "tucker:max_error=1e-3"],
        full: &["srbf+tucker"],
        ..OF_VECTORS
    },
    Family {
        base: "cta",
        fits: tensors,
        axes: CTA_AXES,
        standard: &["cta:clusters=4:view=16:light=16", "cta:clusters=16:view=16:light=16:sample=12:numbers=coded"],
        full: &["cta", "cta:members=2"],
        ..OF_VECTORS
    },
    Family {
        base: "srbf+cta",
        fits: transformed_vectors,
        axes: CTA_AXES,
        quick: &["srbf:centers=162+cta:clusters=4"],
        standard: &[
            "srbf+cta:clusters=16:light=24:sample=8",
            "srbf+cta:clusters=16:light=24:sample=8:numbers=coded",
            "srbf+cta:clusters=4:view=16:sample=16:numbers=coded",
        ],
        full: &["srbf+cta", "srbf+cta:members=2", "haar:scale=sphere+cta"],
        ..OF_VECTORS
    },
    Family {
        base: "slf",
        fits: field,
        axes: &[
            Axis { parameters: &["slf:components"], ..COMPONENTS_AXIS },
            Axis { parameters: &["slf:clusters"], ..CLUSTERS_AXIS },
            Axis { parameters: &["slf:surface", "slf:views"], ..NUMBERS_AXIS },
            Axis { parameters: &["slf:maps"], values: &["haar", "plain"], ..NUMBERS_AXIS },
        ],
        bounded: Some("slf:max_error"),
        quick: &["slf:clusters=9"],
        standard: &[
            "slf:clusters=9:components=2",
            "slf:clusters=9:maps=haar",
            "slf:clusters=1:components=32:maps=haar",
            "slf:clusters=36:mode=iterative:maps=haar",
            "slf:clusters=9:norm=radiance:surface=i16:views=i16",
        ],
        full: &["slf", "slf:maps=haar"],
        ..EVERYWHERE
    },
];
