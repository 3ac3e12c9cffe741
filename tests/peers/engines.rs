//! Embree 4, as others compiled it and call it, in one table with our engines.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DAffine3;
use telamon::intersect;
use telamon::parity::{
    self, Budget, Class, Contender, Family, Generated, Oracle, Query, RaySource, Report, Row,
};
use telamon::ray::Ray;
use telamon::shape::{Geometry, Shape, TriangleMesh, primitives};

use crate::embreex::Embreex;
use crate::meshes::{self, Subject};

/// Rays for each subject.
const RAYS: u64 = 20_000;

/// What embreex can be asked: rays from their origins on, at time 0.
struct FromOrigins(Generated);

impl RaySource for FromOrigins {
    fn count(&self) -> u64 {
        self.0.count()
    }

    fn ray(&self, index: u64) -> (Family, Ray) {
        let (family, ray) = self.0.ray(index);
        (family, Ray { t_min: 0.0, time: 0.0, ..ray })
    }
}

/// Embree's budget in its robust mode. Of triangles that a ray sees as smaller than 1e-18 it reports no weights,
/// which puts grazing hits of tiny ones in the wrong place; our own adapter finds them again.
fn robust(subject: &Subject) -> Budget {
    let Budget { random, aimed } = Budget::EMBREE_ROBUST;
    Budget { random, aimed: if subject.name == "tiny" { 3.0 * aimed } else { aimed } }
}

/// One table: all our engines in all their modes over the shapes of `subject`, and embreex in both of its
/// modes over `theirs`.
fn table(subject: &Subject, theirs: &[Arc<dyn Shape>], rays: u64) -> Report {
    let ours: Vec<_> = parity::every_mode()
        .into_iter()
        .map(|accel| {
            let engine = intersect::build(accel, &subject.shapes).expect("builds");
            (subject.budget(parity::budget(accel)), engine)
        })
        .collect();
    let embreex = [(true, robust(subject)), (false, subject.budget(Budget::FAST))]
        .map(|(robust, budget)| (budget, Embreex::new(theirs, robust)));
    let mut contenders = Vec::new();
    for (budget, engine) in &ours {
        contenders.push(Contender { budget: *budget, ..Contender::new(engine.as_ref()) });
    }
    for (budget, engine) in &embreex {
        // A single ray would be a batch of one.
        let queries = &[Query::ClosestBatch, Query::OccludedBatch];
        contenders.push(Contender { budget: *budget, queries, ..Contender::new(engine) });
    }
    let rays = FromOrigins(Generated::new(&subject.shapes, None, 1, rays));
    let (oracle, never) = (Oracle::new(&subject.shapes), AtomicBool::new(false));
    parity::run(&oracle, &contenders, &rays, &mut |_| (), &never)
}

/// The rows of embreex.
fn embreex(report: &Report) -> impl Iterator<Item = &Row> {
    report.rows.iter().filter(|row| row.name.starts_with("embreex"))
}

/// The budgets are those of our own Embree in the same mode. Shows the tables.
#[test]
#[expect(clippy::print_stdout, reason = "a test's output is shown when it is asked for")]
fn embreex_stays_within_the_budgets() {
    for mut subject in meshes::all() {
        subject.shapes.retain(|shape| matches!(shape.geometry(), Geometry::Triangles { .. }));
        let report = table(&subject, &subject.shapes, RAYS);
        println!("{}\n{report}", subject.name);
        assert_eq!(embreex(&report).count(), 4);
        let over = embreex(&report).filter(|row| row.is_over_budget()).count();
        assert_eq!(over, 0, "{}:\n{report}", subject.name);
    }
}

/// A triangle that embreex alone lacks is noticed, by both queries.
#[test]
fn a_hole_is_noticed() {
    let cube = primitives::cube(DAffine3::IDENTITY, false).0;
    let positions = cube.positions().to_vec();
    // The last one, so that the others keep their indices.
    let triangles = cube.triangles()[..cube.triangles().len() - 1].to_vec();
    let (open, _) = TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("valid");
    let subject = Subject { name: "cube", shapes: vec![Arc::new(cube)], is_far: false };
    let report = table(&subject, &[Arc::new(open)], 10_000);
    for row in embreex(&report) {
        assert!(row.is_over_budget() && row.tally.count(Class::Leak) > 100, "{report}");
    }
}
