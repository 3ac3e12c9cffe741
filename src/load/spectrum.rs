//! `<spectrum>`: light and reflectance by wavelength, as colours.
//!
//! A spectrum becomes three numbers as in the `rgb` variants of Mitsuba 3.9. What a material says of
//! light is seen under daylight (D65), so that 1 at all wavelengths is white. What an emitter sends out is
//! seen as it is, so that 1 at all wavelengths is the reddish white of equal energy.

use glam::{DMat3, DVec3};

use super::document::{Element, Place};
use super::problem::Issue;
use super::values::{Value, numbers, parse_number};
use crate::property::named::{did_you_mean, quoted};

/// Something by wavelength.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    /// The same at all wavelengths.
    Uniform(f64),
    /// Pairs of a wavelength in nm and a value, in ascending order; linear between them, 0 outside.
    Table(Vec<(f64, f64)>),
    /// Radiance of a black body of this temperature in K, in W/(m² sr nm).
    BlackBody(f64),
}

/// What a spectrum describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// What a material does to light.
    Material,
    /// Light.
    Emission,
}

/// First and last wavelength of the tables below, in nm.
const FIRST_NM: f64 = 360.0;
const LAST_NM: f64 = 830.0;

/// Distance of the tables' entries in nm.
const TABLE_STEP_NM: f64 = 5.0;

/// Mitsuba's rule of quadrature, which is part of the definition of its colours: the mean of this many values
/// at equal distances, both ends included, times the range.
const STEPS: usize = 1000;

/// The integral of [`OBSERVER`]'s y as Mitsuba has it, and the factor on [`D65`] that makes white of it.
const INTEGRAL_OF_Y: f64 = 106.750_259_399_414_06;
const MEAN_OF_D65: f64 = 98.997_417_518_762_55;

impl Spectrum {
    /// Linear sRGB; channels may lie outside of what the property takes, and below 0.
    pub(super) fn linear_srgb(&self, role: Role) -> DVec3 {
        match (self, role) {
            (Self::Uniform(value), Role::Material) => DVec3::splat(*value),
            (Self::Uniform(value), Role::Emission) => *value * (xyz_to_srgb() * DVec3::ONE),
            _ => self.integrate(role),
        }
    }

    fn integrate(&self, role: Role) -> DVec3 {
        let range = LAST_NM - FIRST_NM;
        let sum: DVec3 = (0..STEPS)
            .map(|step| {
                let nm = FIRST_NM + range * step as f64 / (STEPS - 1) as f64;
                let light = match role {
                    Role::Material => tabulated(nm, |i| DVec3::splat(D65[i])) / MEAN_OF_D65,
                    Role::Emission => DVec3::ONE,
                };
                let observer = tabulated(nm, |i| DVec3::from_array(OBSERVER[i]));
                self.at(nm) * light * observer
            })
            .sum();
        xyz_to_srgb() * (sum * (range / STEPS as f64 / INTEGRAL_OF_Y))
    }

    /// The value at a wavelength.
    fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::BlackBody(kelvin) => planck(nm, *kelvin),
            Self::Table(entries) => {
                let next = entries.partition_point(|&(at, _)| at <= nm);
                match (next.checked_sub(1).map(|i| entries[i]), entries.get(next)) {
                    (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * ((nm - x0) / (x1 - x0)),
                    // The last entry itself is still inside.
                    (Some((x0, y0)), None) if x0 == nm => y0,
                    _ => 0.0,
                }
            }
        }
    }

    /// The numbers that the file gives, but for temperatures.
    pub(super) fn values(&self) -> Vec<f64> {
        match self {
            Self::Uniform(value) => vec![*value],
            Self::Table(entries) => entries.iter().map(|&(_, value)| value).collect(),
            Self::BlackBody(_) => Vec::new(),
        }
    }
}

/// Planck's law, in W/(m² sr nm).
fn planck(nm: f64, kelvin: f64) -> f64 {
    const PLANCK: f64 = 6.626_070_15e-34;
    const LIGHT: f64 = 299_792_458.0;
    const BOLTZMANN: f64 = 1.380_649e-23;
    let m = nm * 1e-9;
    let exponent = PLANCK * LIGHT / (m * BOLTZMANN * kelvin);
    1e-9 * 2.0 * PLANCK * LIGHT * LIGHT / (m.powi(5) * exponent.exp_m1())
}

