//! What holds if nothing is said.

use std::fmt;

/// What holds if a property is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// It must be given.
    Required,
    /// Nothing; in words, what happens then.
    Absent(&'static str),
    /// A truth value.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Float(f64),
    /// A text.
    Text(&'static str),
    /// A grey of this value.
    Grey(f64),
    /// The origin.
    Origin,
    /// The map that changes nothing.
    Identity,
}

impl fmt::Display for Default {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Required => f.write_str("required"),
            Self::Absent(words) => f.write_str(words),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Float(value) | Self::Grey(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
            Self::Origin => f.write_str("0, 0, 0"),
            Self::Identity => f.write_str("identity"),
        }
    }
}
