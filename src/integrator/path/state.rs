//! What paths carry from one surface to the next, by column.

use super::emission::LastEdges;
use super::{Extras, Paths};
use crate::bsdf::Flags;
use crate::emitter::Receivers;
use crate::math::real::{Column, Columns, Lanes, Real, Uint};
use crate::math::vector::Vec3;
use crate::ray::RayEnds;
use crate::sampler::PathKeys;

/// What paths carry beside their rays.
pub(super) struct State {
    /// Throughput, and as bits the edges with flags, the slot of the sample, both halves of the sampler's key and how many
    /// numbers have been drawn.
    always: Columns<f32, 8>,
    eta: Column<f32>,
    /// Density of the last edge.
    pdf: Column<f32>,
}

/// The last edge was [`LastEdge::Chosen`].
const CHOSEN: u32 = 1;

/// The surface where it was chosen transmits light.
const TRANSMITS: u32 = 2;

/// The path has met nothing that it did not pass straight through.
const UNSCATTERED: u32 = 4;

/// An edge before the last one was [`LastEdge::Chosen`].
const SCATTERED: u32 = 8;

/// The surface where the last edge was chosen is glossy.
const GLOSSY: u32 = 16;

/// One edge; there are none on the way from the camera.
const EDGE: u32 = 32;

/// A path's numbers: those of [`State::always`], eta and density.
type Row = ([f32; 8], f32, f32);

/// What the paths of some lanes carry.
#[derive(Clone, Copy, Debug)]
pub(super) struct StateLanes<R: Real> {
    pub(super) throughput: Vec3<R>,
    pub(super) eta: R,
    pdf: R,
    /// Edges and flags.
    bits: R::Uint,
    pub(super) slots: R::Uint,
    pub(super) keys: PathKeys<R::Uint>,
    pub(super) dimension: R::Uint,
}

impl State {
    /// Bytes of what every path carries.
    pub(super) const BYTES: usize = size_of::<[f32; 8]>();

    /// Bytes for each path at most.
    pub(super) const MOST_BYTES: usize = size_of::<Row>();

    pub(super) fn new(extras: &Extras) -> Self {
        Self {
            always: Columns::default(),
            eta: Column::new(extras.eta, 1.0),
            pdf: Column::new(extras.pdf, 0.0),
        }
    }

    pub(super) fn clear(&mut self) {
        self.always.clear();
        self.eta.clear();
        self.pdf.clear();
    }

    /// A path that leaves the camera.
    pub(super) fn begin(&mut self, slot: usize, key: PathKeys<u32>, dimension: u32) {
        let [bits, slot, high, low, dimension] =
            [UNSCATTERED, slot as u32, key.high, key.low, dimension].map(f32::from_bits);
        self.push(([1.0, 1.0, 1.0, bits, slot, high, low, dimension], 1.0, 0.0));
    }

    pub(super) fn row(&self, path: usize) -> Row {
        (self.always.row(path), self.eta.row(path), self.pdf.row(path))
    }

    pub(super) fn push(&mut self, (always, eta, pdf): Row) {
        self.always.push(always);
        self.eta.push(eta);
        self.pdf.push(pdf);
    }

    /// The slot of a path's sample, whether it comes from the camera, and whether it has met nothing that it did not pass
    /// straight through.
    pub(super) fn whence(&self, path: usize) -> (usize, bool, bool) {
        let [.., bits, slot, _, _, _] = self.always.row(path).map(f32::to_bits);
        (slot as usize, bits / EDGE == 0, bits & UNSCATTERED != 0)
    }

    #[inline(always)]
    pub(super) fn gather<R: Real>(&self, token: R::Token, paths: &[usize]) -> StateLanes<R> {
        let [x, y, z, bits, slot, high, low, dimension] = self.always.gather::<R>(token, paths);
        StateLanes {
            throughput: Vec3::new(x, y, z),
            eta: self.eta.gather(token, paths),
            pdf: self.pdf.gather(token, paths),
            bits: bits.to_bits(),
            slots: slot.to_bits(),
            keys: PathKeys { high: high.to_bits(), low: low.to_bits() },
            dimension: dimension.to_bits(),
        }
    }

