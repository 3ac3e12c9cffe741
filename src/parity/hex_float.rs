//! Numbers as hexadecimal floats: exact, and read by other languages.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

/// An f32 that is written as C's `%a` does: `-0x1.8p+1` is −3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HexFloat(pub(super) f32);

/// Text that is no f32 in hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not exactly an f32 (expected a hexadecimal float such as 0x1.8p+1, inf or nan)")]
pub(super) struct NotHexFloat(String);

impl Display for HexFloat {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let x = self.0;
        let sign = if x.is_sign_negative() { "-" } else { "" };
        if x.is_nan() {
            return f.write_str("nan");
        }
        if x.is_infinite() {
            return write!(f, "{sign}inf");
        }
        // Exact, and normal for every f32 but 0.
        let bits = f64::from(x).to_bits();
        if x == 0.0 {
            return write!(f, "{sign}0x0p+0");
        }
        let exponent = (bits >> 52 & 0x7ff) as i32 - 1023;
        let digits = format!("{:013x}", bits & ((1 << 52) - 1));
        let digits = digits.trim_end_matches('0');
        let point = if digits.is_empty() { "" } else { "." };
        write!(f, "{sign}0x1{point}{digits}p{exponent:+}")
    }
}

impl FromStr for HexFloat {
    type Err = NotHexFloat;

    fn from_str(text: &str) -> Result<Self, NotHexFloat> {
        parse(text).map(Self).ok_or_else(|| NotHexFloat(text.to_owned()))
    }
}

fn parse(text: &str) -> Option<f32> {
    let (sign, magnitude) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text),
    };
    match magnitude {
        "inf" => return Some(f32::INFINITY.copysign(sign)),
        "nan" => return Some(f32::NAN),
        _ => {}
    }
    let (mantissa, exponent) = magnitude.strip_prefix("0x")?.split_once('p')?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = format!("{whole}{fraction}");
    // At most 12 digits, so that an f64 holds them; from_str_radix would take a sign.
    if digits.is_empty() || digits.len() > 12 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let digits = u64::from_str_radix(&digits, 16).ok()? as f64;
    let exponent: i32 = exponent.parse().ok().filter(|e| (-900..=900).contains(e))?;
    let exact = f64::from(sign) * digits * 2f64.powi(exponent - 4 * fraction.len() as i32);
    let rounded = exact as f32;
    (f64::from(rounded) == exact).then_some(rounded)
}

impl Serialize for HexFloat {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// From text that is exactly an f32, or from the nearest f32 to a number.
impl<'de> Deserialize<'de> for HexFloat {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a number, or a hexadecimal float as text")]
        enum Number {
            Exact(String),
            Rounded(f32),
        }
        match Number::deserialize(deserializer)? {
            Number::Exact(text) => text.parse().map_err(Error::custom),
            Number::Rounded(value) => Ok(Self(value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_comes_back() {
        let some = (0..=u32::MAX).step_by(65_521).map(f32::from_bits);
        let special =
            [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE, f32::MAX, 0.1];
        let denormal = [1, 2, 3, 0x0040_0000, 0x007f_ffff].map(f32::from_bits);
        for x in some.chain(special).chain(denormal).filter(|x| !x.is_nan()) {
            let text = HexFloat(x).to_string();
            let back: HexFloat = text.parse().expect("our own");
            assert_eq!(back.0.to_bits(), x.to_bits(), "{x} {text}");
        }
        assert!("nan".parse::<HexFloat>().expect("known").0.is_nan());
    }

    /// As printed by C's `printf("%a", x)`.
    #[test]
    fn the_form_is_that_of_c() {
        for (x, text) in [
            (1.0, "0x1p+0"),
            (-3.0, "-0x1.8p+1"),
            (0.1, "0x1.99999ap-4"),
            (f32::from_bits(1), "0x1p-149"),
            (-0.0, "-0x0p+0"),
            (f32::INFINITY, "inf"),
        ] {
            assert_eq!(HexFloat(x).to_string(), text);
        }
        assert_eq!("0x18p-3".parse(), Ok(HexFloat(3.0)));
    }

    #[test]
    fn what_is_no_f32_is_refused() {
        for text in [
            "",
            "1.0",
            "0x",
            "0xp1",
            "0x1",
            "0x1p",
            "0x1.8",
            "0x1g",
            "0x+1p0",
            "0x1p1.5",
            "0x1p9999",
            "0x1p128",
            "0x1.0000001p0",
            "0x1p-150",
            "0x0.0000000000001p0",
            "infinity",
            "--0x1p0",
        ] {
            let error = text.parse::<HexFloat>().expect_err(text).to_string();
            let expected = format!(
                "`{text}` is not exactly an f32 (expected a hexadecimal float such as 0x1.8p+1, inf or nan)"
            );
            assert_eq!(error, expected);
        }
    }
}
