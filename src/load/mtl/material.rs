//! What becomes of a material.
//!
//! | In the file | Here |
//! |---|---|
//! | `illum` 0 or 1, or no `Ks` | diffuse `Kd` |
//! | `illum` 2 or none, or any but those below | rough plastic: base `Kd`, highlights times `Ks`, index `Ni` (1.5 if that is 1 or less), Beckmann's α with α² = 2/(`Ns` + 2) |
//! | `illum` 3, 5, 8 | diffuse `Kd` and a mirror `Ks`, scaled down where both together reflect more than all |
//! | `illum` 4, 6, 7, 9, if `d` is below 1, or for 6 and 7 if `Ni` is not 1 | glass of the index `Ni`, coloured by `Tf` |
//! | `d` or `Tr`, `map_d`, unless it is glass | holes for the part that lets light through |
//! | `norm`, `map_Bump` | normals, heights |
//! | `Ke` | light of this radiance |
//!
//! `Kd` is a factor of `map_Kd`; some programs write 0 beside the map, which counts as 1. All but glass is seen from both
//! sides.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine2, DVec3, Mat2, Vec2};
use half::f16;
use rayon::prelude::*;

use super::super::properties::Object;
use super::{Map, Mtl};
use crate::bsdf::conductor::Metal;
use crate::bsdf::microfacet::{Distribution, LEAST_ALPHA};
use crate::bsdf::perturbed::{Normals, PerturbedOptions};
use crate::bsdf::plastic::Coat;
use crate::bsdf::{
    Blend, Bsdf, Conductor, Dielectric, Diffuse, Mask, Perturbed, RoughPlastic, TwoSided,
};
use crate::math::Rgb;
use crate::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use crate::texture::image::Texels;
use crate::texture::{Bitmap, Image, Textured};

/// Heights of a bump map reach from 0 to 1; in scene units they are this part of the mesh's size, times `-bm`.
const RELIEF: f64 = 0.01;

/// The exponent of highlights where there is none: what viewers of the format use.
const USUAL_EXPONENT: f64 = 30.0;

/// The largest index of refraction: no clear substance comes near it.
const MOST_INDEX: f64 = 10.0;

/// What a surface of a material is made of.
#[derive(Debug)]
pub(in crate::load) struct Surface {
    pub(in crate::load) bsdf: Box<dyn Bsdf>,
    /// The radiance that it emits, if it does.
    pub(in crate::load) emission: Option<Rgb>,
}

/// The kind of a material, with all that does not vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Diffuse {
        diffuse: DVec3,
    },
    Plastic {
        diffuse: DVec3,
        specular: DVec3,
        index: f64,
        alpha: f64,
    },
    /// A mixture; the colours are those of the whole.
    Mirror {
        diffuse: DVec3,
        specular: DVec3,
    },
    Glass {
        index: f64,
        transmission: DVec3,
    },
}

impl Mtl {
    pub(super) fn kind(&self) -> Kind {
        let unit = |v: DVec3| v.clamp(DVec3::ZERO, DVec3::ONE);
        let black_beside_map =
            self.diffuse_map.is_some() && self.diffuse.is_none_or(|d| d == DVec3::ZERO);
        let usual = if black_beside_map { DVec3::ONE } else { DVec3::splat(0.8) };
        let diffuse = self.diffuse.filter(|_| !black_beside_map).map_or(usual, unit);
        let specular = self.specular.map_or(DVec3::ZERO, unit);
        let index = self.index.filter(|&i| i > 1.0).unwrap_or(1.5).min(MOST_INDEX);
        let clear = self.opacity.is_some_and(|d| d < 1.0);
        let refracts = self.index.is_some_and(|i| i > 1.0);
        match self.illumination {
            Some(illum @ (4 | 6 | 7 | 9)) if clear || (illum != 4 && illum != 9 && refracts) => {
                Kind::Glass { index, transmission: unit(self.transmission.unwrap_or(DVec3::ONE)) }
            }
            Some(3 | 5 | 8) if specular != DVec3::ZERO => {
                let total = diffuse.max_element() + specular.max_element();
                let scale = 1.0 / total.max(1.0);
                Kind::Mirror { diffuse: diffuse * scale, specular: specular * scale }
            }
            illum if specular == DVec3::ZERO || matches!(illum, Some(0 | 1)) => {
                Kind::Diffuse { diffuse }
            }
            _ => {
                let exponent = self.exponent.unwrap_or(USUAL_EXPONENT);
                let alpha = (2.0 / (exponent + 2.0)).sqrt().max(f64::from(LEAST_ALPHA));
                Kind::Plastic { diffuse, specular, index, alpha }
            }
        }
    }
}

/// Plastics by their index and roughness. What they have in common takes hundredths of a second to compute: it is for the
/// first ones of a file, and lies between those of a grid for further ones.
#[derive(Debug, Default)]
pub(in crate::load) struct Plastics {
    exact: HashMap<[u32; 2], RoughPlastic>,
    /// By the steps of index and roughness.
    grid: HashMap<[usize; 2], RoughPlastic>,
}

