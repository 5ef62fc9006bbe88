//! Parameters declared once: a struct whose fields parse, print and document themselves.
//!
//! [`params!`](crate::params!) writes the struct, its defaults, and the table that `prt methods` shows;
//! [`choices!`](crate::choices!) writes an enumeration that can be a field's type.

use crate::error::{Error, Result};
use crate::label::Stage;

/// One parameter as it is documented.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name in a label.
    pub name: &'static str,
    /// Unit, range and effect.
    pub doc: &'static str,
    /// The default, as a label would write it.
    pub default: String,
}

/// A value that a label can carry.
pub trait Value: Sized {
    /// The value written as `text`; `None` where it is none.
    fn parse(text: &str) -> Option<Self>;
    /// As a label writes it; [`Value::parse`] gives the same value back.
    fn show(&self) -> String;
    /// What [`Value::parse`] accepts, in words.
    fn expected() -> String;
}

macro_rules! number {
    ($($type:ty, $words:literal;)*) => {$(
        impl Value for $type {
            fn parse(text: &str) -> Option<Self> { text.parse().ok() }
            fn show(&self) -> String { self.to_string() }
            fn expected() -> String { $words.into() }
        }
    )*};
}
number! { u32, "a whole number from 0 to 4294967295"; u64, "a whole number from 0"; usize, "a whole number from 0"; bool, "true or false"; }

impl Value for f64 {
    fn parse(text: &str) -> Option<Self> {
        text.parse().ok().filter(|v: &f64| v.is_finite())
    }
    fn show(&self) -> String {
        // Both forms read back exactly; the shorter one is what a person would write.
        let (plain, exponent) = (format!("{self}"), format!("{self:e}"));
        if exponent.len() < plain.len() { exponent } else { plain }
    }
    fn expected() -> String {
        "a finite number".into()
    }
}

/// A value that may be left out; its absence is written `none`.
impl<T: Value> Value for Option<T> {
    fn parse(text: &str) -> Option<Self> {
        if text == "none" { Some(None) } else { T::parse(text).map(Some) }
    }
    fn show(&self) -> String {
        self.as_ref().map_or_else(|| "none".into(), T::show)
    }
    fn expected() -> String {
        format!("none or {}", T::expected())
    }
}

/// What [`params!`](crate::params!) implements: a method's parameters by name.
pub trait Params: Clone + Default + PartialEq + Send + Sync + std::fmt::Debug + 'static {
    /// The method's name in a label.
    const NAME: &'static str;
    /// The method in a sentence.
    const ABOUT: &'static str;
    /// Every parameter, in the order in which labels print them.
    fn fields() -> Vec<Field>;
    /// Current values in the order of [`Params::fields`], as a label writes them.
    fn values(&self) -> Vec<String>;
    /// Sets one parameter from a label's text.
    fn set(&mut self, name: &str, value: &str) -> Result<()>;

    /// The parameters that a stage writes; everything else stays at its default.
    fn from_stage(stage: &Stage) -> Result<Self> {
        let mut params = Self::default();
        stage.params.iter().try_for_each(|(name, value)| params.set(name, value))?;
        Ok(params)
    }
    /// The shortest stage that means these parameters: only what differs from the default.
    fn to_stage(&self) -> Stage {
        let differing = Self::fields().into_iter().zip(self.values()).filter(|(field, value)| field.default != *value);
        Stage { name: Self::NAME.into(), params: differing.map(|(f, v)| (f.name.to_string(), v)).collect() }
    }
    /// [`Error::Parameter`] for a parameter of this method, for range checks in a constructor.
    fn refuse(name: &str, value: impl ToString, expected: impl Into<String>) -> Error {
        Error::Parameter {
            method: Self::NAME.into(),
            name: name.into(),
            value: value.to_string(),
            expected: expected.into(),
        }
    }
}

/// Declares a method's parameters: a struct that implements [`Params`].
///
/// ```
/// prt_transfer::params! {
///     /// Keeps the largest coefficients of each row.
///     pub struct KeepParams: "keep" {
///         /// Coefficients kept in each row; at least 1.
///         terms: usize = 64,
///     }
/// }
/// use prt_transfer::Params;
/// assert_eq!(KeepParams { terms: 8 }.to_stage().to_string(), "keep:terms=8");
/// ```
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $about:literal])+
        pub struct $type:ident: $name:literal {
            $( $(#[doc = $doc:literal])+ $field:ident: $kind:ty = $default:expr, )*
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $type {
            $( $(#[doc = $doc])+ pub $field: $kind, )*
        }
        impl Default for $type {
            fn default() -> Self {
                Self { $( $field: $default, )* }
            }
        }
        impl $crate::params::Params for $type {
            const NAME: &'static str = $name;
            const ABOUT: &'static str = concat!($($about),+);
            fn fields() -> Vec<$crate::params::Field> {
                vec![ $( $crate::params::Field {
                    name: stringify!($field),
                    doc: concat!($($doc),+),
                    default: <$kind as $crate::params::Value>::show(&$default),
                }, )* ]
            }
            fn values(&self) -> Vec<String> {
                vec![ $( $crate::params::Value::show(&self.$field), )* ]
            }
            fn set(&mut self, name: &str, value: &str) -> $crate::error::Result<()> {
                match name {
                    $( stringify!($field) => {
                        self.$field = <$kind as $crate::params::Value>::parse(value)
                            .ok_or_else(|| Self::refuse(name, value, <$kind as $crate::params::Value>::expected()))?;
                        Ok(())
                    } )*
                    _ => {
                        let _ = value;
                        let known: &[&str] = &[$( stringify!($field) ),*];
                        Err($crate::Error::Unknown {
                            what: concat!("parameter of ", $name),
                            name: name.into(),
                            known: if known.is_empty() { "none".into() } else { known.join(", ") },
                        })
                    }
                }
            }
        }
    };
}

/// Declares an enumeration that a parameter can take, with the words that labels use.
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $about:literal])+
        pub enum $type:ident {
            $( $(#[doc = $doc:literal])+ $variant:ident = $word:literal, )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $type {
            $( $(#[doc = $doc])+ $variant, )+
        }
        impl $crate::params::Value for $type {
            fn parse(text: &str) -> Option<Self> {
                match text {
                    $( $word => Some($type::$variant), )+
                    _ => None,
                }
            }
            fn show(&self) -> String {
                match self {
                    $( $type::$variant => $word.into(), )+
                }
            }
            fn expected() -> String {
                format!("one of {}", [$( $word ),+].join(", "))
            }
        }
    };
}
