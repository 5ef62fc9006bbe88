//! Lobes that were given travel with the matrix.

use ndarray::Array2;
use proptest::prelude::*;
use prt_srbf::{Centers, Srbf, SrbfParams};
use prt_transfer::basis::Direction;
use prt_transfer::dense::{Dense, DenseParams};
use prt_transfer::sections::Section;
use prt_transfer::{Compressed, Configure, LightBasis, Method, Quiet, Registry, Result, TransferMatrix};

const LOBES: [(Direction, f64); 4] =
    [([0.0, 0.6, 0.8], 9.0), ([0.48, -0.6, 0.64], 12.5), ([-1.0, 0.0, 0.0], 3.0), ([0.0, 0.6, -0.8], 20.0)];

fn registry() -> Registry {
    Registry::new().transform::<Srbf>().codec::<Dense>()
}

fn compressed() -> Compressed {
    let basis = LightBasis::Cubemap { resolution: 4 };
    let values = (0..3 * 96).map(|i| (i * 7 % 13) as f32 / 100.0).collect();
    let matrix = TransferMatrix::from_dense(values, 3, 1, basis).unwrap();
    let srbf = Srbf::with_centers(
        SrbfParams::default(),
        LOBES.iter().map(|(center, _)| *center).collect(),
        LOBES.iter().map(|(_, bandwidth)| *bandwidth).collect(),
    );
    Method::new(srbf.unwrap(), Dense::new(DenseParams {}).unwrap()).encode(&matrix, &Quiet).unwrap()
}

fn restored(sections: Vec<Section>) -> Result<Compressed> {
    registry().restore(&compressed().header(), sections)
}

fn use_all(compressed: &Compressed) {
    let mut row = vec![0f32; 96];
    (0..3).for_each(|i| compressed.row_into(i, &mut row));
    compressed.apply_into(Array2::ones((96, 2)).view(), Array2::zeros((3, 2)).view_mut()).unwrap();
    compressed.flops(&row).unwrap();
}

#[test]
fn given_lobes_come_back_from_their_sections_and_the_label_says_that_they_were_given() {
    let compressed = compressed();
    assert_eq!(compressed.label().to_string(), "srbf:centers=given+dense");
    let sections = compressed.sections().into_sections();
    let sizes: Vec<_> = sections.iter().map(|s| (s.name.as_str(), s.bytes.len())).collect();
    assert_eq!(sizes[..2], [("basis/srbf-centers", 4 * 24), ("basis/srbf-bandwidths", 4 * 8)]);
    let again = restored(sections.clone()).unwrap();
    assert_eq!(again.sections().into_sections(), sections);
    let relit = |compressed: &Compressed| {
        let mut out = Array2::zeros((3, 1));
        compressed.apply_into(Array2::ones((96, 1)).view(), out.view_mut()).unwrap();
        out
    };
    assert_eq!(relit(&again), relit(&compressed));
    assert_eq!(again.resident_bytes(), compressed.resident_bytes());
    // A file of spread lobes needs none of that.
    let params = SrbfParams { centers: Centers::Count(12), ..Default::default() };
    assert_eq!(Srbf::new(params).unwrap().params().centers, Centers::Count(12));
}

#[test]
fn sections_that_are_no_lobes_are_refused_by_name() {
    let sections = compressed().sections().into_sections();
    let refused = |at: usize, bytes: Vec<u8>| {
        let mut damaged = sections.clone();
        damaged[at].bytes = bytes;
        restored(damaged).err().expect("refused").to_string()
    };
    let numbers = |numbers: &[f64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    assert!(refused(0, vec![]).contains("srbf"));
    assert!(refused(0, numbers(&[0.0, 0.0, 1.0, 0.0])).contains("multiple of 24 bytes"));
    assert!(refused(0, numbers(&[0.5; 12])).contains("length 1"));
    assert!(refused(0, numbers(&[f64::NAN; 12])).contains("length 1"));
    assert!(refused(1, numbers(&[9.0; 3])).contains("4 numbers"));
    assert!(refused(1, numbers(&[9.0, 9.0, 9.0, 1e9])).contains("bandwidth"));
    assert!(restored(sections[1..].to_vec()).is_err() && restored(sections[..1].to_vec()).is_err());
}

#[test]
fn a_ridge_that_was_chosen_is_in_the_file_and_not_chosen_anew() {
    let params = SrbfParams { centers: Centers::Count(162), ..Default::default() };
    let matrix = TransferMatrix::from_dense(vec![0.25; 96], 1, 1, LightBasis::Cubemap { resolution: 4 }).unwrap();
    let method = Method::new(Srbf::new(params).unwrap(), Dense::new(DenseParams {}).unwrap());
    let compressed = method.encode(&matrix, &Quiet).unwrap();
    let sections = compressed.sections().into_sections();
    assert_eq!(sections[0].name, "header/srbf-ridge");
    let with = |share: f64| {
        let mut changed = sections.clone();
        changed[0].bytes = share.to_le_bytes().to_vec();
        registry().restore(&compressed.header(), changed)
    };
    assert!(with(1e-3).unwrap().note().unwrap().contains("1.0e-3"));
    for bad in [0.0, -1e-3, 2.0, f64::NAN, f64::INFINITY, 1e-30] {
        assert!(with(bad).is_err(), "{bad}");
    }
    assert!(registry().restore(&compressed.header(), sections[1..].to_vec()).is_err(), "singular without");
}

proptest! {
    #[test]
    fn damaged_sections_never_panic(at in 0usize..2, bits in prop::collection::vec(any::<prop::sample::Index>(), 1..6), cut in any::<bool>()) {
        let mut sections = compressed().sections().into_sections();
        let bytes = &mut sections[at].bytes;
        for bit in bits {
            let bit = bit.index(8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        if cut {
            bytes.truncate(bytes.len() - 8);
        }
        if let Ok(accepted) = restored(sections) {
            use_all(&accepted);
        }
    }
}
