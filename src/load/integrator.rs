//! Integrators of scene files: what their own files say, and Mitsuba's `moment`.

use super::given;
use super::plugins::{Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::integrator::IntegratorSettings;
use crate::integrator::plugin::Told;
use crate::integrator::settings;
use crate::property::Refusal;

const INNER: &[Part] = &[Part::optional(Category::Integrator)];

/// Our own, and Mitsuba's that we do not have.
pub(super) fn plugins() -> impl Iterator<Item = Plugin> {
    let ours = settings::plugins().map(|plugin| Plugin {
        name: plugin.name,
        help: plugin.help,
        properties: plugin.properties,
        parts: if plugin.contains { INNER } else { &[] },
        build: Build::Integrator(plugin.read),
    });
    ours.chain([Plugin {
        name: "moment",
        help: "The integrator inside it. The second moments of Mitsuba's are left out: `render --variance` has more.",
        properties: &[],
        parts: &[Part { category: Category::Integrator, least: 1, most: 1 }],
        build: Build::InnerIntegrator,
    }])
}

/// The integrator that an object describes.
///
/// # Errors
/// A combination that makes no sense.
pub(super) fn build(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    read(object).map_err(|refusal| given::issue(object, refusal))
}

pub(super) fn read(object: &Object<'_>) -> Result<IntegratorSettings, Refusal> {
    match object.plugin().build {
        Build::Integrator(read) => read(object),
        Build::InnerIntegrator => {
            let inner = object.inner().expect("the table asks for one")?;
            let message = "second moments are left out";
            let help = "`telamon render --variance` adds layers with the variance";
            object.warn(Issue::new(object.place_of_type(), message).with_help(help));
            Ok(inner)
        }
        _ => unreachable!("callers pass integrators"),
    }
}