/// Linear interpolation in a table.
fn tabulated(nm: f64, entry: impl Fn(usize) -> DVec3) -> DVec3 {
    let position = (nm - FIRST_NM) / TABLE_STEP_NM;
    let index = (position as usize).min(OBSERVER.len() - 2);
    entry(index).lerp(entry(index + 1), position - index as f64)
}

/// From CIE XYZ to linear sRGB, with Mitsuba's digits.
fn xyz_to_srgb() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(3.240_479, -0.969_256, 0.055_648),
        DVec3::new(-1.537_150, 1.875_991, -0.204_043),
        DVec3::new(-0.498_535, 0.041_556, 1.057_311),
    )
}

/// The value of a `<spectrum>` with a `value`: one number, or pairs as in `400:0.1, 700:0.8`.
pub(super) fn parse(text: &str, place: Place) -> Result<Value, Issue> {
    if !text.contains(':') {
        return match *numbers(text, place)?.as_slice() {
            [v] => Ok(Value::Spectrum(Spectrum::Uniform(v))),
            ref list => {
                let message = format!("a <spectrum> has 1 number, found {}", list.len());
                let help = "write a colour as <rgb name=\"…\" value=\"r, g, b\"/>, and a spectrum by \
                            wavelength in nm as value=\"400:0.1, 700:0.8\"";
                Err(Issue::new(place, message).with_help(help))
            }
        };
    }
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
    let entries = words
        .map(|word| match word.split_once(':') {
            Some((nm, value)) => Ok((parse_number(nm, place)?, parse_number(value, place)?)),
            None => {
                let message = format!("`{word}` is no pair of a wavelength and a value");
                Err(Issue::new(place, message).with_help("write it like 400:0.1, 700:0.8"))
            }
        })
        .collect::<Result<Vec<_>, _>>()?;
    if entries.len() < 2 {
        let message = "a spectrum by wavelength has 1 pair (expected 2 or more)";
        return Err(Issue::new(place, message));
    }
    if let Some(pair) = entries.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        let message = format!("the wavelength {} follows {}", pair[1].0, pair[0].0);
        return Err(Issue::new(place, message + " (expected ascending order)"));
    }
    Ok(Value::Spectrum(Spectrum::Table(entries)))
}

/// Types of `<spectrum>` elements with the parameter that each takes.
const TYPES: [(&str, &str); 3] =
    [("uniform", "value"), ("d65", "scale"), ("blackbody", "temperature")];

/// The value of a `<spectrum>` with a `type`.
pub(super) fn read_typed(element: &Element) -> Result<Value, Issue> {
    let kind = element.value("type");
    let Some((_, parameter)) = TYPES.iter().find(|(name, _)| *name == kind) else {
        let names = TYPES.map(|(name, _)| name);
        let message = format!("spectrum `{kind}` is not supported{}", did_you_mean(kind, names));
        return Err(Issue::new(element.place_of("type"), message)
            .with_help(format!("use one of {}, or an <rgb>", quoted(names))));
    };
    let mut number = None;
    for child in &element.children {
        let name = child.value("name");
        if !["float", "integer"].contains(&child.tag.as_str()) || name != *parameter {
            let message = format!("spectrum `{kind}` takes <float name=\"{parameter}\"/> only");
            return Err(Issue::new(child.place, message));
        }
        number = Some((parse_number(child.value("value"), child.place_of("value"))?, child));
    }
    let at_all = number.map(|(number, _)| number);
    match kind {
        // Both are grey in Mitsuba's rgb variants, whatever they describe.
        "uniform" | "d65" => Ok(Value::Rgb(DVec3::splat(at_all.unwrap_or(1.0)))),
        _ => match number {
            Some((kelvin, _)) if kelvin > 0.0 => Ok(Value::Spectrum(Spectrum::BlackBody(kelvin))),
            Some((kelvin, child)) => {
                let message = format!("`temperature` is {kelvin} (expected: float above 0, in K)");
                Err(Issue::new(child.place_of("value"), message))
            }
            None => {
                let message = "spectrum `blackbody` needs the property `temperature` (in K)";
                Err(Issue::new(element.place, message))
            }
        },
    }
}

