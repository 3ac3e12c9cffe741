//! One triangle of a mesh: its normal and area, and points on it that rays can leave from.

use glam::{DVec3, Vec2, Vec3, Vec3A};

use super::{SurfacePoint, error_offset, rounding};
use crate::math::Frame;

/// A triangle with what is derived from its corners.
pub(super) struct Triangle {
    corner: Vec3A,
    edge_1: Vec3A,
    edge_2: Vec3A,
    /// Unit normal: counter-clockwise corners face the viewer.
    pub(super) normal: Vec3A,
    pub(super) area: f64,
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrianglePoint {
    pub(super) position: Vec3A,
    /// Those of the second and third corner.
    pub(super) weights: [f32; 2],
    /// [`rounding`] there.
    pub(super) error: Vec3A,
}

impl Triangle {
    #[inline(always)]
    pub(super) fn new(corners: [Vec3A; 3]) -> Self {
        let [a, b, c] = corners;
        let (edge_1, edge_2) = (b - a, c - a);
        let (normal, area) = normal_and_area(corners, edge_1, edge_2);
        Self { corner: a, edge_1, edge_2, normal, area }
    }

    /// The point at the weights `[u, v]` of the second and third corner.
    #[inline(always)]
    pub(super) fn point(&self, weights: [f32; 2]) -> TrianglePoint {
        // Far from the origin, where the edges are exact, this is one rounding; weights for all three
        // corners would make three.
        let position = self.corner + (self.edge_1 * weights[0] + self.edge_2 * weights[1]);
        TrianglePoint { position, weights, error: rounding(position, self.extent()) }
    }

    /// The same for a point that rays will leave from, moved away from an edge by the offset of a surface
    /// there at most: on the edge it would be rounded onto the surface that meets this one there, or
    /// through it, and a ray towards that surface would start behind it.
    #[inline(always)]
    pub(super) fn inner_point(&self, weights: [f32; 2]) -> TrianglePoint {
        let point = self.point(weights);
        // A bound of all three weights at that distance from an edge. The exact ones are for the few points
        // that are so close.
        let close = point.error.element_sum() * self.extent().element_sum() / self.area as f32;
        let [u, v] = weights;
        if u >= close && v >= close && 1.0 - u - v >= close {
            return point;
        }
        self.point(self.inset(point.error, [1.0 - u - v, u, v]))
    }

    /// The surface at one of its points, for the normals of its corners if they have any.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    pub(super) fn surface(
        &self,
        point: TrianglePoint,
        vertex_normals: Option<[Vec3; 3]>,
    ) -> SurfacePoint {
        let TrianglePoint { position, weights: [u, v], error } = point;
        let (mut geometric_normal, mut shading_normal) = (self.normal, self.normal);
        if let Some([n0, n1, n2]) = vertex_normals {
            // A zero or non-finite interpolated normal leaves the geometric one.
            if let Some(n) = (n0 * (1.0 - u - v) + n1 * u + n2 * v).try_normalize() {
                shading_normal = n.into();
                // A file's vertex normals say which side is out, even where its winding does not.
                if shading_normal.dot(geometric_normal) < 0.0 {
                    geometric_normal = -geometric_normal;
                }
            }
        }
        SurfacePoint {
            position,
            geometric_normal,
            shading_normal,
            offset: error_offset(geometric_normal, error),
            time: 0.0,
        }
    }

    /// How far it reaches from any of its points, per axis.
    #[inline(always)]
    fn extent(&self) -> Vec3A {
        self.edge_1.abs().max(self.edge_2.abs())
    }

    /// The weights of the nearest point that keeps its distance from all edges; in a triangle too narrow
    /// for that, it is in the middle between the long ones.
    #[cold]
    fn inset(&self, error: Vec3A, weights: [f32; 3]) -> [f32; 2] {
        let [e1, e2] = [self.edge_1, self.edge_2].map(|e| e.as_dvec3());
        // Opposite of the corners.
        let edges = [e2 - e1, e2, e1];
        let lengths = edges.map(DVec3::length);
        let margins = [0, 1, 2].map(|i| {
            let inwards = self.normal.cross((edges[i] / lengths[i]).as_vec3a());
            let distance = f64::from(error_offset(inwards, error));
            // Over the height: the weight at that distance. NaN, of an edge that rounding has taken, is lost.
            (distance * lengths[i] / (2.0 * self.area)).max(0.0)
        });
        // From the corner opposite of the shortest edge to it, then between the two other edges.
        let shortest = |i: usize, j: usize| if lengths[j] < lengths[i] { j } else { i };
        let apex = shortest(shortest(0, 1), 2);
        let (left, right) = ((apex + 1) % 3, (apex + 2) % 3);
        let [along, across] = [apex, left].map(|i| f64::from(weights[i]));
        let least = margins[apex].min(1.0 / 3.0);
        let both = margins[left] + margins[right];
        let most = if both < 1.0 - least { 1.0 - both } else { 1.0 };
        let along = along.clamp(least, most);
        let width = 1.0 - along;
        let [near, far] = [left, right].map(|i| margins[i].min(0.5 * width));
        let across = across.clamp(near, width - far);
        let mut inner = [0.0; 3];
        (inner[apex], inner[left], inner[right]) = (along, across, width - across);
        [inner[1] as f32, inner[2] as f32]
    }
}

