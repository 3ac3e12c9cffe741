//! Tests of the tester: an engine that errs is found out.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use telamon::intersect::{self, Backend, Intersector};
use telamon::parity::{
    self, Answer, Budget, Class, Contender, Family, Generated, Oracle, Query, RaySource, Report,
};
use telamon::ray::{Hit, Ray, Rays};
use telamon::shape::Shape;

use crate::{compare, meshes};

/// What an engine may do wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// Does not see the nearest surface.
    Leaks,
    /// Sees a triangle where there is none.
    Invents,
    /// Reports a distance that is a thousandth too long.
    Errs,
    /// Reports the weights of another point.
    Misplaces,
    /// Says of half the rays that hit something that nothing is in the way.
    Overlooks,
    /// Says of some rays that hit nothing that something is in the way.
    Blocks,
    /// Names another triangle.
    Confuses,
}

/// The Rust engine with a flaw that one in a hundred rays meets.
#[derive(Debug)]
pub(crate) struct Flawed {
    engine: Box<dyn Intersector>,
    flaw: Option<Flaw>,
}

impl Flawed {
    pub(crate) fn new(shapes: &[Arc<dyn Shape>], flaw: Option<Flaw>) -> Self {
        Self { engine: intersect::build(Backend::Rust, shapes).expect("builds"), flaw }
    }

    /// The flaw, if this ray meets it.
    fn met_by(&self, ray: &Ray) -> Option<Flaw> {
        let bits = ray.direction.to_array().map(f32::to_bits);
        let mixed = bits.iter().fold(17u32, |sum, b| sum.wrapping_mul(0x9e37_79b1) ^ (b >> 3));
        self.flaw.filter(|_| mixed % 100 == 0)
    }
}

impl Intersector for Flawed {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let found = self.engine.closest_hit(ray);
        match (self.met_by(ray), found) {
            (Some(Flaw::Leaks), Some(hit)) => {
                self.engine.closest_hit(&Ray { t_min: hit.t * 1.001, ..*ray })
            }
            (Some(Flaw::Invents), None) => Some(Hit {
                t: ray.t_min.max(1.0),
                u: 0.25,
                v: 0.25,
                shape: 0,
                primitive: 0,
                member: 0,
            }),
            (Some(Flaw::Errs), Some(hit)) => Some(Hit { t: hit.t * 1.001, ..hit }),
            (Some(Flaw::Misplaces), Some(hit)) => Some(Hit { u: 1.0 - hit.u, v: 0.0, ..hit }),
            (Some(Flaw::Confuses), Some(hit)) => {
                Some(Hit { primitive: (hit.primitive + 3) % 12, ..hit })
            }
            (_, found) => found,
        }
    }

    fn occluded(&self, ray: &Ray) -> bool {
        match self.met_by(ray) {
            Some(Flaw::Overlooks) => false,
            Some(Flaw::Blocks) => true,
            _ => self.engine.occluded(ray),
        }
    }

    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.closest_hit(&ray);
        }
    }

    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.occluded(&ray);
        }
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn name(&self) -> String {
        format!("{:?}", self.flaw)
    }
}

/// Faults of a class among the answers to random rays, which a sound engine has none of.
fn count(report: &Report, query: Query, class: Class) -> u64 {
    let row = report.rows.iter().find(|r| r.query == query).expect("was asked");
    let random = Family::ALL.into_iter().filter(|f| !f.is_aimed());
    random.map(|f| row.tally.by_family[f as usize][class as usize]).sum()
}

#[test]
fn every_flaw_is_found() {
    let shapes = [meshes::cube()];
    // About 5,000 random rays of which half cross the cube; 1 in 100 of them meets the flaw.
    let rays = Generated::new(&shapes, None, 1, 10_000);
    let of = |flaw| {
        let engine = Flawed::new(&shapes, flaw);
        let budget = Budget { random: 1e-4, aimed: 1.0 };
        let contender = Contender { budget, ..Contender::new(&engine) };
        let (report, _) = compare(&shapes, &[contender], &rays);
        let over = report.over_budget().map(|r| r.query).collect::<Vec<_>>();
        (report, over)
    };
    let (sound, over) = of(None);
    assert!(over.is_empty(), "{sound}");
    let closest = [Query::Closest, Query::ClosestBatch];
    let occluded = [Query::Occluded, Query::OccludedBatch];
    for (flaw, queries, class) in [
        (Flaw::Leaks, closest, Class::Leak),
        (Flaw::Invents, closest, Class::False),
        (Flaw::Errs, closest, Class::Distance),
        (Flaw::Misplaces, closest, Class::Wrong),
        (Flaw::Confuses, closest, Class::Wrong),
        (Flaw::Overlooks, occluded, Class::Leak),
        (Flaw::Blocks, occluded, Class::False),
    ] {
        let (report, over) = of(Some(flaw));
        assert_eq!(over, queries, "{flaw:?}:\n{report}");
        for query in queries {
            assert!(count(&report, query, class) >= 5, "{flaw:?}:\n{report}");
        }
    }
}

