//! The run: rays in chunks, all engines on each, and the referee.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::oracle::Encounter;
use super::{Answer, Budget, Class, Family, Oracle, Query, RaySource, Report};
use crate::intersect::Intersector;
use crate::ray::{Hit, Ray, Rays};

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

/// Rays that one thread takes at a time, at most: enough that the clock is read rarely.
const BLOCK: u64 = 1 << 10;
/// The same at first, when nobody knows how long a ray takes.
const FIRST_BLOCK: u64 = 1 << 4;
/// Blocks between two calls of the caller, at most: what is held in memory.
const BLOCKS: u64 = 64;
/// How long a caller waits for news, if rays allow it.
const BEAT: Duration = Duration::from_millis(100);
/// Rays of one batch between two looks at whether the run was cancelled.
const BATCH: usize = 64;

/// Asks each of the `contenders`, which must have been built over the shapes of the `oracle`, about each of the
/// `rays`, in the current thread pool. The counts do not depend on the number of threads, nor on how long
/// anything takes.
///
/// `on_progress` is called on this thread several times a second. Once `cancel` is true no further ray is begun:
/// each thread ends after the query that it is at, and the report is about the rays that are done.
pub fn run(
    oracle: &Oracle,
    contenders: &[Contender<'_>],
    rays: &dyn RaySource,
    on_progress: &mut dyn FnMut(Progress),
    cancel: &AtomicBool,
) -> Report {
    let job = Job { oracle, contenders, source: rays, cancel };
    let total = rays.count();
    let threads = rayon::current_num_threads() as u64;
    let mut report = Report::new(contenders);
    let (mut begun, mut size, mut blocks, mut number) = (0, FIRST_BLOCK, threads, 0usize);
    while begun < total && !cancel.load(Ordering::Relaxed) {
        let start = Instant::now();
        let end = total.min(begun + size * blocks);
        let starts: Vec<u64> = (begun..end).step_by(size as usize).collect();
        let parts: Vec<_> = starts
            .par_iter()
            .enumerate()
            .with_max_len(1)
            .map(|(i, &start)| job.block(start..end.min(start + size), number + i))
            .collect();
        number += starts.len();
        begun = end;
        let mut disagreements = Vec::new();
        for (part, found) in parts {
            report.add(&part);
            disagreements.extend(found);
        }
        on_progress(Progress { done: report.rays, total, disagreements });
        (size, blocks) = next_part(start.elapsed(), size, blocks, threads);
    }
    report
}

/// The rays of a block and the number of blocks from one call of the caller to the next, after such a part has taken
/// `elapsed`.
fn next_part(elapsed: Duration, size: u64, blocks: u64, threads: u64) -> (u64, u64) {
    let most = BLOCKS.max(threads);
    if elapsed > BEAT {
        // Blocks become small last: engines are asked about many rays at once.
        if blocks > threads {
            (size, (blocks / 2).max(threads))
        } else {
            ((size / 2).max(1), blocks)
        }
    } else if elapsed < BEAT / 2 {
        if size < BLOCK { (size * 2, blocks) } else { (size, (blocks * 2).min(most)) }
    } else {
        (size, blocks)
    }
}

/// What all threads know.
struct Job<'a> {
    oracle: &'a Oracle,
    contenders: &'a [Contender<'a>],
    source: &'a dyn RaySource,
    cancel: &'a AtomicBool,
}

