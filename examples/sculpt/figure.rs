//! The solid that is meshed: y is up, it stands on y = 0 and fits the box of `BOX_CENTER` ± `BOX_HALF`.

use glam::Vec3;

const BALL_CENTER: Vec3 = Vec3::new(0.0, 1.28, 0.0);
const BALL_RADIUS: f32 = 1.0;
/// A hollow in the middle, where the scene puts a lamp.
const HOLLOW_RADIUS: f32 = 0.42;
pub(crate) const BOX_CENTER: Vec3 = Vec3::new(0.0, 1.14, 0.0);
pub(crate) const BOX_HALF: Vec3 = Vec3::new(1.02, 1.16, 1.02);

/// The solid to be meshed.
#[derive(Clone, Copy)]
pub(crate) struct Figure {
    /// Half the thickness of the gyroid's walls.
    half_wall: f32,
    /// Radians of the gyroid per unit of length.
    frequency: f32,
}

impl Figure {
    /// A period of 0.79 and walls of 0.09, or, below some 60,000 triangles, as much more as a lattice of
    /// that spacing needs to hold the walls.
    pub(crate) fn for_spacing(half_cell: f32) -> Self {
        let half_wall = half_cell.max(0.045);
        Self { half_wall, frequency: 0.36 / half_wall }
    }

    /// Negative inside, positive outside; near the surface roughly the distance.
    pub(crate) fn distance(self, p: Vec3) -> f32 {
        let from_center = p - BALL_CENTER;
        let radius = from_center.length();
        let ball = radius - BALL_RADIUS;
        let plinth = plinth(p);
        if ball.min(plinth) > 0.1 {
            return ball.min(plinth);
        }
        let walls =
            gyroid(from_center * self.frequency).abs() / (1.4 * self.frequency) - self.half_wall;
        let shell = smooth_max(ball, HOLLOW_RADIUS - radius, 0.05);
        smooth_min(smooth_max(walls, shell, 0.045), plinth, 0.12)
    }

    /// The unit normal of the level set through `p`, by central differences.
    pub(crate) fn normal(self, p: Vec3) -> Vec3 {
        // Above the rounding of f32 (6e-8 / 1e-3 is a slope error of 1e-4), far below the walls.
        const STEP: f32 = 1e-3;
        let slope = |axis: Vec3| self.distance(p + axis * STEP) - self.distance(p - axis * STEP);
        Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y)
    }
}

/// Schoen's gyroid (1970) in its trigonometric approximation.
fn gyroid(p: Vec3) -> f32 {
    let ((sx, cx), (sy, cy), (sz, cz)) = (p.x.sin_cos(), p.y.sin_cos(), p.z.sin_cos());
    sx * cy + sy * cz + sz * cx
}

/// A round base with a narrower collar on it, edges rounded.
fn plinth(p: Vec3) -> f32 {
    let radius = p.x.hypot(p.z);
    let cylinder = |outer: f32, low: f32, high: f32, edge: f32| {
        let across = radius - (outer - edge);
        let along = (p.y - 0.5 * (low + high)).abs() - (0.5 * (high - low) - edge);
        across.max(along).min(0.0) + across.max(0.0).hypot(along.max(0.0)) - edge
    };
    smooth_min(cylinder(0.66, 0.0, 0.12, 0.03), cylinder(0.36, 0.05, 0.36, 0.02), 0.1)
}

/// The smaller of two distances, with the edge between them filled to a radius of about `k`
/// (Quilez's quadratic polynomial).
fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let overlap = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - overlap * overlap * k * 0.25
}

fn smooth_max(a: f32, b: f32, k: f32) -> f32 {
    -smooth_min(-a, -b, k)
}
