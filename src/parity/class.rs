//! What engines are asked, what they answer, and what the referee says of it.

use std::fmt::{self, Display, Formatter};

use crate::ray::Hit;

/// A way to ask an engine about a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Query {
    /// [`Intersector::closest_hit`](crate::intersect::Intersector::closest_hit).
    Closest,
    /// [`Intersector::closest_hits`](crate::intersect::Intersector::closest_hits).
    ClosestBatch,
    /// [`Intersector::occluded`](crate::intersect::Intersector::occluded).
    Occluded,
    /// [`Intersector::occluded_many`](crate::intersect::Intersector::occluded_many).
    OccludedBatch,
}

/// What an engine says about a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The closest hit.
    Closest(Option<Hit>),
    /// Whether anything is in the way.
    Occluded(bool),
}

impl Answer {
    /// Whether both cannot be right about one ray: a hit and none, or two primitives.
    #[must_use]
    pub fn contradicts(&self, other: &Self) -> bool {
        let primitive = |hit: Hit| (hit.shape, hit.primitive);
        match (*self, *other) {
            (Self::Closest(a), Self::Closest(b)) => a.map(primitive) != b.map(primitive),
            (Self::Occluded(a), Self::Occluded(b)) => a != b,
            (Self::Closest(hit), Self::Occluded(occluded))
            | (Self::Occluded(occluded), Self::Closest(hit)) => hit.is_some() != occluded,
        }
    }
}

/// What the referee says of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// The nearest primitive that the ray crosses, or rightly nothing.
    Same,
    /// Another primitive at the same point: of a shared edge or vertex, or of coincident faces.
    Twin,
    /// Not what the ray crosses first, but the ray passes an edge that has nothing behind it, or ends
    /// at a surface, so closely that the rounding of f32 excuses the answer.
    Silhouette,
    /// Not what the ray crosses first, but so much is within the rounding of f32 that the referee does not say
    /// what that excuses ([`MOST_NEAR`](super::oracle::MOST_NEAR)).
    Undecided,
    /// Went through a surface that covers the ray on all sides, whether or not it hit something behind.
    Leak,
    /// A hit where there is nothing to hit.
    False,
    /// A hit elsewhere than on the primitive that it names.
    Wrong,
    /// A point of a triangle that the ray passes, at a distance that rounding does not explain.
    Distance,
}

impl Query {
    /// All of them.
    pub const ALL: &'static [Self] =
        &[Self::Closest, Self::ClosestBatch, Self::Occluded, Self::OccludedBatch];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Closest => "closest",
            Self::ClosestBatch => "closest, batch",
            Self::Occluded => "occluded",
            Self::OccludedBatch => "occluded, batch",
        }
    }
}

impl Class {
    /// All of them, the harmless first.
    pub const ALL: [Self; 8] = [
        Self::Same,
        Self::Twin,
        Self::Silhouette,
        Self::Undecided,
        Self::Leak,
        Self::False,
        Self::Wrong,
        Self::Distance,
    ];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Twin => "twin",
            Self::Silhouette => "silhouette",
            Self::Undecided => "undecided",
            Self::Leak => "leak",
            Self::False => "false",
            Self::Wrong => "wrong",
            Self::Distance => "distance",
        }
    }

    /// Whether no rounding excuses it.
    #[must_use]
    pub fn is_fault(self) -> bool {
        matches!(self, Self::Leak | Self::False | Self::Wrong | Self::Distance)
    }
}

impl Display for Query {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Display for Class {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