/// Weights of a point of the triangle. Engines may report some slightly outside; inside, interpolation
/// cannot overshoot.
#[inline(always)]
pub(super) fn clamp(b: Vec2) -> [f32; 2] {
    let inside = b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0;
    if inside {
        return [b.x, b.y];
    }
    let u = b.x.clamp(0.0, 1.0);
    [u, b.y.clamp(0.0, 1.0 - u)]
}

/// Texture coordinates at a point, for those of the corners: its weights where they have none.
pub(super) fn uv(weights: Vec2, corners: Option<[Vec2; 3]>) -> Vec2 {
    let [u, v] = clamp(weights);
    corners.map_or(Vec2::new(u, v), |[t0, t1, t2]| t0 * (1.0 - u - v) + t1 * u + t2 * v)
}

/// Derivatives of the position after both texture coordinates, for those of the corners: directions along the
/// triangle where they have none, or two the same.
pub(super) fn tangents(corners: [Vec3A; 3], uvs: Option<[Vec2; 3]>) -> [Vec3A; 2] {
    let [p0, p1, p2] = corners;
    let by_uv = uvs.map(|uvs| {
        let [t0, t1, t2] = uvs.map(|uv| uv.as_dvec2());
        let (t1, t2) = (t1 - t0, t2 - t0);
        let (e1, e2) = ((p1 - p0).as_dvec3(), (p2 - p0).as_dvec3());
        let determinant = t1.perp_dot(t2);
        [(e1 * t2.y - e2 * t1.y) / determinant, (e2 * t1.x - e1 * t2.x) / determinant]
            .map(|d| d.as_vec3a())
    });
    by_uv.filter(|[u, v]| u.is_finite() && v.is_finite()).unwrap_or_else(|| {
        let frame = Frame::from_normal(Triangle::new(corners).normal);
        [frame.s, frame.t]
    })
}

/// The unit normal of a triangle and its area. In f32 where that is exact to a few roundings; the cross
/// product of a sliver cancels, and that of very short or very long edges leaves the range, so those are
/// formed in f64.
#[inline(always)]
fn normal_and_area(corners: [Vec3A; 3], e1: Vec3A, e2: Vec3A) -> (Vec3A, f64) {
    let n = e1.cross(e2);
    let (length_squared, edges) = (n.length_squared(), e1.length_squared() * e2.length_squared());
    // sin² of the angle between the edges: above 1/16 at most two bits cancel.
    if length_squared > 0.0625 * edges && edges > 1e-30 && edges < 1e30 {
        let length = length_squared.sqrt();
        return (n / length, 0.5 * f64::from(length));
    }
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let n = (b - a).cross(c - a);
    let length = n.length();
    ((n / length).as_vec3a(), 0.5 * length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances of a point from the edges, in f64.
    fn heights(corners: [Vec3A; 3], position: Vec3A) -> [f64; 3] {
        let [a, b, c, p] = [corners[0], corners[1], corners[2], position].map(Vec3A::as_dvec3);
        [(b, c), (c, a), (a, b)].map(|(from, to)| {
            let along = (to - from).normalize();
            (p - from).reject_from_normalized(along).length()
        })
    }

    #[test]
    fn inner_points_keep_off_the_edges() {
        for far in [0.0, 1e3, 1e6] {
            let far = Vec3A::new(far, -far, far);
            let corners = [Vec3A::ZERO, Vec3A::new(4.0, 1.0, 0.5), Vec3A::new(1.0, 3.0, -1.0)]
                .map(|p| p + far);
            let triangle = Triangle::new(corners);
            for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.3], [0.3, 0.3]] {
                let plain = triangle.point([u, v]);
                let inner = triangle.inner_point([u, v]);
                let offset = error_offset(triangle.normal, inner.error);
                for height in heights(corners, inner.position) {
                    // The margin follows an edge's own direction: between a half and twice that of the normal
                    // here. The position is rounded once more.
                    assert!(height >= 0.25 * f64::from(offset), "{u} {v}: {height} {offset}");
                }
                let moved = plain.position.distance(inner.position);
                assert!(moved <= 8.0 * offset, "{u} {v}: {moved} {offset}");
            }
        }
    }

    /// A strip of 1 by 1e-6 far from the origin, narrower than two margins: points stay where they are along
    /// it.
    #[test]
    fn inner_points_do_not_slide_along_slivers() {
        let far = Vec3A::new(100.0, 0.0, 7.0);
        let corners = [Vec3A::ZERO, Vec3A::X, Vec3A::Y * 1e-6].map(|p| p + far);
        let triangle = Triangle::new(corners);
        for i in 1..100 {
            let u = i as f32 / 100.0;
            let inner = triangle.inner_point([u, 0.0]);
            assert!((inner.position.x - 100.0 - u).abs() < 1e-4, "{u}: {}", inner.position);
            assert!(inner.weights.iter().all(|w| (0.0..=1.0).contains(w)));
        }
    }

    /// From a corner this far away the others are one, and the edge between them has no length.
    #[test]
    fn an_edge_lost_in_rounding_does_no_harm() {
        let corners = [Vec3A::new(1e10, 1e10, 0.0), Vec3A::ZERO, Vec3A::X];
        let triangle = Triangle::new(corners);
        assert!(triangle.area > 0.0);
        for weights in [[0.0, 0.0], [1.0, 0.0], [0.2, 0.7]] {
            let inner = triangle.inner_point(weights);
            assert!(inner.position.is_finite() && inner.error.is_finite(), "{weights:?}");
        }
    }
}