    #[inline(always)]
    pub(super) fn append<R: Real>(&mut self, mask: R::Mask, lanes: &StateLanes<R>) {
        let StateLanes { throughput, eta, pdf, bits, slots, keys, dimension } = *lanes;
        let [x, y, z] = throughput.to_array();
        let (bits, slots, dimension) =
            (R::from_bits(bits), R::from_bits(slots), R::from_bits(dimension));
        let (high, low) = (R::from_bits(keys.high), R::from_bits(keys.low));
        self.always.append(mask, [x, y, z, bits, slots, high, low, dimension]);
        self.eta.append(mask, eta);
        self.pdf.append(mask, pdf);
    }
}

impl<R: Real> StateLanes<R> {
    /// Where the path comes from the camera.
    #[inline(always)]
    pub(super) fn begins(&self) -> R::Mask {
        (self.bits & !(EDGE - 1)).eq(0)
    }

    /// Whether a lane's path has met nothing that it did not pass straight through.
    #[inline(always)]
    pub(super) fn is_unscattered(&self, i: usize) -> bool {
        self.bits.lane(i) & UNSCATTERED != 0
    }

    /// The newest edges, which leave the surfaces `starts`.
    #[inline(always)]
    pub(super) fn last_edges(&self, starts: &RayEnds<R>) -> LastEdges<R> {
        let receivers = Receivers {
            position: starts.point,
            normal: starts.facing_normal(),
            both_sides: !(self.bits & TRANSMITS).eq(0),
            is_diffuse: (self.bits & GLOSSY).eq(0),
        };
        LastEdges {
            is_forced: (self.bits & CHOSEN).eq(0),
            pdf: self.pdf,
            receivers,
            is_first: (self.bits & SCATTERED).eq(0),
        }
    }

    /// Where the surface is the first one where the path may scatter otherwise than by mirrors or glass.
    #[inline(always)]
    pub(super) fn is_first(&self) -> R::Mask {
        (self.bits & (CHOSEN | SCATTERED)).eq(0)
    }

    /// Edges of a lane's path, 1 at the first surface.
    #[inline(always)]
    pub(super) fn edges(&self, i: usize) -> u32 {
        self.bits.lane(i) / EDGE + 1
    }

    /// The slot of a lane's sample.
    #[inline(always)]
    pub(super) fn slot(&self, i: usize) -> usize {
        self.slots.lane(i) as usize
    }

    /// After one more edge, from a surface of a material.
    #[inline(always)]
    pub(super) fn after(&self, paths: &Paths<'_, R>, flags: Flags) -> Self {
        let held = |holds: bool, flag: u32| if holds { flag } else { 0 };
        let chosen = CHOSEN | held(flags.transmits, TRANSMITS) | held(flags.glossy, GLOSSY);
        let token = self.eta.token();
        let edge = R::Uint::select(paths.is_forced, R::Uint::splat(token, 0), chosen);
        let straight = R::Uint::select(paths.is_null, self.bits & UNSCATTERED, 0);
        let scattered = R::Uint::select(paths.is_first, R::Uint::splat(token, 0), SCATTERED);
        // More than 2²⁷ edges stay as many.
        let edges = self.bits & !(EDGE - 1);
        let longest = !(EDGE - 1);
        let more = R::Uint::select(edges.eq(longest), edges, edges.wrapping_add(EDGE));
        Self {
            throughput: paths.throughput,
            eta: paths.eta,
            pdf: paths.pdf,
            bits: more | edge | straight | scattered,
            slots: self.slots,
            keys: self.keys,
            dimension: paths.numbers.dimension,
        }
    }
}
