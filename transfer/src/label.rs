//! Labels: a method's whole configuration in one line, `haar:scale=sphere+truncate:terms=64`.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// One stage of a label: a name and the parameters that were given.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Stage {
    /// The name of the codec, transform or model.
    pub name: String,
    /// Parameters as written, in order: name and value.
    pub params: Vec<(String, String)>,
}

/// A transform and a codec; the transform is `identity` where none is written.
///
/// ```
/// let label: prt_transfer::Label = "haar+truncate:terms=64".parse().unwrap();
/// assert_eq!(label.transform.name, "haar");
/// assert_eq!(label.to_string(), "haar+truncate:terms=64");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Label {
    /// The light transform.
    pub transform: Stage,
    /// The codec.
    pub codec: Stage,
}

impl Stage {
    /// A stage with every parameter at its default.
    pub fn named(name: &str) -> Stage {
        Stage { name: name.into(), params: Vec::new() }
    }

    fn parse(text: &str, label: &str) -> Result<Stage> {
        let fail = |problem: String| Err(Error::Label { label: label.into(), problem });
        let word =
            |w: &str| !w.is_empty() && w.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        if !name.split('-').all(word) {
            return fail(format!("'{name}' is not a name (words of a-z, 0-9, _ joined by -)"));
        }
        let mut params: Vec<(String, String)> = Vec::new();
        for part in parts {
            let Some((key, value)) = part.split_once('=') else {
                return fail(format!("'{part}' must be name=value"));
            };
            if value.contains(',') {
                return fail(format!("'{part}': parameters are separated by ':', not ','"));
            }
            if !word(key) || value.is_empty() {
                return fail(format!("'{part}' must be name=value"));
            }
            if params.iter().any(|(k, _)| k == key) {
                return fail(format!("'{key}' is given twice"));
            }
            params.push((key.into(), value.into()));
        }
        Ok(Stage { name: name.into(), params })
    }
}

/// A stage by itself, such as `cook-torrance:roughness=0.3`.
impl FromStr for Stage {
    type Err = Error;

    fn from_str(text: &str) -> Result<Stage> {
        Stage::parse(text, text)
    }
}

impl FromStr for Label {
    type Err = Error;

    fn from_str(text: &str) -> Result<Label> {
        let stages: Vec<&str> = text.split('+').collect();
        match stages[..] {
            [codec] => Ok(Label { transform: Stage::named("identity"), codec: Stage::parse(codec, text)? }),
            [transform, codec] => {
                Ok(Label { transform: Stage::parse(transform, text)?, codec: Stage::parse(codec, text)? })
            }
            _ => Err(Error::Label {
                label: text.into(),
                problem: format!("{} stages; a label has at most two, transform+codec", stages.len()),
            }),
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        self.params.iter().try_for_each(|(k, v)| write!(f, ":{k}={v}"))
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.transform != Stage::named("identity") {
            write!(f, "{}+", self.transform)?;
        }
        write!(f, "{}", self.codec)
    }
}
