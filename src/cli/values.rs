//! Values of options, from text. Errors are fragments: clap puts the option's name before them.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use telamon::film::Crop;
use telamon::film::output::{FileFormat, OutputError};
use telamon::intersect::accel::MalformedMode;
use telamon::intersect::{Accel, Backend, UnknownBackend};
use telamon::load::NoriX;
use telamon::measure::plan::Variation;
use telamon::parity::Budget;
use telamon::sampler::SamplerKind;

/// A picture file that is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Output {
    pub(super) path: PathBuf,
    pub(super) format: FileFormat,
}

/// Columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: u32,
    pub(super) height: u32,
}

/// A pixel of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pixel {
    pub(super) x: u32,
    pub(super) y: u32,
}

pub(super) fn output(text: &str) -> Result<Output, OutputError> {
    let path = PathBuf::from(text);
    FileFormat::of(&path).map(|format| Output { path, format })
}

pub(super) fn size(text: &str) -> Result<Size, String> {
    match numbers(text, 'x').as_deref() {
        Some(&[width, height]) if width > 0 && height > 0 => Ok(Size { width, height }),
        _ => Err("expected columns and rows, such as 640x480".to_owned()),
    }
}

pub(super) fn crop(text: &str) -> Result<Crop, String> {
    match numbers(text, ',').as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop { x, y, width, height }),
        _ => Err("expected first column and row, columns and rows, such as 0,0,64,64".to_owned()),
    }
}

pub(super) fn pixel(text: &str) -> Result<Pixel, String> {
    match numbers(text, ',').as_deref() {
        Some(&[x, y]) => Ok(Pixel { x, y }),
        _ => Err("expected column and row, such as 3,4".to_owned()),
    }
}

pub(super) fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("expected a name, an equals sign and a value, such as spp=16".to_owned()),
    }
}

pub(super) fn choice(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((knob, value)) if !knob.is_empty() && !value.is_empty() => {
            Ok((knob.to_owned(), value.to_owned()))
        }
        _ => Err("expected a knob, an equals sign and a value, such as max_depth=3".to_owned()),
    }
}

pub(super) fn variation(text: &str) -> Result<Variation, String> {
    let split = text.split_once('=').map(|(knob, values)| {
        let values: Vec<String> = values.split(',').map(str::to_owned).collect();
        Variation { knob: knob.to_owned(), values }
    });
    match split {
        Some(v) if !v.knob.is_empty() && v.values.iter().all(|value| !value.is_empty()) => Ok(v),
        _ => Err("expected a knob, an equals sign and values with commas between, such as \
                  spp=4,16,64"
            .to_owned()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(value),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// The kinds of random numbers, for the help and for completions as well.
pub(super) fn samplers() -> impl TypedValueParser<Value = SamplerKind> {
    PossibleValuesParser::new(SamplerKind::ALL.iter().map(|kind| kind.name()))
        .try_map(|name| name.parse::<SamplerKind>())
}

/// The sides of a picture, for the help and for completions as well.
pub(super) fn nori_x() -> impl TypedValueParser<Value = NoriX> {
    PossibleValuesParser::new(NoriX::ALL.map(NoriX::name)).try_map(|name| name.parse::<NoriX>())
}

pub(super) fn radiance(text: &str) -> Result<f32, String> {
    match positive(text)? as f32 {
        value if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number that 32-bit floats can hold".to_owned()),
    }
}

pub(super) fn stops(text: &str) -> Result<f32, String> {
    // Beyond ±149 every power of 2 leaves the range of f32.
    match text.parse() {
        Ok(stops) if (-149.0..=127.0).contains(&stops) => Ok(stops),
        _ => Err("expected a number from -149 to 127".to_owned()),
    }
}

/// A number of bytes, or of binary multiples: `512M`, `16G`.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let units = [('k', 10), ('K', 10), ('M', 20), ('G', 30), ('T', 40)];
    let unit = units.iter().find_map(|&(unit, shift)| Some((text.strip_suffix(unit)?, shift)));
    let (number, shift) = unit.unwrap_or((text, 0));
    match number.parse::<u64>().ok().and_then(|n| n.checked_mul(1 << shift)) {
        Some(bytes) if bytes > 0 => Ok(bytes),
        _ => Err("expected a number of bytes such as 512M or 16G".to_owned()),
    }
}

/// As `sleep` has it: seconds, or a number with a unit.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.strip_suffix(['s', 'm', 'h']) {
        Some(number) if text.ends_with('m') => (number, 60.0),
        Some(number) if text.ends_with('h') => (number, 3600.0),
        Some(number) => (number, 1.0),
        None => (text, 1.0),
    };
    let seconds = number.parse::<f64>().ok().map(|n| n * unit);
    match seconds.and_then(|s| Duration::try_from_secs_f64(s).ok()) {
        Some(time) if !time.is_zero() => Ok(time),
        _ => Err("expected a time such as 90s, 5m or 1.5h".to_owned()),
    }
}

