//! What can be asked for.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use glam::DVec3;

/// What camera, ground, light and material shall be like.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Which axis points up; `None` for what the format and the shape of the mesh suggest.
    pub up: Option<Axis>,
    /// From where the mesh is seen.
    pub view: View,
    /// Field of view across the longer side of the picture, in degrees, above 0 and below 180.
    pub fov: f64,
    /// What lights the mesh.
    pub light: Light,
    /// Whether the mesh stands on something; `None` for yes, unless it is seen from below or lit by a picture.
    pub ground: Option<bool>,
    /// What the mesh is made of; `None` for the materials of its file, or else clay.
    pub material: Option<Material>,
    /// What is behind the mesh; `None` for what the light brings along.
    pub background: Option<Background>,
    /// Columns and rows.
    pub size: (u32, u32),
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            up: None,
            view: View::THREE_QUARTER,
            fov: 30.0,
            light: Light::Studio,
            ground: None,
            material: None,
            background: None,
            size: (800, 600),
        }
    }
}

/// A word that is not understood: what would be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {0}")]
pub struct Misunderstood(pub String);

/// An axis of the mesh's coordinates, in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// 0 for x, 1 for y, 2 for z.
    pub index: usize,
    /// Whether it is the opposite direction.
    pub negative: bool,
}

impl Axis {
    /// All six.
    pub const ALL: [Self; 6] = [
        Self::new(0, false),
        Self::new(1, false),
        Self::new(2, false),
        Self::new(0, true),
        Self::new(1, true),
        Self::new(2, true),
    ];

    pub(super) const fn new(index: usize, negative: bool) -> Self {
        Self { index, negative }
    }

    /// As a unit vector.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        let axis = DVec3::AXES[self.index];
        if self.negative { -axis } else { axis }
    }

    /// Where the right hand is of somebody who looks at the front with this axis up: +x for +y and for +z, so that the
    /// front is +z and -y.
    #[must_use]
    pub fn right(self) -> DVec3 {
        match (self.index, self.negative) {
            (0, false) => DVec3::NEG_Y,
            (0, true) => DVec3::Y,
            (1, true) => DVec3::NEG_X,
            _ => DVec3::X,
        }
    }

    /// Where somebody stands who looks at the front.
    #[must_use]
    pub fn front(self) -> DVec3 {
        self.right().cross(self.direction())
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negative { '-' } else { '+' };
        write!(f, "{sign}{}", ["x", "y", "z"][self.index])
    }
}

impl FromStr for Axis {
    type Err = Misunderstood;

    fn from_str(text: &str) -> Result<Self, Misunderstood> {
        let lower = text.to_ascii_lowercase();
        let known = Self::ALL.into_iter().find(|axis| {
            let name = axis.to_string();
            name == lower || name.strip_prefix('+') == Some(&lower)
        });
        known.ok_or_else(|| Misunderstood("an axis: +x, +y, +z, -x, -y or -z".to_owned()))
    }
}

/// From where a mesh is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// By a name.
    Named(&'static str),
    /// Degrees to the right of the front, and degrees above.
    Angles(f64, f64),
}

/// Names of views: degrees to the right of the front, and above.
const VIEWS: [(&str, f64, f64); 7] = [
    ("three-quarter", -30.0, 15.0),
    ("front", 0.0, 0.0),
    ("back", 180.0, 0.0),
    ("left", -90.0, 0.0),
    ("right", 90.0, 0.0),
    ("top", 0.0, 90.0),
    ("bottom", 0.0, -90.0),
];

impl View {
    /// From the front and the left, and slightly above.
    pub const THREE_QUARTER: Self = Self::Named("three-quarter");

    /// The names.
    pub fn names() -> impl Iterator<Item = &'static str> {
        VIEWS.iter().map(|(name, ..)| *name)
    }

    fn angles(self) -> (f64, f64) {
        match self {
            Self::Angles(azimuth, elevation) => (azimuth, elevation),
            Self::Named(name) => {
                let known = VIEWS.iter().find(|(known, ..)| *known == name);
                known.map_or((0.0, 0.0), |&(_, azimuth, elevation)| (azimuth, elevation))
            }
        }
    }

    /// Degrees to the right of the front.
    #[must_use]
    pub fn azimuth(self) -> f64 {
        self.angles().0
    }

    /// Degrees above, from -90 to 90.
    #[must_use]
    pub fn elevation(self) -> f64 {
        self.angles().1
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => f.write_str(name),
            Self::Angles(azimuth, elevation) => write!(f, "{azimuth},{elevation}"),
        }
    }
}

