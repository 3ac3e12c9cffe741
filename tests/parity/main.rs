//! A million rays through every engine in every mode, and whether the test would notice if one erred.

mod command;
// The sculpture's own, which this program does not use all of.
#[allow(dead_code)]
#[path = "../../examples/sculpt/figure.rs"]
mod figure;
#[path = "../../examples/sculpt/lattice.rs"]
mod lattice;
#[allow(dead_code)]
#[path = "../../examples/sculpt/mesh.rs"]
mod mesh;
mod meshes;
mod records;
#[path = "../support/mod.rs"]
mod support;
mod testers;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use meshes::Subject;
use telamon::intersect::{self, Accel, Backend, Intersector};
use telamon::parity::{self, Class, Contender, Disagreement, Generated, Oracle, RaySource, Report};
use telamon::shape::Shape;

/// All disagreements, and the report.
fn compare(
    shapes: &[Arc<dyn Shape>],
    contenders: &[Contender<'_>],
    rays: &dyn RaySource,
) -> (Report, Vec<Disagreement>) {
    let mut all = Vec::new();
    let mut keep = |progress: parity::Progress| all.extend(progress.disagreements);
    let (oracle, never) = (Oracle::new(shapes), AtomicBool::new(false));
    let report = parity::run(&oracle, contenders, rays, &mut keep, &never);
    (report, all)
}

fn build(accels: &[Accel], shapes: &[Arc<dyn Shape>]) -> Vec<Box<dyn Intersector>> {
    accels.iter().map(|&accel| intersect::build(accel, shapes).expect("builds")).collect()
}

/// Fires the rays through all engines, and checks their budgets.
fn stays_within_the_budgets(subject: &Subject, accels: &[Accel], rays: &dyn RaySource) -> Report {
    let engines = build(accels, &subject.shapes);
    let contenders: Vec<_> = engines
        .iter()
        .zip(accels)
        .map(|(engine, &accel)| Contender {
            budget: subject.budget(parity::budget(accel)),
            ..Contender::new(engine.as_ref())
        })
        .collect();
    let (report, _) = compare(&subject.shapes, &contenders, rays);
    assert_eq!(report.rays, rays.count());
    assert_eq!(report.over_budget().count(), 0, "{}:\n{report}", subject.name);
    for row in &report.rows {
        let [same, twin] = [Class::Same, Class::Twin].map(|class| row.tally.count(class));
        assert!((same + twin) * 2 > row.tally.total(), "{}:\n{report}", subject.name);
    }
    report
}

/// 10⁶ rays over all meshes. The budgets hold for each mesh, and the watertight modes have none at all.
#[test]
fn a_million_rays_stay_within_the_budgets() {
    let subjects = meshes::all();
    let rays_each = 1_000_000u64.div_ceil(subjects.len() as u64);
    let mut leaks = 0;
    for (subject, seed) in subjects.iter().zip(0..) {
        let rays = Generated::new(&subject.shapes, None, seed, rays_each);
        let report = stays_within_the_budgets(subject, &parity::every_mode(), &rays);
        leaks += report.rows.iter().map(|row| row.tally.count(Class::Leak)).sum::<u64>();
    }
    // The rays are hard enough to break engines that make no promise.
    assert!(leaks > 1000, "{leaks}");
}

/// 10⁸ rays over the same meshes and one of 871,000 triangles, through the watertight modes: a table for
/// each mesh, as it is done.
#[test]
#[expect(clippy::print_stdout, reason = "a test's output is shown when it is asked for")]
#[ignore = "an hour: cargo test --release --features bare --test parity -- --ignored --nocapture"]
fn a_hundred_million_rays_stay_within_the_budgets() {
    let mut subjects = meshes::all();
    subjects.push(meshes::large());
    let rays_each = 100_000_000u64.div_ceil(subjects.len() as u64);
    let accels: Vec<_> = Backend::AVAILABLE.iter().map(|&backend| Accel::from(backend)).collect();
    for (subject, seed) in subjects.iter().zip(1000..) {
        let rays = Generated::new(&subject.shapes, None, seed, rays_each);
        println!("{}:\n{}", subject.name, stays_within_the_budgets(subject, &accels, &rays));
    }
}
