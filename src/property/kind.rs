//! The values that properties take.

use std::fmt;

use glam::DVec3;

use super::Named;

/// The values that a property takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `<boolean>`
    Boolean,
    /// `<integer>` from the first number to the second.
    Integer(i64, i64),
    /// `<float>` or `<integer>`.
    Float(Bounds),
    /// `<string>`
    Text,
    /// `<string>` that is one of these.
    Choice(&'static [&'static str]),
    /// `<string>` that names a file.
    File,
    /// `<point>` or `<vector>`.
    Point,
    /// `<transform>`
    Transform,
    /// `<transform>` or `<animation>`
    Motion,
    /// `<rgb>`, `<srgb>`, `<spectrum>`, or one number for all channels.
    Rgb(Bounds),
    /// The same, or `<texture>`.
    RgbTexture(Bounds),
    /// `<float>`, a colour whose mean counts, or `<texture>`.
    FloatTexture(Bounds),
    /// A number, or the name of a substance.
    RefractiveIndex,
    /// `<string>` that names a metal, or is `none`.
    Metal,
}

impl Kind {
    /// Where the channels of a colour must lie; `None` if it takes none.
    pub(crate) fn color_bounds(self) -> Option<Bounds> {
        match self {
            Self::Rgb(bounds) | Self::RgbTexture(bounds) | Self::FloatTexture(bounds) => {
                Some(bounds)
            }
            _ => None,
        }
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Bounds {
    /// All that an f32 can hold.
    Any,
    /// Above 0.
    Positive,
    /// 0 or above.
    NotNegative,
    /// 1 or above.
    AtLeastOne,
    /// From 0 to 1.
    Unit,
    /// Above 0, up to 1.
    Probability,
}

impl Bounds {
    pub(crate) fn contain(self, value: f64) -> bool {
        value.abs() <= f64::from(f32::MAX)
            && match self {
                Self::Any => true,
                // What rounds to 0 as f32 would not be above 0 where it is used.
                Self::Positive => value as f32 > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::AtLeastOne => value >= 1.0,
                Self::Unit => (0.0..=1.0).contains(&value),
                Self::Probability => value as f32 > 0.0 && value <= 1.0,
            }
    }
}

impl Bounds {
    /// The smallest and the largest number within; 0 also where only what is above it is.
    pub(crate) fn limits(self) -> [f32; 2] {
        match self {
            Self::Any => [f32::MIN, f32::MAX],
            Self::Positive | Self::NotNegative => [0.0, f32::MAX],
            Self::AtLeastOne => [1.0, f32::MAX],
            Self::Unit | Self::Probability => [0.0, 1.0],
        }
    }

    /// The closest colour within.
    pub(crate) fn clamp(self, rgb: DVec3) -> DVec3 {
        match self {
            Self::Any => rgb,
            Self::Positive | Self::NotNegative => rgb.max(DVec3::ZERO),
            Self::AtLeastOne => rgb.max(DVec3::ONE),
            Self::Unit | Self::Probability => rgb.clamp(DVec3::ZERO, DVec3::ONE),
        }
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Any => "any finite",
            Self::Positive => "above 0",
            Self::NotNegative => "of 0 or above",
            Self::AtLeastOne => "of 1 or above",
            Self::Unit => "from 0 to 1",
            Self::Probability => "above 0, up to 1",
        })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean => f.write_str("boolean"),
            Self::Integer(min, max) if *max >= i64::from(i32::MAX) => {
                write!(f, "integer of {min} or above")
            }
            Self::Integer(min, max) => write!(f, "integer from {min} to {max}"),
            Self::Float(Bounds::Any) => f.write_str("float"),
            Self::Float(bounds) => write!(f, "float {bounds}"),
            Self::Text => f.write_str("string"),
            Self::Choice(names) => write!(f, "one of {}", names.join(", ")),
            Self::File => f.write_str("file name"),
            Self::Point => f.write_str("point"),
            Self::Transform => f.write_str("transform"),
            Self::Motion => f.write_str("transform or animation"),
            Self::Rgb(Bounds::Any) => f.write_str("colour"),
            Self::RgbTexture(bounds) => write!(f, "colour {bounds}, or texture"),
            Self::FloatTexture(bounds) => write!(f, "float {bounds}, or texture"),
            Self::Rgb(bounds) => write!(f, "colour {bounds}"),
            Self::RefractiveIndex => f.write_str("float above 0, or name of a substance"),
            Self::Metal => f.write_str("name of a metal, or none"),
        }
    }
}

