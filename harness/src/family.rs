//! Methods of one family share a marker: the same transform and codec, whatever their parameters.

use prt_transfer::Label;

/// `transform+codec`, or the codec alone: `haar+truncate` for `haar+truncate:terms=64`.
pub fn family(label: &Label) -> String {
    match label.transform.name.as_str() {
        "identity" => label.codec.name.clone(),
        transform => format!("{transform}+{}", label.codec.name),
    }
}

/// The family of a method's label; a text that is no label is a family of its own.
pub fn of(method: &str) -> String {
    method.parse().map_or_else(|_| method.into(), |label| family(&label))
}

/// What tells a method from the others of its family: the values of its parameters; the whole label where it has none.
pub fn distinction(label: &Label) -> String {
    let stages = [&label.transform, &label.codec];
    let values: Vec<&str> = stages.iter().flat_map(|s| &s.params).map(|(_, value)| value.as_str()).collect();
    if values.is_empty() { label.to_string() } else { values.join(" ") }
}

/// Each family once, in the order of its first member: that order decides the markers.
pub fn in_order<'a>(families: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut order: Vec<String> = Vec::new();
    for family in families {
        if !order.iter().any(|known| known == family) {
            order.push(family.into());
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_keeps_the_place_of_its_first_member() {
        assert_eq!(in_order(["b", "a", "b", "c", "a"].into_iter()), ["b", "a", "c"]);
    }

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
