//! Instances: the same questions in the space of a group.

use super::truth::{Confirmed, Encounter, Truth};
use super::{Oracle, Span};
use crate::ray::{Hit, Ray};
use crate::shape::{Instance, instance::LocalRay};

/// What lies along a ray within an instance.
pub(super) struct Nested<'a> {
    /// Index of the instance.
    shape: u32,
    truth: Truth<'a>,
    /// The ray in the group's space.
    local: LocalRay,
}

impl<'a> Nested<'a> {
    /// `None` for a shape that is no instance.
    pub(super) fn new(
        oracle: &'a Oracle,
        shape: u32,
        instance: &Instance,
        ray: &Ray,
    ) -> Option<Self> {
        let group = oracle.groups.get(shape as usize)?.as_deref()?;
        let local = instance.local(ray);
        Some(Self { shape, truth: Truth::new(group, &local.ray), local })
    }

    /// What the ray crosses within the group.
    pub(super) fn crossings(&self) -> impl Iterator<Item = Encounter> {
        self.truth.crossings().iter().map(|e| self.in_scene(e))
    }

    /// What is within its bound of the ray.
    pub(super) fn near(&self) -> impl Iterator<Item = Encounter> {
        self.truth.near().iter().map(|e| self.in_scene(e))
    }

    /// The parts of the ray in which something must be hit.
    pub(super) fn barriers(&self) -> impl Iterator<Item = Span> {
        self.truth.barriers().iter().map(|&span| self.span_in_scene(span))
    }

    /// As [`Truth::confirm`].
    pub(super) fn confirm(&self, hit: &Hit) -> Option<Confirmed> {
        let t = self.local.in_group(hit.t.into()) as f32;
        let local = Hit { t, shape: hit.member, member: 0, ..*hit };
        let confirmed = self.truth.confirm(&local)?;
        Some(Confirmed { span: self.span_in_scene(confirmed.span), ..confirmed })
    }

    /// As [`Truth::is_crowded`].
    pub(super) fn is_crowded(&self) -> bool {
        self.truth.is_crowded()
    }

    fn in_scene(&self, encounter: &Encounter) -> Encounter {
        Encounter {
            shape: self.shape,
            member: encounter.shape,
            primitive: encounter.primitive,
            crossing: encounter.crossing.map(|t| self.local.in_scene(t)),
            clearance: encounter.clearance / self.local.stretch,
            reach: encounter.reach / self.local.stretch,
            span: self.span_in_scene(encounter.span),
        }
    }

    fn span_in_scene(&self, Span { near, far }: Span) -> Span {
        Span { near: self.local.in_scene(near), far: self.local.in_scene(far) }
    }
}
