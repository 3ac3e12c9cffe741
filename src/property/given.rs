//! What was told.

use super::{Default, Named, PropertyInfo};

/// An object that was told something: properties have values of their kinds, be it because they were given or by
/// default.
pub trait Given {
    /// Whether the value was given.
    fn has(&self, property: &PropertyInfo) -> bool;

    /// Of a property that is true or false.
    fn boolean(&self, property: &PropertyInfo) -> bool;

    /// Of a property that takes whole numbers.
    fn integer(&self, property: &PropertyInfo) -> i64;

    /// Of a property that takes numbers; `None` if there is neither a value nor a default.
    fn number(&self, property: &PropertyInfo) -> Option<f64>;

    /// Of a property that takes texts; `None` if there is neither a value nor a default.
    fn text(&self, property: &PropertyInfo) -> Option<&str>;

    /// Of a property that takes one of a few names, as the property spells it.
    fn choice(&self, property: &PropertyInfo) -> &'static str;

    /// Of a property that takes whole numbers which a u32 can hold.
    fn count(&self, property: &PropertyInfo) -> u32 {
        u32::try_from(self.integer(property)).expect(OF_ITS_KIND)
    }
}

const OF_ITS_KIND: &str = "properties are asked for what their kind is";

/// What was chosen by its name, of a property that takes the names of `T`.
pub fn chosen<T: Named>(given: &dyn Given, property: &PropertyInfo) -> T {
    T::named(given.choice(property)).expect(OF_ITS_KIND)
}

/// An object that was told nothing: the defaults.
#[derive(Clone, Copy, Debug)]
pub struct Nothing;

impl Given for Nothing {
    fn has(&self, _: &PropertyInfo) -> bool {
        false
    }

    fn boolean(&self, property: &PropertyInfo) -> bool {
        match property.default {
            Default::Boolean(v) => v,
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }

    fn integer(&self, property: &PropertyInfo) -> i64 {
        match property.default {
            Default::Integer(v) => v,
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }

    fn number(&self, property: &PropertyInfo) -> Option<f64> {
        match property.default {
            Default::Float(v) => Some(v),
            _ => None,
        }
    }

    fn text(&self, property: &PropertyInfo) -> Option<&str> {
        match property.default {
            Default::Text(v) => Some(v),
            _ => None,
        }
    }

    fn choice(&self, property: &PropertyInfo) -> &'static str {
        match property.default {
            Default::Text(v) => v,
            _ => unreachable!("{OF_ITS_KIND}"),
        }
    }
}

/// Why an object cannot be as it was told: each value for itself could be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Where it says so.
    pub at: At,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

/// A place within what an object was told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum At {
    /// The object as a whole.
    Object,
    /// The value of the property of that name, or else the object.
    Value(&'static str),
    /// The name of the property, or else the object.
    Name(&'static str),
    /// A place within the object inside it.
    Inside(Box<At>),
}

impl Refusal {
    /// What is wrong, and where.
    pub fn new(at: At, message: impl Into<String>) -> Self {
        Self { at, message: message.into(), help: None }
    }

    /// With what would be right.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// The same as the object around it sees it.
    #[must_use]
    pub fn inside(self) -> Self {
        Self { at: At::Inside(Box::new(self.at)), ..self }
    }

    /// Refuses that one of the properties is given, which `why` would have no effect.
    ///
    /// # Errors
    /// If one is.
    pub fn if_given(
        given: &dyn Given,
        properties: &[&PropertyInfo],
        why: &str,
    ) -> Result<(), Self> {
        match properties.iter().find(|property| given.has(property)) {
            None => Ok(()),
            Some(PropertyInfo { name, .. }) => {
                Err(Self::new(At::Name(name), format!("`{name}` has no effect {why}")))
            }
        }
    }
}
