//! Parameters of a scene: `$name` in attributes, with values from the user or from `<default>`.

use std::collections::{BTreeSet, HashMap};

use super::work;

/// The longest value that substitution may make, so that defaults which repeat each other cannot fill the
/// memory.
const LONGEST_VALUE: usize = 1 << 16;

/// The longest name of a parameter, so that a dollar sign is compared with few lengths.
pub(super) const LONGEST_NAME: usize = 255;

/// Parameters and their values.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    /// In the order in which they were given.
    list: Vec<Parameter>,
    /// Places in the list by name.
    by_name: HashMap<String, usize>,
    /// Lengths of names. The longest one counts, so that `$radius_b` is not read as `$radius` and `_b`.
    lengths: BTreeSet<usize>,
}

#[derive(Debug)]
struct Parameter {
    name: String,
    value: String,
    used: bool,
}

/// Why a value cannot be substituted.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum SubstituteError {
    /// No parameter of this name.
    Undefined(String),
    /// The result would be longer than [`LONGEST_VALUE`].
    TooLong,
}

impl Parameters {
    /// Parameters given by the user; of two with one name the last counts.
    pub(super) fn new(defines: &[(String, String)]) -> Self {
        let mut parameters = Self::default();
        for (name, value) in defines {
            match parameters.by_name.get(name) {
                Some(&known) => parameters.list[known].value.clone_from(value),
                None => parameters.insert(name, value, false),
            }
        }
        parameters
    }

    /// Gives a parameter a value, unless it has one.
    pub(super) fn set_default(&mut self, name: &str, value: &str) {
        if !self.by_name.contains_key(name) {
            // A default that nothing refers to is no mistake of the user.
            self.insert(name, value, true);
        }
    }

    fn insert(&mut self, name: &str, value: &str, used: bool) {
        self.by_name.insert(name.to_owned(), self.list.len());
        if name.len() <= LONGEST_NAME {
            self.lengths.insert(name.len());
        }
        self.list.push(Parameter { name: name.to_owned(), value: value.to_owned(), used });
    }

    /// The parameter with the longest name that `text` starts with.
    fn find(&self, text: &str) -> Option<usize> {
        let longest_first = self.lengths.iter().rev();
        longest_first
            .filter_map(|&length| text.get(..length))
            .inspect(|_| work::count(1))
            .find_map(|name| self.by_name.get(name).copied())
    }

    /// Names and values given by the user that nothing has referred to.
    pub(super) fn unused(&self) -> impl Iterator<Item = (&str, &str)> {
        self.list.iter().filter(|p| !p.used).map(|p| (p.name.as_str(), p.value.as_str()))
    }

    /// Names of all parameters.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|p| p.name.as_str())
    }

    /// `text` with each `$name` replaced by the longest parameter name that it starts with, as Mitsuba
    /// does it, and `\$` by `$`. Values are not searched again.
    pub(super) fn substitute(&mut self, text: &str) -> Result<String, SubstituteError> {
        let mut result = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            if rest[..dollar].ends_with('\\') {
                result.push_str(&rest[..dollar - 1]);
                result.push('$');
                rest = &rest[dollar + 1..];
                continue;
            }
            result.push_str(&rest[..dollar]);
            rest = &rest[dollar + 1..];
            let Some(found) = self.find(rest) else {
                let word = rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').next();
                return Err(SubstituteError::Undefined(word.unwrap_or_default().to_owned()));
            };
            let parameter = &mut self.list[found];
            parameter.used = true;
            result.push_str(&parameter.value);
            rest = &rest[parameter.name.len()..];
            if result.len() > LONGEST_VALUE {
                return Err(SubstituteError::TooLong);
            }
        }
        result.push_str(rest);
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(defines: &[(&str, &str)]) -> Parameters {
        let owned: Vec<_> =
            defines.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Parameters::new(&owned)
    }

    #[test]
    fn longest_name_wins_and_dollars_can_be_escaped() {
        let mut p = parameters(&[("a", "1"), ("ab", "$a"), ("a", "2")]);
        assert_eq!(p.substitute("$a-$ab-$ac-\\$a").as_deref(), Ok("2-$a-2c-$a"));
        assert_eq!(p.substitute("plain").as_deref(), Ok("plain"));
        assert_eq!(p.substitute("$b_1!"), Err(SubstituteError::Undefined("b_1".into())));
    }

    #[test]
    fn users_values_override_defaults_and_are_missed_if_unused() {
        let mut p = parameters(&[("spp", "16"), ("typo", "1")]);
        p.set_default("spp", "4");
        p.set_default("depth", "8");
        p.set_default("depth", "9");
        assert_eq!(p.substitute("$spp $depth").as_deref(), Ok("16 8"));
        assert_eq!(p.unused().collect::<Vec<_>>(), [("typo", "1")]);
    }

    #[test]
    fn names_may_be_of_any_letters_and_end_somewhere() {
        let long = "n".repeat(LONGEST_NAME + 1);
        let mut p = parameters(&[("é", "1"), ("éé", "2"), (&long, "3"), ("n", "4")]);
        assert_eq!(p.substitute("$é $éé $ééé"), Ok("1 2 2é".into()));
        assert_eq!(p.substitute(&format!("${long}")), Ok(format!("4{}", &long[1..])));
    }

    #[test]
    fn values_cannot_explode() {
        let mut p = parameters(&[("a", &"x".repeat(1000))]);
        assert_eq!(p.substitute(&"$a".repeat(100)), Err(SubstituteError::TooLong));
    }
}
