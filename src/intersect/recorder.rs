//! An engine that remembers what it was asked.

use std::sync::{Mutex, PoisonError};

use super::Intersector;
use crate::ray::{Hit, Ray, Rays};

/// Passes rays on to another engine and keeps them with its answers, in the order of the questions.
#[derive(Debug)]
pub struct Recorder<'a> {
    engine: &'a dyn Intersector,
    queries: Mutex<Vec<Query>>,
}

/// A question and its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// The ray.
    pub ray: Ray,
    /// What was asked, and what was found.
    pub answer: Answer,
}

/// What an engine said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The nearest hit.
    Closest(Option<Hit>),
    /// Whether there is any.
    Occluded(bool),
}

impl<'a> Recorder<'a> {
    /// Records the queries to `engine`.
    #[must_use]
    pub fn new(engine: &'a dyn Intersector) -> Self {
        Self { engine, queries: Mutex::new(Vec::new()) }
    }

    /// What was asked since this was last called.
    #[must_use]
    pub fn take(&self) -> Vec<Query> {
        std::mem::take(&mut self.queries.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn record(&self, ray: &Ray, answer: Answer) {
        let query = Query { ray: *ray, answer };
        self.queries.lock().unwrap_or_else(PoisonError::into_inner).push(query);
    }
}

impl Intersector for Recorder<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.engine.closest_hit(ray);
        self.record(ray, Answer::Closest(hit));
        hit
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let occluded = self.engine.occluded(ray);
        self.record(ray, Answer::Occluded(occluded));
        occluded
    }

    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        self.engine.closest_hits(rays, hits);
        rays.iter().zip(hits).for_each(|(ray, hit)| self.record(&ray, Answer::Closest(*hit)));
    }

    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        self.engine.occluded_many(rays, occluded);
        rays.iter().zip(occluded).for_each(|(ray, &mut o)| self.record(&ray, Answer::Occluded(o)));
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn name(&self) -> String {
        self.engine.name()
    }
}