/// An engine and its modes: `rust,triangle=plain`.
pub(super) fn accel(text: &str) -> Result<Accel, String> {
    let mut parts = text.split(',');
    let backend: Backend =
        parts.next().unwrap_or("").parse().map_err(|e: UnknownBackend| e.to_string())?;
    let mut accel = Accel::from(backend);
    for part in parts {
        let mode = part.parse().map_err(|e: MalformedMode| e.to_string())?;
        accel.set(&mode).map_err(|e| e.to_string())?;
    }
    Ok(accel)
}

/// A count that may be long: `1e8` or `100000000`.
pub(super) fn count(text: &str) -> Result<u64, String> {
    let value: Option<f64> = text.parse().ok();
    // Up to 2⁵³ an f64 counts exactly.
    match value.filter(|&n| (1.0..=9_007_199_254_740_992.0).contains(&n) && n.fract() == 0.0) {
        Some(n) => Ok(n as u64),
        None => Err("expected a whole number of at least 1, such as 1000000 or 1e6".to_owned()),
    }
}

/// Two shares, of random and of aimed rays: `1e-6,0.01`.
pub(super) fn budget(text: &str) -> Result<Budget, String> {
    let shares: Option<Vec<f64>> = text.split(',').map(|part| part.parse().ok()).collect();
    match shares.as_deref() {
        Some(&[random, aimed]) if [random, aimed].iter().all(|s| (0.0..=1.0).contains(s)) => {
            Ok(Budget { random, aimed })
        }
        _ => Err("expected two numbers from 0 to 1, such as 1e-6,0.01".to_owned()),
    }
}

fn numbers(text: &str, separator: char) -> Option<Vec<u32>> {
    text.split(separator).map(|part| part.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_what_they_say() {
        assert_eq!(size("640x480"), Ok(Size { width: 640, height: 480 }));
        for bad in
            ["", "640", "640x", "x480", "0x1", "1x0", "1x1x1", "-1x1", "1.5x1", "4294967296x1"]
        {
            assert!(size(bad).is_err(), "{bad}");
        }
        assert_eq!(crop("1,2,3,4"), Ok(Crop { x: 1, y: 2, width: 3, height: 4 }));
        for bad in ["", "1,2,3", "1,2,3,0", "1,2,0,4", "-1,2,3,4", "1,2,3,4,5"] {
            assert!(crop(bad).is_err(), "{bad}");
        }
        assert_eq!(pixel("1,2"), Ok(Pixel { x: 1, y: 2 }));
        for bad in ["", "1", "1,", "-1,2", "1,2,3"] {
            assert!(pixel(bad).is_err(), "{bad}");
        }
        assert_eq!(define("a=b=c"), Ok(("a".to_owned(), "b=c".to_owned())));
        assert_eq!(define("a="), Ok(("a".to_owned(), String::new())));
        assert!(define("=b").is_err() && define("a").is_err());
        for (text, milliseconds) in
            [("90", 90_000), ("1.5s", 1500), ("2m", 120_000), (".5h", 1_800_000)]
        {
            assert_eq!(time(text), Ok(Duration::from_millis(milliseconds)), "{text}");
        }
        for bad in ["", "s", "-1s", "0", "NaN", "inf", "1e30h", "1d", "1 s", "1ms"] {
            assert!(time(bad).is_err(), "{bad}");
        }
        assert_eq!(choice("a=b"), Ok(("a".to_owned(), "b".to_owned())));
        assert!(choice("a=").is_err() && choice("=b").is_err());
        let values = |v: Variation| (v.knob, v.values.join(" "));
        assert_eq!(variation("a=b,c").map(values), Ok(("a".to_owned(), "b c".to_owned())));
        for bad in ["", "a", "a=", "=b", "a=b,", "a=,b"] {
            assert!(variation(bad).is_err(), "{bad}");
        }
        assert_eq!(positive("1e-2"), Ok(0.01));
        for bad in ["", "0", "-1", "inf", "NaN"] {
            assert!(positive(bad).is_err(), "{bad}");
        }
        assert_eq!(radiance("2.5"), Ok(2.5));
        assert!(radiance("0").is_err() && radiance("1e39").is_err() && radiance("1e-60").is_err());
        assert_eq!(stops("-1.5"), Ok(-1.5));
        for bad in ["", "x", "NaN", "inf", "128"] {
            assert!(stops(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn bytes_have_units() {
        for (text, value) in [("1", 1), ("512M", 512 << 20), ("3k", 3072), ("2T", 2 << 40)] {
            assert_eq!(bytes(text), Ok(value), "{text}");
        }
        for bad in ["", "0", "M", "1.5G", "-1", "1GB", "99999999999T"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }
}
