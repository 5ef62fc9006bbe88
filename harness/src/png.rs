//! A picture inside a page.

use base64::{Engine, prelude::BASE64_STANDARD};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The bytes of a PNG file; a data URL once it is serialized.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Png(pub Vec<u8>);

/// What stands before the bytes.
const SCHEME: &str = "data:image/png;base64,";

impl Serialize for Png {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&format!("{SCHEME}{}", BASE64_STANDARD.encode(&self.0)))
    }
}

impl<'de> Deserialize<'de> for Png {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Png, D::Error> {
        let url = String::deserialize(deserializer)?;
        let digits = url.strip_prefix(SCHEME).ok_or_else(|| D::Error::custom("no data URL of a PNG"))?;
        BASE64_STANDARD.decode(digits).map(Png).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::Png;

    #[test]
    fn a_picture_is_a_data_url_and_comes_back() {
        let (png, url) = (Png(vec![0xfb, 0xff, 0xbf, 0x66]), r#""data:image/png;base64,+/+/Zg==""#);
        assert_eq!(serde_json::to_string(&png).unwrap(), url);
        assert_eq!(serde_json::from_str::<Png>(url).unwrap(), png);
        for broken in [r#""""#, r#""data:image/png;base64,*""#, r#""data:text/plain;base64,Zg==""#] {
            assert!(serde_json::from_str::<Png>(broken).is_err(), "{broken}");
        }
    }
}