/// A value that stands by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of a [`Kind::Boolean`].
    Boolean(bool),
    /// Of a [`Kind::Integer`].
    Integer(i64),
    /// Of a [`Kind::Float`].
    Float(f64),
    /// Of a [`Kind::Choice`].
    Choice(&'static str),
}

impl Kind {
    /// The value that `text` says, if it is one of those that the property takes.
    #[must_use]
    pub fn parse(self, text: &str) -> Option<Value> {
        match self {
            Self::Boolean => text.parse().ok().map(Value::Boolean),
            Self::Integer(min, max) => {
                text.parse().ok().filter(|v| (min..=max).contains(v)).map(Value::Integer)
            }
            Self::Float(bounds) => {
                text.parse().ok().filter(|&v| bounds.contain(v)).map(Value::Float)
            }
            Self::Choice(names) => names.iter().find(|n| **n == text).map(|n| Value::Choice(n)),
            _ => None,
        }
    }

    /// What [`Kind::parse`] takes, in words.
    #[must_use]
    pub fn words(self) -> String {
        match self {
            Self::Boolean => "one of: true, false".to_owned(),
            Self::Integer(min, max) if max >= i64::from(i32::MAX) => {
                format!("a whole number from {min}")
            }
            Self::Integer(min, max) => format!("a whole number from {min} to {max}"),
            Self::Float(bounds) => format!("a number {bounds}"),
            Self::Choice(names) => format!("one of: {}", names.join(", ")),
            _ => self.to_string(),
        }
    }
}

impl Value {
    /// The number, of a property that takes whole numbers which a u32 can hold.
    ///
    /// # Panics
    /// For other values.
    #[must_use]
    pub fn count(self) -> u32 {
        u32::try_from(self.integer()).expect(OF_ITS_KIND)
    }

    /// The number, of a property that takes whole numbers.
    ///
    /// # Panics
    /// For other values.
    #[must_use]
    pub fn integer(self) -> i64 {
        match self {
            Self::Integer(v) => v,
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }

    /// The number, of a property that takes numbers.
    ///
    /// # Panics
    /// For other values.
    #[must_use]
    pub fn number(self) -> f32 {
        match self {
            Self::Float(v) => v as f32,
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }

    /// What the name stands for, of a property that takes the names of `T`.
    ///
    /// # Panics
    /// For other values.
    #[must_use]
    pub fn named<T: Named>(self) -> T {
        match self {
            Self::Choice(name) => T::named(name).expect(OF_ITS_KIND),
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }
}

const OF_ITS_KIND: &str = "values are parsed as their property's kind";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_a_value_if_the_property_takes_it() {
        let whole = Kind::Integer(1, 32);
        assert_eq!(whole.parse("1"), Some(Value::Integer(1)));
        assert_eq!(whole.parse("32"), Some(Value::Integer(32)));
        assert_eq!(Kind::Integer(-1, 9).parse("-1"), Some(Value::Integer(-1)));
        for bad in ["", "0", "33", "1.5", "x", "99999999999999999999"] {
            assert_eq!(whole.parse(bad), None, "{bad}");
        }
        let probability = Kind::Float(Bounds::Probability);
        assert_eq!(probability.parse("0.5"), Some(Value::Float(0.5)));
        assert_eq!(probability.parse("1"), Some(Value::Float(1.0)));
        // The last rounds to 0 as f32.
        for bad in ["", "0", "-1", "1.01", "NaN", "inf", "1e-60"] {
            assert_eq!(probability.parse(bad), None, "{bad}");
        }
        let choice = Kind::Choice(&["a", "b"]);
        assert_eq!(choice.parse("b"), Some(Value::Choice("b")));
        assert_eq!(choice.parse("B"), None);
        assert_eq!(Kind::Boolean.parse("true"), Some(Value::Boolean(true)));
        assert_eq!(Kind::Boolean.parse("yes"), None);
    }

    #[test]
    fn what_a_text_may_be_is_said_in_words() {
        for (kind, words) in [
            (Kind::Boolean, "one of: true, false"),
            (Kind::Integer(1, 32), "a whole number from 1 to 32"),
            (Kind::Integer(0, i64::from(i32::MAX)), "a whole number from 0"),
            (Kind::Float(Bounds::Probability), "a number above 0, up to 1"),
            (Kind::Choice(&["a", "b"]), "one of: a, b"),
        ] {
            assert_eq!(kind.words(), words);
        }
    }
}
