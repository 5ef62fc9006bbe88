//! The vocabulary's promises: what is refused at the door, and what labels, matrices and sections give back.

use ndarray::Array2;
use proptest::prelude::*;
use prt_transfer::csr::Csr;
use prt_transfer::transform::Identity;
use prt_transfer::{Error, Label, LightBasis, Params, Registry, Row, Section, Sink, Source, TransferMatrix};

prt_transfer::choices! {
    /// Two ways.
    pub enum Way {
        /// One.
        Here = "here",
        /// The other.
        There = "there",
    }
}

prt_transfer::params! {
    /// A method of every kind of parameter.
    pub struct AllParams: "all" {
        /// A count.
        count: usize = 4,
        /// A bound.
        bound: f64 = 1e-3,
        /// A switch.
        switch: bool = false,
        /// A choice.
        way: Way = Way::Here,
        /// A limit, if any.
        limit: Option<usize> = None,
    }
}

fn plain(lights: usize) -> LightBasis {
    LightBasis::Plain { lights }
}

proptest! {
    #[test]
    fn parameters_read_back_what_they_print(count in 0usize..10, bound in prop_oneof![Just(1e-3), any::<f64>()], switch: bool, there: bool, limit: Option<usize>) {
        prop_assume!(bound.is_finite());
        let way = if there { Way::There } else { Way::Here };
        let params = AllParams { count, bound, switch, way, limit };
        let stage = params.to_stage();
        prop_assert_eq!(stage.params.iter().any(|(name, _)| name == "count"), count != 4);
        let label: Label = stage.to_string().parse().unwrap();
        prop_assert_eq!(AllParams::from_stage(&label.codec).unwrap(), params);
        prop_assert_eq!(label.to_string(), stage.to_string());
    }

    #[test]
    fn any_text_is_a_label_or_a_refusal_and_labels_print_as_they_were_read(text in "[a-z+:=0-9 .A-Z]{0,24}") {
        if let Ok(label) = text.parse::<Label>() {
            let printed = label.to_string();
            prop_assert_eq!(printed.parse::<Label>().unwrap(), label);
        }
    }

    #[test]
    fn sparse_and_dense_are_the_same_matrix(rows in 0usize..6, lights in 0usize..9, seed in any::<u64>()) {
        let element = |i: usize| if (seed >> (i % 61)) & 1 == 0 { 0.0 } else { (i as f32).sin() + 2.0 };
        let values: Vec<f32> = (0..rows * lights).map(element).collect();
        let dense = TransferMatrix::from_dense(values.clone(), rows, 1, plain(lights)).unwrap();
        // Stored zeros are removed at the door.
        let offsets = (0..=rows).map(|r| r * lights).collect();
        let columns = (0..rows * lights).map(|i| (i % lights) as u32).collect();
        let sparse = TransferMatrix::from_csr(offsets, columns, values, 1, plain(lights)).unwrap();
        prop_assert_eq!(dense.non_zeros(), sparse.non_zeros());
        prop_assert_eq!(sparse.as_csr().unwrap().2.len(), sparse.non_zeros());
        let light = Array2::from_shape_fn((lights, 2), |(k, c)| (k + 3 * c) as f32 - 2.5);
        let (mut a, mut b) = (Array2::zeros((rows, 2)), Array2::zeros((rows, 2)));
        dense.apply_into(light.view(), a.view_mut()).unwrap();
        sparse.apply_into(light.view(), b.view_mut()).unwrap();
        prop_assert_eq!(a, b);
        for row in 0..rows {
            prop_assert!(dense.row(row).non_zeros().eq(sparse.row(row).non_zeros()));
            let mut gathered = vec![f32::NAN; lights];
            sparse.gather(row, &mut gathered);
            prop_assert_eq!(Row::Dense(&gathered), dense.row(row));
        }
    }
}

#[test]
fn matrices_are_checked_at_the_door() {
    let csr = |offsets: &[usize], columns: &[u32], values: &[f32]| {
        TransferMatrix::from_csr(offsets.to_vec(), columns.to_vec(), values.to_vec(), 1, plain(4))
    };
    let not_finite = |r: Result<TransferMatrix, Error>| match r.unwrap_err() {
        Error::NotFinite { row, col, .. } => (row, col),
        e => panic!("{e}"),
    };
    assert_eq!(not_finite(csr(&[0, 1, 3], &[0, 1, 3], &[1.0, 1.0, f32::NAN])), (1, 3));
    assert_eq!(not_finite(TransferMatrix::from_dense(vec![0.0, 1.0, f32::INFINITY, 0.0], 2, 1, plain(2))), (1, 0));
    for (columns, col) in [([0, 2, 2], 2), ([0, 2, 1], 1), ([0, 1, 4], 4)] {
        match csr(&[0, 0, 3], &columns, &[1.0; 3]).unwrap_err() {
            Error::Columns { row: 1, position: 2, col: found, .. } => assert_eq!(found, col),
            e => panic!("{e}"),
        }
    }
    assert!(matches!(csr(&[], &[], &[]), Err(Error::Shape { .. })));
    assert!(matches!(csr(&[1, 1], &[0], &[1.0]), Err(Error::Shape { .. })));
    assert!(matches!(csr(&[0, 2, 1], &[0], &[1.0]), Err(Error::Shape { .. })));
    assert!(matches!(csr(&[0, 1], &[0], &[]), Err(Error::Shape { .. })));
    assert!(matches!(TransferMatrix::from_dense(vec![0.0; 6], 3, 2, plain(2)), Err(Error::Unsupported { .. })));
    assert!(matches!(TransferMatrix::from_dense(vec![0.0; 5], 3, 1, plain(2)), Err(Error::Shape { .. })));
}

#[test]
fn light_and_output_of_the_wrong_size_are_refused() {
    let matrix = TransferMatrix::from_dense(vec![1.0; 6], 2, 1, plain(3)).unwrap();
    let registry = Registry::new().transform::<Identity>().codec::<Csr>();
    let method = registry.method(&"csr".parse().unwrap()).unwrap();
    let encoded = method.encode(&matrix, &prt_transfer::Quiet).unwrap();
    for (lights, rows, channels) in [(2, 2, 1), (3, 3, 1), (3, 2, 2)] {
        let light = Array2::<f32>::zeros((lights, 1));
        let mut out = Array2::zeros((rows, channels));
        assert!(matches!(encoded.apply_into(light.view(), out.view_mut()), Err(Error::Shape { .. })));
        assert!(matches!(matrix.apply_into(light.view(), out.view_mut()), Err(Error::Shape { .. })));
    }
    assert!(encoded.flops(&[0.0; 2]).is_err());
}

#[test]
fn a_section_is_read_once_whole_and_by_its_own_name() {
    let mut sink = Sink::new();
    sink.put("index/a", &[1u16, 2, 3]);
    sink.put("weights/b", &[0.5f32, f32::NAN]);
    assert_eq!(sink.resident_bytes(), 6 + 8);
    let sections = sink.into_sections();
    let mut source = Source::new(sections.clone()).unwrap();
    assert_eq!(source.take_exact::<u16>("index/a", 3).unwrap(), [1, 2, 3]);
    assert!(source.take::<u16>("index/a").is_err());
    assert!(source.take_finite("weights/b", 2).is_err());
    let mut source = Source::new(sections.clone()).unwrap();
    assert!(source.take::<u32>("index/a").is_err(), "6 bytes are no u32s");
    assert!(source.finish().is_err(), "a section was left");
    assert!(Source::new(vec![sections[0].clone(), Section { name: "index/a".into(), bytes: vec![] }]).is_err());
}