/// The colour matching functions x, y and z of the CIE's observer of 1931 (2 degrees), every 5 nm from
/// [`FIRST_NM`] on.
static OBSERVER: [[f64; 3]; 95] = [
    [0.0001299, 3.917e-06, 0.0006061],
    [0.0002321, 6.965e-06, 0.001086],
    [0.0004149, 1.239e-05, 0.001946],
    [0.0007416, 2.202e-05, 0.003486],
    [0.001368, 3.9e-05, 0.00645],
    [0.002236, 6.4e-05, 0.01055],
    [0.004243, 0.00012, 0.02005],
    [0.00765, 0.000217, 0.03621],
    [0.01431, 0.000396, 0.06785],
    [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074],
    [0.07763, 0.00218, 0.3713],
    [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.03905],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706],
    [0.34806, 0.0298, 1.7826],
    [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764],
    [0.1421, 0.1126, 1.0419],
    [0.09564, 0.13902, 0.81295],
    [0.05795, 0.1693, 0.6162],
    [0.03201, 0.20802, 0.46518],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.06327, 0.71, 0.07825],
    [0.1096, 0.7932, 0.05725],
    [0.1655, 0.862, 0.04216],
    [0.22575, 0.91485, 0.02984],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.43345, 0.99495, 0.00875],
    [0.51205, 1.0, 0.00575],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.00275],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.00165],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.00034],
    [0.9384, 0.4412, 0.00024],
    [0.85445, 0.381, 0.00019],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 5e-05],
    [0.5419, 0.217, 3e-05],
    [0.4479, 0.175, 2e-05],
    [0.3608, 0.1382, 1e-05],
    [0.2835, 0.107, 0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0],
    [0.0329, 0.01192, 0.0],
    [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0],
    [0.0113592, 0.004102, 0.0],
    [0.00811092, 0.002929, 0.0],
    [0.00579035, 0.002091, 0.0],
    [0.00410946, 0.001484, 0.0],
    [0.00289933, 0.001047, 0.0],
    [0.00204919, 0.00074, 0.0],
    [0.00143997, 0.00052, 0.0],
    [0.000999949, 0.0003611, 0.0],
    [0.000690079, 0.0002492, 0.0],
    [0.000476021, 0.0001719, 0.0],
    [0.000332301, 0.00012, 0.0],
    [0.000234826, 8.48e-05, 0.0],
    [0.00016615, 6e-05, 0.0],
    [0.000117413, 4.24e-05, 0.0],
    [8.30753e-05, 3e-05, 0.0],
    [5.87065e-05, 2.12e-05, 0.0],
    [4.15099e-05, 1.499e-05, 0.0],
    [2.93533e-05, 1.06e-05, 0.0],
    [2.06738e-05, 7.4657e-06, 0.0],
    [1.45598e-05, 5.2578e-06, 0.0],
    [1.0254e-05, 3.7029e-06, 0.0],
    [7.22146e-06, 2.6078e-06, 0.0],
    [5.08587e-06, 1.8366e-06, 0.0],
    [3.58165e-06, 1.2934e-06, 0.0],
    [2.52252e-06, 9.1093e-07, 0.0],
    [1.77651e-06, 6.4153e-07, 0.0],
    [1.25114e-06, 4.5181e-07, 0.0],
];