/// Different ones of a file that are computed by themselves.
const MOST_EXACT: usize = 32;

/// Steps of the grid in each direction. It is even in the logarithms, since what changes with the roughness does so where
/// that is as large as the cosine. A step is 0.14 in the logarithm of the roughness and 0.036 in that of the index: between
/// its ends a function f is off by 0.0026 or 0.00016 times its second derivative after the logarithm.
const STEPS: usize = 64;

/// From the least to the largest that [`Mtl::kind`] gives.
const INDICES: [f64; 2] = [1.0, MOST_INDEX];
const ALPHAS: [f64; 2] = [LEAST_ALPHA as f64, 1.0];

impl Plastics {
    fn plastic(&mut self, coat: Coat, index: f32, alpha: f32) -> RoughPlastic {
        let key = [index, alpha].map(f32::to_bits);
        if let Some(known) = self.exact.get(&key) {
            return known.with_coat(coat);
        }
        if self.exact.len() < MOST_EXACT {
            let plastic = RoughPlastic::new(coat, Distribution::Beckmann, alpha);
            self.exact.insert(key, plastic.clone());
            return plastic;
        }
        self.between(coat, index, alpha)
    }

    /// By the four points of the grid around it.
    pub(super) fn between(&mut self, coat: Coat, index: f32, alpha: f32) -> RoughPlastic {
        let places = [nearest(f64::from(index), INDICES), nearest(f64::from(alpha), ALPHAS)];
        let [indices, alphas] = places;
        let around = indices.map(|(i, s)| alphas.map(|(j, t)| ([i, j], s * t)));
        let around = around.as_flattened();
        for &([i, j], _) in around {
            self.grid.entry([i, j]).or_insert_with(|| {
                let coat = Coat::new(at(i, INDICES) as f32, 1.0, Rgb::ZERO, Rgb::ONE, false);
                RoughPlastic::new(coat, Distribution::Beckmann, at(j, ALPHAS) as f32)
            });
        }
        let parts: Vec<_> =
            around.iter().map(|(node, weight)| (*weight as f32, &self.grid[node])).collect();
        RoughPlastic::mixed(coat, Distribution::Beckmann, alpha, &parts)
    }
}

/// The value at a step of the grid.
fn at(step: usize, [least, most]: [f64; 2]) -> f64 {
    least * (most / least).powf(step as f64 / STEPS as f64)
}

/// The steps around a value, with their weights.
fn nearest(value: f64, [least, most]: [f64; 2]) -> [(usize, f64); 2] {
    let place = STEPS as f64 * (value / least).ln() / (most / least).ln();
    let first = place.floor().clamp(0.0, (STEPS - 1) as f64);
    let part = (place - first).clamp(0.0, 1.0);
    [(first as usize, 1.0 - part), (first as usize + 1, part)]
}

/// The surface of a mesh of this size that a material describes. `folder` is that of its file, `flips_v` whether texture
/// coordinates count from the upper edge.
///
/// # Errors
/// What is wrong with a picture that it names.
pub(in crate::load) fn surface(
    mtl: &Mtl,
    object: &Object<'_>,
    folder: &std::path::Path,
    flips_v: bool,
    size: f64,
    plastics: &mut Plastics,
) -> Result<Surface, String> {
    let maps = Maps { object, folder, flips_v };
    let kind = mtl.kind();
    let rgb = |v: DVec3| v.as_vec3a();
    let diffuse = |factor: DVec3| match &mtl.diffuse_map {
        Some(map) => maps.colors(map, factor),
        None => Ok(Textured::Uniform(rgb(factor))),
    };
    let mut bsdf: Box<dyn Bsdf> = match kind {
        Kind::Diffuse { diffuse: color } => Box::new(Diffuse::new(diffuse(color)?)),
        Kind::Plastic { diffuse: color, specular, index, alpha } => {
            let coat = Coat::new(index as f32, 1.0, diffuse(color)?, rgb(specular), false);
            Box::new(plastics.plastic(coat, index as f32, alpha as f32))
        }
        Kind::Mirror { diffuse: color, specular } => {
            // Both are as bright as the whole, so neither reflects more than all.
            let weight = specular.max_element() / (specular.max_element() + color.max_element());
            let mirror = Conductor::new(Metal::new(None, rgb(specular / weight)));
            if weight == 1.0 && mtl.diffuse_map.is_none() {
                Box::new(mirror)
            } else {
                let base = Diffuse::new(diffuse(color / (1.0 - weight))?);
                Box::new(Blend::new(weight as f32, [Box::new(base), Box::new(mirror)]))
            }
        }
        Kind::Glass { index, transmission } => {
            Box::new(Dielectric::new(index as f32, 1.0, Rgb::ONE, rgb(transmission)))
        }
    };
    let options = PerturbedOptions { flip_invalid_normals: true, use_shadowing_function: true };
    let normals = match (&mtl.normal_map, &mtl.bump_map) {
        (Some(map), _) => Some(Normals::Map(Textured::Varying(Arc::new(maps.numbers(map)?)))),
        (None, Some(map)) => {
            let height = maps.numbers(map)?;
            if is_of_normals(height.image()) {
                Some(Normals::Map(Textured::Varying(Arc::new(height))))
            } else {
                let scale = (map.bump * RELIEF * size) as f32;
                Some(Normals::Bump { height: Arc::new(height), scale })
            }
        }
        (None, None) => None,
    };
    if let Some(normals) = normals {
        bsdf = Box::new(Perturbed::new(normals, options, bsdf));
    }
    if !matches!(kind, Kind::Glass { .. }) {
        bsdf = Box::new(TwoSided::new(bsdf, None).expect("none but glass transmits"));
        if let Some(map) = &mtl.opacity_map {
            bsdf = Box::new(Mask::new(Textured::Varying(Arc::new(maps.numbers(map)?)), bsdf));
        }
        if let Some(opacity) = mtl.opacity.filter(|&d| d < 1.0) {
            bsdf = Box::new(Mask::new(opacity as f32, bsdf));
        }
    }
    let emission = mtl.emission.map(|e| e.max(DVec3::ZERO)).filter(|e| *e != DVec3::ZERO);
    Ok(Surface { bsdf, emission: emission.map(rgb) })
}