impl Job<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// Block number `number`: the counts, and the disagreements. If it is cancelled, of the rays that were judged.
    fn block(&self, indices: std::ops::Range<u64>, number: usize) -> (Report, Vec<Disagreement>) {
        let mut report = Report::new(self.contenders);
        let mut disagreements = Vec::new();
        let (families, rays): (Vec<Family>, Vec<Ray>) =
            indices.clone().map(|index| self.source.ray(index)).unzip();
        let Some((answers, times)) = self.ask_all(&report, &rays, number) else {
            return (report, disagreements);
        };
        for (i, (index, (&family, ray))) in indices.zip(families.iter().zip(&rays)).enumerate() {
            if self.is_cancelled() {
                break;
            }
            let answers: Vec<Answer> = answers.iter().map(|all| all[i]).collect();
            disagreements.extend(self.judge(&mut report, (index, family, ray), &answers));
        }
        // Of a block that was cancelled as much of the time as of the rays.
        let share = report.rays as f64 / rays.len() as f64;
        for (row, elapsed) in report.rows.iter_mut().zip(times) {
            row.tally.elapsed = elapsed.mul_f64(share);
        }
        (report, disagreements)
    }

    /// Counts the answers of all rows to one ray.
    fn judge(
        &self,
        report: &mut Report,
        (index, family, ray): (u64, Family, &Ray),
        answers: &[Answer],
    ) -> Option<Disagreement> {
        report.rays += 1;
        report.untraceable += u64::from(!ray.is_traceable());
        note_contradictions(report, answers);
        let truth = self.oracle.examine(ray);
        let mut judged = Vec::new();
        for (row, &answer) in report.rows.iter_mut().zip(answers) {
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
                    row.tally.note_error(hit.t, t, first);
                }
            }
        }
        report.undecided += u64::from(judged.iter().any(|j| j.class == Class::Undecided));
        let crossed = truth.crossings().first().copied();
        (!judged.is_empty()).then_some(Disagreement {
            index,
            family,
            ray: *ray,
            crossed,
            answers: judged,
        })
    }

    /// The answers to the queries of all rows of `report`, and the time of each; `None` if it was cancelled. Whatever
    /// an engine is asked first finds its tree outside of the caches, so the queries begin with another one in
    /// each block.
    fn ask_all(
        &self,
        report: &Report,
        rays: &[Ray],
        block: usize,
    ) -> Option<(Vec<Vec<Answer>>, Vec<Duration>)> {
        let mut answers = vec![Vec::new(); report.rows.len()];
        let mut times = vec![Duration::ZERO; report.rows.len()];
        let mut first = 0;
        for rows in report.rows.chunk_by(|a, b| a.contender == b.contender) {
            for turn in 0..rows.len() {
                let number = (turn + block) % rows.len();
                let engine = self.contenders[rows[number].contender].engine;
                let own = first + number;
                (answers[own], times[own]) = self.ask(engine, rows[number].query, rays)?;
            }
            first += rows.len();
        }
        Some((answers, times))
    }

    /// The answers to one query, and the time that they took; `None` if it was cancelled.
    fn ask(
        &self,
        engine: &dyn Intersector,
        query: Query,
        rays: &[Ray],
    ) -> Option<(Vec<Answer>, Duration)> {
        // Written once before the clock starts, so that it does not measure the first touch of memory.
        let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
        let mut occluded = vec![false; rays.len()];
        let columns: Vec<Rays> = rays.chunks(BATCH).map(Rays::from_iter).collect();
        let start = Instant::now();
        let batches =
            rays.chunks(BATCH).zip(hits.chunks_mut(BATCH).zip(occluded.chunks_mut(BATCH)));
        for ((rays, (hits, occluded)), columns) in batches.zip(&columns) {
            match query {
                Query::ClosestBatch => engine.closest_hits(columns, hits),
                Query::OccludedBatch => engine.occluded_many(columns, occluded),
                Query::Closest | Query::Occluded => {
                    for (ray, (hit, occluded)) in rays.iter().zip(hits.iter_mut().zip(occluded)) {
                        if query == Query::Closest {
                            *hit = engine.closest_hit(ray);
                        } else {
                            *occluded = engine.occluded(ray);
                        }
                        if self.is_cancelled() {
                            return None;
                        }
                    }
                }
            }
            if self.is_cancelled() {
                return None;
            }
        }
        let elapsed = start.elapsed();
        let answers = match query {
            Query::Closest | Query::ClosestBatch => hits.into_iter().map(Answer::Closest).collect(),
            Query::Occluded | Query::OccludedBatch => {
                occluded.into_iter().map(Answer::Occluded).collect()
            }
        };
        Some((answers, elapsed))
    }
}

/// Counts for each query of an engine an answer that contradicts that to its first query.
fn note_contradictions(report: &mut Report, answers: &[Answer]) {
    let mut first = 0;
    let mut contender = None;
    for (number, row) in report.rows.iter_mut().enumerate() {
        if contender.replace(row.contender) != Some(row.contender) {
            first = number;
        }
        row.tally.contradictions += u64::from(answers[first].contradicts(&answers[number]));
    }
}
