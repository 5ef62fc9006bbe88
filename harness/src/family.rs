//! Methods of one family share a marker: the same transform and codec, whatever their parameters.

use prt_transfer::Label;

/// `transform+codec`, or the codec alone: `haar+truncate` for `haar+truncate:terms=64`.
pub fn family(label: &Label) -> String {
    match label.transform.name.as_str() {
        "identity" => label.codec.name.clone(),
        transform => format!("{transform}+{}", label.codec.name),
    }
}

/// What tells a method from the others of its family: the values of its parameters; the whole label where it has none.
pub fn distinction(label: &Label) -> String {
    let stages = [&label.transform, &label.codec];
    let values: Vec<&str> = stages.iter().flat_map(|s| &s.params).map(|(_, value)| value.as_str()).collect();
    if values.is_empty() { label.to_string() } else { values.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_is_its_family_and_its_distinction() {
        let of = |text: &str| {
            let label: Label = text.parse().unwrap();
            (family(&label), distinction(&label))
        };
        assert_eq!(of("csr"), ("csr".into(), "csr".into()));
        assert_eq!(of("haar+truncate:terms=64"), ("haar+truncate".into(), "64".into()));
        assert_eq!(of("haar:scale=sphere+truncate:terms=64"), ("haar+truncate".into(), "sphere 64".into()));
        assert_eq!(of("sh:order=5+dense"), ("sh+dense".into(), "5".into()));
    }
}
