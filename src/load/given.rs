//! Objects as the rooms see them whose files say what they can be told.

use super::document::Place;
use super::integrator;
use super::plugins::Category;
use super::problem::Issue;
use super::properties::Object;
use crate::integrator::IntegratorSettings;
use crate::integrator::plugin::Told;
use crate::property::{At, Given, Nothing, PropertyInfo, Refusal};

/// What an object was refused for, where the file says it.
pub(super) fn issue(object: &Object<'_>, Refusal { at, message, help }: Refusal) -> Issue {
    let issue = Issue::new(place(object, &at), message);
    match help {
        Some(help) => issue.with_help(help),
        None => issue,
    }
}

fn place(object: &Object<'_>, at: &At) -> Place {
    match at {
        At::Object => object.place(),
        At::Value(name) => object.place_of(name),
        At::Name(name) => object.place_of_name(name),
        At::Inside(at) => {
            let inner = object.parts(Category::Integrator).next();
            inner.map_or(object.place(), |inner| place(&inner, at))
        }
    }
}

impl Told for Object<'_> {
    fn inner(&self) -> Option<Result<IntegratorSettings, Refusal>> {
        let inner = self.parts(Category::Integrator).next()?;
        Some(integrator::read(&inner).map_err(Refusal::inside))
    }
}

/// Its table is the same as the one that is asked for.
impl Given for Object<'_> {
    fn has(&self, property: &PropertyInfo) -> bool {
        Object::has(self, property.name)
    }

    fn boolean(&self, property: &PropertyInfo) -> bool {
        Object::boolean(self, property.name)
    }

    fn integer(&self, property: &PropertyInfo) -> i64 {
        Object::integer(self, property.name)
    }

    fn number(&self, property: &PropertyInfo) -> Option<f64> {
        Object::number(self, property.name).or_else(|| Nothing.number(property))
    }

    fn text(&self, property: &PropertyInfo) -> Option<&str> {
        Object::text(self, property.name)
    }

    fn choice(&self, property: &PropertyInfo) -> &'static str {
        Object::choice(self, property.name)
    }
}
