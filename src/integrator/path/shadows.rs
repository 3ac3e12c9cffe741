//! The shadow rays of a turn.

use super::Extras;
use super::pool::Slot;
use crate::emitter::EmitterSamples;
use crate::emitter::sample::ShadowRays;
use crate::integrator::Tracer;
use crate::math::Rgb;
use crate::math::real::{Columns, Lanes, Mask, Real};
use crate::math::vector::Vec3;
use crate::ray::{Ray, Rays};

/// Light that is on its way to surfaces.
pub(super) struct Shadows {
    /// The surfaces: throughput of the path up to there, and the bits of the slot of its sample.
    receivers: Columns<f32, 4>,
    /// How many samples of light each is the mean of.
    samples: u32,
    /// What has arrived there so far.
    arriving: Vec<Rgb>,
    /// Samples of light: what arrives if nothing is between, and the bits of the surface's number with [`HAS_RAY`].
    lights: Columns<f32, 4>,
    rays: Rays,
    occluded: Vec<bool>,
}

/// A ray has to say whether anything is between.
const HAS_RAY: u32 = 1 << 31;

impl Shadows {
    /// Bytes for each path.
    pub(super) const BYTES: usize = size_of::<Ray>() + size_of::<[f32; 8]>() + size_of::<Rgb>() + 1;

    pub(super) fn new(extras: &Extras) -> Self {
        Self {
            receivers: Columns::default(),
            samples: 0,
            arriving: Vec::new(),
            lights: Columns::default(),
            rays: Rays::with_time(extras.time),
            occluded: Vec::new(),
        }
    }

    /// How many rays wait.
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// The surfaces of the lanes that are set, to which light comes by so many samples: their numbers.
    #[inline(always)]
    pub(super) fn receive<R: Real>(
        &mut self,
        mask: R::Mask,
        samples: u32,
        throughput: Vec3<R>,
        slots: R::Uint,
    ) -> R::Uint {
        let first = self.receivers.len() as u32;
        let [x, y, z] = throughput.to_array();
        self.receivers.append(mask, [x, y, z, R::from_bits(slots)]);
        self.arriving.resize(self.receivers.len(), Rgb::ZERO);
        self.samples = samples;
        let mut next = first;
        R::Uint::from_fn(mask.token(), |i| {
            let number = next;
            next += u32::from(mask.lane(i));
            number
        })
    }

    /// A sample of the light that arrives at each surface, and the rays that have to be free for it; none where the two
    /// ends are too close.
    #[inline(always)]
    pub(super) fn add<R: Real>(
        &mut self,
        receivers: R::Uint,
        light: &EmitterSamples<R>,
        rays: &ShadowRays<R>,
    ) {
        let [x, y, z] = light.weight.to_array();
        let receivers = R::Uint::select(rays.exists, receivers | HAS_RAY, receivers);
        self.lights.append(light.exists, [x, y, z, R::from_bits(receivers)]);
        rays.append_to(&mut self.rays, light.exists & rays.exists);
    }

    /// Traces them all and adds to each sample what arrives.
    pub(super) fn trace(&mut self, tracer: &mut Tracer<'_>, slots: &mut [Slot]) {
        self.occluded.resize(self.rays.len(), false);
        tracer.occluded_many(&self.rays, &mut self.occluded);
        let mut occluded = self.occluded.iter();
        let [x, y, z, bits] = self.lights.columns();
        for (((x, y), z), bits) in x.iter().zip(y).zip(z).zip(bits) {
            let bits = bits.to_bits();
            let hidden = bits & HAS_RAY != 0 && occluded.next().is_some_and(|&hidden| hidden);
            if !hidden {
                self.arriving[(bits & !HAS_RAY) as usize] += Rgb::new(*x, *y, *z);
            }
        }
        let [x, y, z, slot] = self.receivers.columns();
        let throughputs = x.iter().zip(y).zip(z).zip(slot);
        for ((((x, y), z), slot), arriving) in throughputs.zip(&self.arriving) {
            let estimate = &mut slots[slot.to_bits() as usize].estimate;
            estimate.radiance += Rgb::new(*x, *y, *z) * (*arriving / self.samples as f32);
        }
        self.receivers.clear();
        self.arriving.clear();
        self.lights.clear();
        self.rays.clear();
        self.occluded.clear();
    }
}