/// The CIE's standard illuminant D65 at the same wavelengths.
static D65: [f64; 95] = [
    46.6383, 49.3637, 52.0891, 51.0323, 49.9755, 52.3118, 54.6482, 68.7015, 82.7549, 87.1204,
    91.486, 92.4589, 93.4318, 90.057, 86.6823, 95.7736, 104.865, 110.936, 117.008, 117.41, 117.812,
    116.336, 114.861, 115.392, 115.923, 112.367, 108.811, 109.082, 109.354, 108.578, 107.802,
    106.296, 104.79, 106.239, 107.689, 106.047, 104.405, 104.225, 104.046, 102.023, 100.0, 98.1671,
    96.3342, 96.0611, 95.788, 92.2368, 88.6856, 89.3459, 90.0062, 89.8026, 89.5991, 88.6489,
    87.6987, 85.4936, 83.2886, 83.4939, 83.6992, 81.863, 80.0268, 80.1207, 80.2146, 81.2462,
    82.2778, 80.281, 78.2842, 74.0027, 69.7213, 70.6652, 71.6091, 72.979, 74.349, 67.9765, 61.604,
    65.7448, 69.8856, 72.4863, 75.087, 69.3398, 63.5927, 55.0054, 46.4182, 56.6118, 66.8054,
    65.0941, 63.3828, 63.8434, 64.304, 61.8779, 59.4519, 55.7054, 51.959, 54.6998, 57.4406,
    58.8765, 60.3125,
];

#[cfg(test)]
mod tests {
    use super::*;

    fn colour(entries: &[(f64, f64)], role: Role) -> DVec3 {
        Spectrum::Table(entries.to_vec()).linear_srgb(role)
    }

    /// Figures as Mitsuba 3.9.1 (`scalar_rgb`) prints them for `reflectance`, `eta` and `radiance`. Its sums
    /// are in f32: 1,000 roundings of 2⁻²⁴ each.
    #[test]
    fn colours_are_mitsubas() {
        use Role::{Emission, Material};
        for (entries, role, expected) in [
            (&[(360.0, 1.0), (830.0, 1.0)][..], Material, [0.998_985, 0.998_874, 0.998_802]),
            (&[(400.0, 1.0), (700.0, 1.0)], Material, [0.995_342, 0.999_756, 0.994_909]),
            (&[(550.0, 1.0), (551.0, 1.0)], Material, [-0.001_053_83, 0.013_335_7, -0.001_568]),
            (
                &[(400.0, 0.1), (500.0, 0.8), (600.0, 0.3)],
                Material,
                [-0.093_882, 0.634_591, 0.473_492],
            ),
            (&[(400.0, 1.0), (700.0, 3.0)], Material, [2.603_638, 1.952_667, 1.266_993]),
            (&[(360.0, 1.0), (830.0, 1.0)], Emission, [1.204_884, 0.948_228, 0.909_267]),
            (&[(300.0, 1.0), (900.0, 1.0)], Emission, [1.204_884, 0.948_228, 0.909_267]),
            (
                &[(400.0, 0.0), (500.0, 8.0), (600.0, 15.6), (700.0, 18.4)],
                Emission,
                [20.710_836, 10.854_634, 2.771_152],
            ),
        ] {
            let found = colour(entries, role);
            let expected = DVec3::from(expected);
            let tolerance = 1000.0 * 2_f64.powi(-24) * expected.length();
            assert!(found.abs_diff_eq(expected, tolerance), "{entries:?} {role:?}: {found}");
        }
        let uniform = Spectrum::Uniform(2.0).linear_srgb(Emission);
        assert!(
            uniform.abs_diff_eq(DVec3::new(2.409_588, 1.896_582, 1.817_832), 1e-6),
            "{uniform}"
        );
        assert_eq!(Spectrum::Uniform(0.5).linear_srgb(Material), DVec3::splat(0.5));
    }

    /// What Mitsuba 3.9.1 (`scalar_spectral`) renders of a black body all around, in 2²⁰ samples; three
    /// standard errors of its estimate.
    #[test]
    fn black_bodies_shine_as_in_mitsuba() {
        for (kelvin, expected, error) in [
            (3000.0, [733.713, 349.939, 112.824], [0.42, 0.08, 0.22]),
            (6500.0, [43_955.6, 41_448.8, 43_633.8], [18.0, 4.0, 79.0]),
        ] {
            let found = Spectrum::BlackBody(kelvin).linear_srgb(Role::Emission).to_array();
            for ((found, expected), error) in found.into_iter().zip(expected).zip(error) {
                // Mitsuba's quadrature weighs 1,000 steps where there are 999.
                let found = found * 1000.0 / 999.0;
                assert!((found - expected).abs() < error, "{kelvin} K: {found} {expected}");
            }
        }
    }
}
