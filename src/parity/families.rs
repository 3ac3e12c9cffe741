//! Kinds of rays, each of which has broken some engine.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::ray::Ray;

/// A kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// From a camera.
    Camera,
    #[default]
    /// Between two points around the shapes, or one of them on a surface; half of them end at the second.
    Pair,
    /// Away from a surface, as diffuse reflection and transmission send them.
    Bounce,
    /// Towards a vertex.
    Vertex,
    /// Towards a point of an edge.
    Edge,
    /// Along an axis, with other components +0 or −0, through coordinates of vertices: in the planes of
    /// boxes, exactly through vertices, along faces.
    Axis,
    /// Nearly in the plane of a triangle, along an edge, or from surface to surface.
    Grazing,
    /// From close behind a surface: inside of what is closed.
    Inside,
    /// From as far away as leaves something to be decided, at most 10⁶ times the size of the scene.
    Far,
    /// With ends close to a surface, equal, tiny or huge.
    Segment,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Camera,
        Self::Pair,
        Self::Bounce,
        Self::Vertex,
        Self::Edge,
        Self::Axis,
        Self::Grazing,
        Self::Inside,
        Self::Far,
        Self::Segment,
    ];

    /// Whether its rays are aimed at what is hard: vertices, edges, planes of triangles, or from so far away
    /// that all triangles are small. The others meet such places by chance.
    #[must_use]
    pub fn is_aimed(self) -> bool {
        match self {
            Self::Camera | Self::Pair | Self::Bounce | Self::Inside | Self::Segment => false,
            Self::Vertex | Self::Edge | Self::Axis | Self::Grazing | Self::Far => true,
        }
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Pair => "pair",
            Self::Bounce => "bounce",
            Self::Vertex => "vertex",
            Self::Edge => "edge",
            Self::Axis => "axis",
            Self::Grazing => "grazing",
            Self::Inside => "inside",
            Self::Far => "far",
            Self::Segment => "segment",
        }
    }
}

impl Display for Family {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Rays by number: the same number gives the same ray.
pub trait RaySource: Sync {
    /// How many there are.
    fn count(&self) -> u64;

    /// Ray number `index`, which is below [`RaySource::count`], and its kind.
    fn ray(&self, index: u64) -> (Family, Ray);
}
