//! The finished picture, as plain data that every file format is written from.

use super::{ComponentFormat, Content, Crop, Film, FilmSettings};
use crate::math::Rgb;

/// Channels over the rendered part of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The part of it that the channels cover.
    pub crop: Crop,
    /// The channels, in no particular order; no two of one name.
    pub channels: Vec<Channel>,
    /// Precision of colours in an EXR file, if it has nothing but colours.
    pub component: ComponentFormat,
}

/// One number per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// `R`, `G`, `B` and `A` for the picture proper, `layer.component` for anything else.
    pub name: String,
    /// The numbers, row by row over the crop.
    pub values: Values,
}

/// The numbers of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Linear sRGB radiance, multiplied by alpha, or alpha itself: in the precision of the picture.
    Color(Vec<f32>),
    /// Anything else that is measured: always in 32 bits, since half a position is of no use.
    Float(Vec<f32>),
    /// Whole numbers.
    Index(Vec<u32>),
}

impl Picture {
    /// What `film` holds: means over the samples so far, under the names that Mitsuba 3 gives them; then, if
    /// it is kept, [`Film::variance`] as `variance.R`, `.G` and `.B` with the number of samples as
    /// `samples.N`.
    #[must_use]
    pub fn from_film(film: &Film) -> Self {
        let settings = film.settings();
        let mut channels = Vec::new();
        if film.content().picture {
            let radiance = film.radiance();
            for (component, name) in ["R", "G", "B"].into_iter().enumerate() {
                let values = radiance.iter().map(|rgb| rgb[component]).collect();
                channels.push(Channel::new(name, Values::Color(values)));
            }
            if settings.alpha {
                channels.push(Channel::new("A", Values::Color(film.alpha())));
            }
        }
        if settings.variance && film.content().variance {
            let variance = film.variance();
            for (component, name) in ["R", "G", "B"].into_iter().enumerate() {
                let values = variance.iter().map(|rgb| rgb[component]).collect();
                channels.push(Channel::new(format!("variance.{name}"), Values::Float(values)));
            }
            channels.push(Channel::new("samples.N", Values::Index(film.samples())));
        }
        channels.extend(layers(film));
        let (width, height, crop) = (settings.width, settings.height, settings.crop);
        Self { width, height, crop, channels, component: settings.component }
    }

    /// Bytes that making and writing the picture of a film takes beside the film: its channels, and a copy
    /// of one kind of them at a time.
    #[must_use]
    pub fn bytes(settings: &FilmSettings, content: &Content) -> u64 {
        let if_kept = |kept, channels| if kept { channels } else { 0 };
        let layers: usize = content.layers.iter().map(|l| l.kind.components().len()).sum();
        let channels = if_kept(content.picture, 3)
            + if_kept(content.picture && settings.alpha, 1)
            + if_kept(content.variance && settings.variance, 4)
            + layers;
        let per_pixel = channels * size_of::<f32>() + size_of::<Rgb>();
        let Crop { width, height, .. } = settings.crop;
        (u64::from(width) * u64::from(height)).saturating_mul(per_pixel as u64)
    }

    /// The colour or alpha channel of this name.
    #[must_use]
    pub fn color(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).and_then(|c| match &c.values {
            Values::Color(values) => Some(values.as_slice()),
            Values::Float(_) | Values::Index(_) => None,
        })
    }

    /// Pixels of the crop.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.crop.width as usize * self.crop.height as usize
    }
}

impl Channel {
    /// A channel.
    #[must_use]
    pub fn new(name: impl Into<String>, values: Values) -> Self {
        Self { name: name.into(), values }
    }
}

impl Values {
    /// How many numbers there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Color(values) | Self::Float(values) => values.len(),
            Self::Index(values) => values.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The channels beside the picture proper. The film counts averaged components and indices apart.
fn layers(film: &Film) -> Vec<Channel> {
    let (mut numbers, mut indices) = (0.., 0..);
    let mut channels = Vec::new();
    for layer in &film.content().layers {
        for component in layer.kind.components() {
            let values = if layer.kind.is_index() {
                indices.next().map(|i| Values::Index(film.index(i)))
            } else {
                numbers.next().map(|i| Values::Float(film.number(i)))
            };
            let name = format!("{}.{component}", layer.name);
            channels.extend(values.map(|values| Channel::new(name, values)));
        }
    }
    channels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{AovKind, AovLayer, Content, FilmSettings, Filter};
    use crate::math::Rgb;

    /// One sample of a 1x1 film whose every number differs, so that no two channels can be confused.
    #[test]
    fn layers_have_the_names_that_other_tools_expect() {
        let kinds = [
            ("depth", AovKind::Depth),
            ("index", AovKind::ShapeIndex),
            ("p", AovKind::Position),
            ("ng", AovKind::GeometricNormal),
            ("triangle", AovKind::PrimitiveIndex),
            ("ns", AovKind::ShadingNormal),
            ("uv", AovKind::Uv),
            ("albedo", AovKind::Albedo),
        ];
        let layers = kinds.map(|(name, kind)| AovLayer { name: name.to_owned(), kind });
        let settings = FilmSettings {
            width: 3,
            height: 2,
            crop: Crop { x: 1, y: 1, width: 1, height: 1 },
            filter: Filter::Box,
            alpha: true,
            component: ComponentFormat::Half,
            variance: true,
            clamp: None,
        };
        let content =
            Content { picture: true, variance: true, halves: false, layers: layers.to_vec() };
        let mut film = Film::new(&settings, content);
        let tile = &mut film.tiles_mut()[0];
        tile.add_picture(0, Rgb::new(0.25, 0.5, 0.75), 1.0);
        let (numbers, indices) = tile.layers_mut(0);
        numbers.iter_mut().zip(1..).for_each(|(n, i)| *n = f64::from(i));
        indices.copy_from_slice(&[70, 80]);
        tile.count_sample(0);

        let picture = Picture::from_film(&film);
        let names: Vec<_> = picture.channels.iter().map(|c| c.name.as_str()).collect();
        // What Mitsuba 3.9 names the same layers.
        let expected = "R G B A variance.R variance.G variance.B samples.N depth.T index.I p.X p.Y p.Z ng.X ng.Y ng.Z triangle.I ns.X ns.Y ns.Z \
                        uv.U uv.V albedo.R albedo.G albedo.B";
        assert_eq!(names.join(" "), expected);
        let value = |name: &str| {
            let channel = picture.channels.iter().find(|c| c.name == name);
            channel.map(|c| c.values.clone())
        };
        assert_eq!(value("G"), Some(Values::Color(vec![0.5])));
        assert_eq!(value("A"), Some(Values::Color(vec![1.0])));
        assert_eq!(value("depth.T"), Some(Values::Float(vec![1.0])));
        assert_eq!(value("ng.X"), Some(Values::Float(vec![5.0])));
        assert_eq!(value("albedo.B"), Some(Values::Float(vec![15.0])));
        assert_eq!(value("index.I"), Some(Values::Index(vec![70])));
        assert_eq!(value("variance.G"), Some(Values::Float(vec![f32::INFINITY])));
        assert_eq!(value("samples.N"), Some(Values::Index(vec![1])));
        assert_eq!(value("triangle.I"), Some(Values::Index(vec![80])));
        assert_eq!((picture.width, picture.height, picture.pixels()), (3, 2, 1));
        // A layer is no colour of the picture.
        assert_eq!(picture.color("depth.T"), None);
    }
}
