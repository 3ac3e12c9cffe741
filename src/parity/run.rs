//! The run: rays in chunks, all engines on each, and the referee.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::oracle::Encounter;
use super::{Answer, Budget, Class, Family, Oracle, Query, RaySource, Report};
use crate::intersect::Intersector;
use crate::ray::{Hit, Ray};
use crate::shape::Shape;

/// An engine that takes part in a run.
#[derive(Clone, Debug)]
pub struct Contender<'a> {
    /// Its name in the report.
    pub name: String,
    /// Built over the shapes of the run.
    pub engine: &'a dyn Intersector,
    /// What it is asked: an engine that is slow to call may be asked in batches only.
    pub queries: &'static [Query],
    /// How many of its answers may be faults.
    pub budget: Budget,
}

impl<'a> Contender<'a> {
    /// An engine under its own name that is asked everything and may not err at all.
    #[must_use]
    pub fn new(engine: &'a dyn Intersector) -> Self {
        Self { name: engine.name(), engine, queries: Query::ALL, budget: Budget::NONE }
    }
}

/// A ray for which not every answer was [`Class::Same`].
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// Number of the ray in its source.
    pub index: u64,
    /// Its kind.
    pub family: Family,
    /// The ray.
    pub ray: Ray,
    /// The first primitive that the ray crosses, if there is one.
    pub crossed: Option<Encounter>,
    /// The answers that were not the same.
    pub answers: Vec<Judged>,
}

/// An answer with what the referee says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Number of the contender.
    pub contender: usize,
    /// What it was asked.
    pub query: Query,
    /// What it said.
    pub answer: Answer,
    /// What the referee says.
    pub class: Class,
}

/// How far a run has come; handed out after each of its parts.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Rays done.
    pub done: u64,
    /// Rays to be done in all.
    pub total: u64,
    /// The disagreements since the last time, in the order of their rays.
    pub disagreements: Vec<Disagreement>,
}

/// Rays that one thread takes at a time: enough that the clock is read rarely.
const BLOCK: u64 = 1 << 10;
/// Blocks between two calls of the caller: what is held in memory.
const BLOCKS: u64 = 64;
/// Asks each of the `contenders`, which must have been built over `shapes`, about each of the `rays`, in
/// the current thread pool. The counts do not depend on the number of threads.
///
/// `on_progress` is called on this thread after every few ten thousand rays; [`ControlFlow::Break`] ends
/// the run, and the report is then about the rays so far.
pub fn run(
    shapes: &[Arc<dyn Shape>],
    contenders: &[Contender<'_>],
    rays: &dyn RaySource,
    on_progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Report {
    let oracle = Oracle::new(shapes);
    let total = rays.count();
    let mut report = Report::new(contenders);
    let mut done = 0;
    while done < total {
        let end = total.min(done + BLOCK * BLOCKS);
        let starts: Vec<u64> = (done..end).step_by(BLOCK as usize).collect();
        let blocks: Vec<_> = starts
            .into_par_iter()
            .with_max_len(1)
            .map(|start| block(&oracle, contenders, rays, start..end.min(start + BLOCK)))
            .collect();
        let mut disagreements = Vec::new();
        for (part, found) in blocks {
            report.add(&part);
            disagreements.extend(found);
        }
        done = end;
        if on_progress(Progress { done, total, disagreements }).is_break() {
            break;
        }
    }
    report
}

/// One block: the counts, and the disagreements.
fn block(
    oracle: &Oracle,
    contenders: &[Contender<'_>],
    source: &dyn RaySource,
    indices: std::ops::Range<u64>,
) -> (Report, Vec<Disagreement>) {
    let mut report = Report::new(contenders);
    let (families, rays): (Vec<Family>, Vec<Ray>) =
        indices.clone().map(|index| source.ray(index)).unzip();
    let answers = ask_all(&mut report, contenders, &rays, indices.start / BLOCK);
    note_contradictions(&mut report, &answers);
    let mut disagreements = Vec::new();
    for (i, (index, (&family, ray))) in indices.zip(families.iter().zip(&rays)).enumerate() {
        report.rays += 1;
        report.untraceable += u64::from(!ray.is_traceable());
        let truth = oracle.examine(ray);
        let mut judged = Vec::new();
        for (row, answers) in report.rows.iter_mut().zip(&answers) {
            let answer = answers[i];
            let class = truth.judge(&answer);
            row.tally.by_family[family as usize][class as usize] += 1;
            if class != Class::Same {
                judged.push(Judged { contender: row.contender, query: row.query, answer, class });
            } else if let (Answer::Closest(Some(hit)), Some(first)) =
                (answer, truth.crossings().first())
            {
                // Along a surface, or from its very points, there is no distance to speak of.
                if let Some(t) =
                    first.crossing.filter(|_| !family.is_aimed() && first.span.near > 0.0)
                {
                    row.tally.note_error(hit.t, t);
                }
            }
        }
        if !judged.is_empty() {
            let crossed = truth.crossings().first().copied();
            disagreements.push(Disagreement { index, family, ray: *ray, crossed, answers: judged });
        }
    }
    (report, disagreements)
}

/// The answers to the queries of all rows. Whatever an engine is asked first finds its tree outside of the
/// caches, so the queries begin with another one in each block.
fn ask_all(
    report: &mut Report,
    contenders: &[Contender<'_>],
    rays: &[Ray],
    block: u64,
) -> Vec<Vec<Answer>> {
    let mut answers = Vec::with_capacity(report.rows.len());
    for rows in report.rows.chunk_by_mut(|a, b| a.contender == b.contender) {
        let count = rows.len();
        let mut own = vec![Vec::new(); count];
        for turn in 0..count {
            let number = (turn + (block % count as u64) as usize) % count;
            let row = &mut rows[number];
            let engine = contenders[row.contender].engine;
            (own[number], row.tally.elapsed) = ask(engine, row.query, rays);
        }
        answers.extend(own);
    }
    answers
}

/// Counts for each query of an engine the answers that contradict those to its first query.
fn note_contradictions(report: &mut Report, answers: &[Vec<Answer>]) {
    let mut first = 0;
    let mut contender = None;
    for (number, row) in report.rows.iter_mut().enumerate() {
        if contender.replace(row.contender) != Some(row.contender) {
            first = number;
        }
        let pairs = answers[first].iter().zip(&answers[number]);
        row.tally.contradictions = pairs.filter(|(a, b)| a.contradicts(b)).count() as u64;
    }
}

/// The answers to one query, and the time that they took.
fn ask(engine: &dyn Intersector, query: Query, rays: &[Ray]) -> (Vec<Answer>, Duration) {
    // Written once before the clock starts, so that it does not measure the first touch of memory.
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    let mut occluded = vec![false; rays.len()];
    let start = Instant::now();
    match query {
        Query::Closest => {
            hits.iter_mut().zip(rays).for_each(|(hit, ray)| *hit = engine.closest_hit(ray));
        }
        Query::ClosestBatch => engine.closest_hits(rays, &mut hits),
        Query::Occluded => {
            occluded.iter_mut().zip(rays).for_each(|(o, ray)| *o = engine.occluded(ray));
        }
        Query::OccludedBatch => engine.occluded_many(rays, &mut occluded),
    }
    let elapsed = start.elapsed();
    let answers = match query {
        Query::Closest | Query::ClosestBatch => hits.into_iter().map(Answer::Closest).collect(),
        Query::Occluded | Query::OccludedBatch => {
            occluded.into_iter().map(Answer::Occluded).collect()
        }
    };
    (answers, elapsed)
}