/// An engine whose occlusion test is another than its closest hit is told apart even where each answer is
/// excused.
#[test]
fn contradictions_are_counted() {
    let shapes = [meshes::cube()];
    let rays = Generated::new(&shapes, None, 2, 5_000);
    let differs = |flaw| {
        let engine = Flawed::new(&shapes, flaw);
        let (report, _) = compare(&shapes, &[Contender::new(&engine)], &rays);
        report.rows.iter().map(|r| r.tally.contradictions).collect::<Vec<_>>()
    };
    assert_eq!(differs(None), [0; 4]);
    let overlooks = differs(Some(Flaw::Overlooks));
    assert!(overlooks[..2] == [0; 2] && overlooks[2] > 0 && overlooks[3] > 0, "{overlooks:?}");
}

/// Only what was asked is counted, and contenders are told apart.
#[test]
fn contenders_are_asked_what_they_want() {
    let shapes = [meshes::cube()];
    let rays = Generated::new(&shapes, None, 3, 1_000);
    let engines = [None, Some(Flaw::Errs)].map(|flaw| Flawed::new(&shapes, flaw));
    let batches = Contender { queries: &[Query::ClosestBatch], ..Contender::new(&engines[0]) };
    let (report, disagreements) = compare(&shapes, &[batches, Contender::new(&engines[1])], &rays);
    let rows: Vec<_> = report.rows.iter().map(|r| (r.contender, r.query)).collect();
    let second = Query::ALL.iter().map(|&query| (1, query));
    assert_eq!(rows, [(0, Query::ClosestBatch)].into_iter().chain(second).collect::<Vec<_>>());
    assert!(report.rows.iter().all(|r| r.tally.total() == 1_000));
    let wrong =
        disagreements.iter().flat_map(|d| &d.answers).filter(|a| a.class == Class::Distance);
    assert!(wrong.clone().count() > 0 && wrong.clone().all(|a| a.contender == 1));
}

/// Each family makes what its name says, the same whenever it is asked.
#[test]
fn rays_are_what_their_family_says() {
    let shapes = [meshes::cube()];
    let rays = Generated::new(&shapes, None, 4, 5_000);
    let mut seen = [0; Family::ALL.len()];
    for index in 0..rays.count() {
        let (family, ray) = rays.ray(index);
        assert_eq!((family, ray), rays.ray(index));
        if family == Family::Pair {
            assert_ne!(ray, Generated::new(&shapes, None, 5, 5_000).ray(index).1, "another seed");
        }
        assert!(ray.is_traceable(), "{ray:?}");
        assert!((ray.direction.length() - 1.0).abs() < 1e-6, "{ray:?}");
        seen[family as usize] += 1;
        let zeros = ray.direction.to_array().into_iter().filter(|&c| c == 0.0).count();
        let corner_distance = |corner: f32| {
            let corners = [-1.0, 1.0].map(|c| c * corner);
            let all = corners.iter().flat_map(|&x| {
                corners.iter().flat_map(move |&y| corners.map(|z| glam::Vec3A::new(x, y, z)))
            });
            let off =
                all.map(|c| ray.direction.cross(c - ray.origin).length() / ray.origin.length());
            off.fold(f32::INFINITY, f32::min)
        };
        match family {
            Family::Axis => assert_eq!(zeros, 2, "{ray:?}"),
            // Rounding of the direction, 2⁻²⁴, and of this check.
            Family::Vertex => assert!(corner_distance(1.0) < 1e-6, "{ray:?}"),
            Family::Far => assert!(ray.origin.length() > 10.0, "{ray:?}"),
            _ => {}
        }
    }
    assert_eq!(seen, [500; Family::ALL.len()]);
}

/// The counts and the disagreements are the same on any number of threads, and a run that is stopped is
/// about the rays so far.
#[test]
fn threads_change_nothing() {
    let shapes = [meshes::cube()];
    let engine = Flawed::new(&shapes, Some(Flaw::Leaks));
    let rays = Generated::new(&shapes, None, 7, 150_000);
    let contender = || Contender { queries: &[Query::Closest], ..Contender::new(&engine) };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be started").install(|| compare(&shapes, &[contender()], &rays))
    };
    let ((a, all_a), (b, all_b)) = (with(1), with(3));
    assert_eq!(a.rows[0].tally.by_family, b.rows[0].tally.by_family);
    assert!(all_a == all_b && all_a.is_sorted_by_key(|d| d.index));

    let (mut calls, cancel) = (0, AtomicBool::new(false));
    let mut on_progress = |progress: parity::Progress| {
        calls += 1;
        assert!(progress.done > 0 && progress.total == 150_000);
        cancel.store(true, Ordering::Relaxed);
    };
    let oracle = Oracle::new(&shapes);
    let stopped = parity::run(&oracle, &[contender()], &rays, &mut on_progress, &cancel);
    assert_eq!(calls, 1);
    assert!((1..150_000).contains(&stopped.rays), "{}", stopped.rays);
    assert_eq!(stopped.rows[0].tally.total(), stopped.rays);
}

