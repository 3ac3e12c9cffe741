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
#[path = "../support/mod.rs"]
mod support;
mod testers;

use std::ops::ControlFlow;
use std::sync::Arc;

use telamon::intersect::{self, Accel, Intersector};
use telamon::parity::{self, Class, Contender, Disagreement, Generated, RaySource, Report};
use telamon::shape::Shape;

/// All disagreements, and the report.
fn compare(
    shapes: &[Arc<dyn Shape>],
    contenders: &[Contender<'_>],
    rays: &dyn RaySource,
) -> (Report, Vec<Disagreement>) {
    let mut all = Vec::new();
    let report = parity::run(shapes, contenders, rays, &mut |progress| {
        all.extend(progress.disagreements);
        ControlFlow::Continue(())
    });
    (report, all)
}

fn build(accels: &[Accel], shapes: &[Arc<dyn Shape>]) -> Vec<Box<dyn Intersector>> {
    accels.iter().map(|&accel| intersect::build(accel, shapes).expect("builds")).collect()
}

/// 10⁶ rays over all meshes. The budgets hold for each mesh, and the watertight modes have none at all.
#[test]
fn a_million_rays_stay_within_the_budgets() {
    let subjects = meshes::all();
    let rays_each = 1_000_000u64.div_ceil(subjects.len() as u64);
    let accels = parity::every_mode();
    let mut leaks = 0;
    for (subject, seed) in subjects.iter().zip(0..) {
        let shapes = &subject.shapes;
        let engines = build(&accels, shapes);
        let contenders: Vec<_> = engines
            .iter()
            .zip(&accels)
            .map(|(engine, &accel)| Contender {
                budget: subject.budget(parity::budget(accel)),
                ..Contender::new(engine.as_ref())
            })
            .collect();
        let rays = Generated::new(shapes, None, seed, rays_each);
        let (report, _) = compare(shapes, &contenders, &rays);
        assert_eq!(report.rays, rays_each);
        assert_eq!(report.over_budget().count(), 0, "{}:\n{report}", subject.name);
        for row in &report.rows {
            let [same, twin] = [Class::Same, Class::Twin].map(|class| row.tally.count(class));
            assert!((same + twin) * 2 > row.tally.total(), "{}:\n{report}", subject.name);
            leaks += row.tally.count(Class::Leak);
        }
    }
    // The rays are hard enough to break engines that make no promise.
    assert!(leaks > 1000, "{leaks}");
}