impl FromStr for View {
    type Err = Misunderstood;

    fn from_str(text: &str) -> Result<Self, Misunderstood> {
        if let Some(name) = Self::names().find(|name| *name == text) {
            return Ok(Self::Named(name));
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some((azimuth.trim().parse::<f64>().ok()?, elevation.trim().parse::<f64>().ok()?))
        });
        match angles {
            Some((azimuth, elevation))
                if azimuth.abs() <= 360.0 && (-90.0..=90.0).contains(&elevation) =>
            {
                Ok(Self::Angles(azimuth, elevation))
            }
            _ => {
                let names: Vec<_> = Self::names().collect();
                Err(Misunderstood(format!(
                    "{}, or degrees to the right of the front (-360 to 360) and above (-90 to 90), such as 30,15",
                    names.join(", ")
                )))
            }
        }
    }
}

/// What lights a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Light {
    /// A large soft lamp, and a little light from all around.
    Studio,
    /// A sun and a blue sky.
    Sky,
    /// What a picture in longitude and latitude shows.
    File(PathBuf),
    /// Nothing but the background and what the mesh itself emits.
    None,
}

impl fmt::Display for Light {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Studio => f.write_str("studio"),
            Self::Sky => f.write_str("sky"),
            Self::None => f.write_str("none"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

impl FromStr for Light {
    type Err = Misunderstood;

    fn from_str(text: &str) -> Result<Self, Misunderstood> {
        match text {
            "studio" => Ok(Self::Studio),
            "sky" => Ok(Self::Sky),
            "none" => Ok(Self::None),
            file if file.contains('.') => Ok(Self::File(file.into())),
            _ => Err(Misunderstood(
                "studio, sky, none, or a picture file such as sky.exr".to_owned(),
            )),
        }
    }
}

/// What a mesh is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// What its file says.
    File,
    /// Warm grey with a hint of gloss.
    Clay,
    /// White and dull.
    Plaster,
    /// Polished stone.
    Marble,
    /// Blue, under a smooth coat.
    Plastic,
    /// Brushed steel.
    Metal,
    /// Gold.
    Gold,
    /// Copper.
    Copper,
    /// Clear glass.
    Glass,
}

impl Material {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::File,
        Self::Clay,
        Self::Plaster,
        Self::Marble,
        Self::Plastic,
        Self::Metal,
        Self::Gold,
        Self::Copper,
        Self::Glass,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Clay => "clay",
            Self::Plaster => "plaster",
            Self::Marble => "marble",
            Self::Plastic => "plastic",
            Self::Metal => "metal",
            Self::Gold => "gold",
            Self::Copper => "copper",
            Self::Glass => "glass",
        }
    }
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Material {
    type Err = Misunderstood;

    fn from_str(text: &str) -> Result<Self, Misunderstood> {
        let known = Self::ALL.into_iter().find(|material| material.name() == text);
        known.ok_or_else(|| Misunderstood(Self::ALL.map(Self::name).join(", ")))
    }
}

/// What is behind a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// Light of this colour, linear sRGB, which falls onto the mesh as well.
    Color(DVec3),
    /// Nothing: the picture has an alpha channel.
    Transparent,
}

impl Background {
    /// What comes from it.
    pub(super) fn light(self) -> DVec3 {
        match self {
            Self::Color(color) => color,
            Self::Transparent => DVec3::ZERO,
        }
    }
}

impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color(color) => write!(f, "{},{},{}", color.x, color.y, color.z),
            Self::Transparent => f.write_str("transparent"),
        }
    }
}

impl FromStr for Background {
    type Err = Misunderstood;

    fn from_str(text: &str) -> Result<Self, Misunderstood> {
        match text {
            "white" => return Ok(Self::Color(DVec3::ONE)),
            "black" => return Ok(Self::Color(DVec3::ZERO)),
            "transparent" => return Ok(Self::Transparent),
            _ => {}
        }
        let numbers: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
        let largest = f64::from(f32::MAX);
        match numbers.as_deref() {
            Some(&[r, g, b]) if [r, g, b].iter().all(|v| (0.0..=largest).contains(v)) => {
                Ok(Self::Color(DVec3::new(r, g, b)))
            }
            _ => Err(Misunderstood(
                "white, black, transparent, or red, green and blue of 0 or above (linear), such as 0.1,0.1,0.2"
                    .to_owned(),
            )),
        }
    }
}