/// The Rust engine, which cancels the run when it has been asked about so many rays.
#[derive(Debug)]
struct Cancelling<'a> {
    engine: Box<dyn Intersector>,
    cancel: &'a AtomicBool,
    until: u64,
    asked: AtomicU64,
}

impl Cancelling<'_> {
    fn note(&self, rays: u64) {
        if self.asked.fetch_add(rays, Ordering::Relaxed) + rays >= self.until {
            self.cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Intersector for Cancelling<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.note(1);
        self.engine.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.note(1);
        self.engine.occluded(ray)
    }

    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        self.note(rays.len() as u64);
        self.engine.closest_hits(rays, hits);
    }

    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        self.note(rays.len() as u64);
        self.engine.occluded_many(rays, occluded);
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn name(&self) -> String {
        "cancelling".to_owned()
    }
}

/// Once a run is cancelled each thread ends after the ray, or the batch of 64, that it is at, whatever it is asked
/// and wherever it is, and what was judged before is in the report.
#[test]
fn a_cancelled_run_begins_nothing_more() {
    let shapes = meshes::mixed_scales(12);
    let oracle = Oracle::new(&shapes);
    let rays = Generated::new(&shapes, None, 8, 1 << 40);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("can be started");
    let mut judged = 0;
    for until in (0..12).map(|i| 1 + 331 * i) {
        let cancel = AtomicBool::new(false);
        let engine = intersect::build(Backend::Rust, &shapes).expect("builds");
        let engine = Cancelling { engine, cancel: &cancel, until, asked: AtomicU64::new(0) };
        let contenders = [Contender::new(&engine)];
        let report =
            pool.install(|| parity::run(&oracle, &contenders, &rays, &mut |_| (), &cancel));
        let asked = engine.asked.load(Ordering::Relaxed);
        // The one that cancels, and two that have not seen it yet, each before its next look.
        assert!((until..until + 3 * 64).contains(&asked), "{until}: {asked}");
        assert!(4 * report.rays <= asked);
        assert!(report.rows.iter().all(|row| row.tally.total() == report.rays));
        judged += report.rays;
    }
    assert!(judged > 0);
}

/// Details of 10⁻⁸ of the whole: no engine and no referee tells them apart from afar, which is said and is no fault.
/// What the referee looks at does not grow with their number.
#[test]
fn mixed_scales_are_left_undecided_in_bounded_work() {
    let report_of = |rings| {
        let shapes = meshes::mixed_scales(rings);
        let oracle = Oracle::new(&shapes);
        let rays = Generated::new(&shapes, None, 9, 400);
        let looked_at = (0..rays.count()).map(|i| oracle.examine(&rays.ray(i).1).near().len());
        let most = looked_at.max().expect("rays");
        let engine = Flawed::new(&shapes, Some(Flaw::Leaks));
        (most, compare(&shapes, &[Contender::new(&engine)], &rays).0)
    };
    // 528 and 3,120 triangles in the details.
    let (few, report) = report_of(12);
    assert!(few > 500 && report.undecided == 0, "{few}:\n{report}");
    let (most, report) = report_of(40);
    assert_eq!(most, parity::oracle::MOST_NEAR + 1);
    assert!(report.undecided > 0, "{report}");
    let undecided: u64 = report.rows.iter().map(|row| row.tally.count(Class::Undecided)).sum();
    assert!(undecided >= report.undecided, "{report}");
    let told = format!(
        "\n{} rays that the referee could not decide: more than 1000 surfaces lie within the rounding of f32\n",
        report.undecided
    );
    assert!(report.to_string().contains(&told), "{report}");
}

/// An answer that is never given to the tester, for completeness of its rules.
#[test]
fn answers_contradict_or_not() {
    let hit = |primitive| Hit { t: 1.0, u: 0.0, v: 0.0, shape: 0, primitive, member: 0 };
    let (one, other) = (Answer::Closest(Some(hit(1))), Answer::Closest(Some(hit(2))));
    let (none, yes, no) = (Answer::Closest(None), Answer::Occluded(true), Answer::Occluded(false));
    let all = [one, other, none, yes, no];
    let contradictions: Vec<Vec<bool>> =
        all.iter().map(|a| all.iter().map(|b| a.contradicts(b)).collect()).collect();
    let expected = [
        [false, true, true, false, true],
        [true, false, true, false, true],
        [true, true, false, true, false],
        [false, false, true, false, true],
        [true, true, false, true, false],
    ];
    assert_eq!(contradictions, expected.map(Vec::from));
}