/// The pictures of a material.
struct Maps<'a> {
    object: &'a Object<'a>,
    folder: &'a std::path::Path,
    flips_v: bool,
}

impl Maps<'_> {
    fn image(&self, map: &Map) -> Result<Arc<Image>, String> {
        let path = self.folder.join(&map.file);
        // Files come from Windows too.
        let path = if path.exists() { path } else { self.folder.join(map.file.replace('\\', "/")) };
        self.object.image_at(&path).map_err(|problem| format!("{} {problem}", path.display()))
    }

    fn bitmap(&self, image: Arc<Image>, map: &Map, encoding: Encoding) -> Bitmap {
        let [(su, sv), (ou, ov)] = [map.scale, map.offset].map(|[u, v]| (u as f32, v as f32));
        // In the file v counts upwards: from the lower edge of the picture, to which its first row is the last.
        let v = if self.flips_v { 1.0 - sv - ov } else { ov };
        let to_uv = Affine2::from_mat2_translation(
            Mat2::from_diagonal(Vec2::new(su, sv)),
            Vec2::new(ou, v),
        );
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        Bitmap::new(image, BitmapSettings { encoding, filter: BitmapFilter::Bilinear, wrap, to_uv })
    }

    fn numbers(&self, map: &Map) -> Result<Bitmap, String> {
        Ok(self.bitmap(self.image(map)?, map, Encoding::Linear))
    }

    /// The colours of a picture, times a factor.
    fn colors(&self, map: &Map, factor: DVec3) -> Result<Textured<Rgb>, String> {
        let image = self.image(map)?;
        let bitmap = self.bitmap(Arc::clone(&image), map, Encoding::Srgb);
        if factor == DVec3::ONE {
            return Ok(Textured::Varying(Arc::new(bitmap)));
        }
        let count = u64::from(image.width()) * u64::from(image.height());
        self.object.limits().claim(6 * count).map_err(|error| format!("{}: {error}", map.file))?;
        let (width, factor) = (image.width(), factor.as_vec3a());
        let tinted = (0..count).into_par_iter().flat_map_iter(|i| {
            let at = glam::IVec2::new((i % u64::from(width)) as i32, (i / u64::from(width)) as i32);
            (bitmap.pixel(at) * factor).min(Rgb::ONE).to_array().map(f16::from_f32)
        });
        let texels = Texels::Half(tinted.collect());
        let tinted = Image::new(width, image.height(), 3, texels).expect("as many as there were");
        let tinted = self.bitmap(Arc::new(tinted), map, Encoding::Srgb);
        Ok(Textured::Varying(Arc::new(tinted)))
    }
}

/// Whether a picture for `map_Bump` shows normals, as what some programs write there: on average (1/2, 1/2, 1), far from
/// any grey.
fn is_of_normals(image: &Image) -> bool {
    let Texels::Unorm8(values) = image.texels() else { return false };
    if image.channels() != 3 {
        return false;
    }
    let (pixels, _) = values.as_chunks::<3>();
    let sums = pixels
        .iter()
        .fold([0_u64; 3], |sums, pixel| [0, 1, 2].map(|c| sums[c] + u64::from(pixel[c])));
    let [r, g, b] = sums.map(|sum| sum as f64 / (255.0 * pixels.len() as f64));
    (0.4..0.6).contains(&r) && (0.4..0.6).contains(&g) && b > 0.75
}
