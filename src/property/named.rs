//! What is chosen by name, and what to say of a name that there is not.

/// Something of which there are a few kinds, each with its name.
pub trait Named: Copy + PartialEq + 'static {
    /// All of them by their names, in the order of messages.
    const ALL: &'static [(&'static str, Self)];

    /// The one of that name.
    #[must_use]
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(n, _)| *n == name).map(|&(_, it)| it)
    }

    /// Its name.
    ///
    /// # Panics
    /// If the table is incomplete.
    #[must_use]
    fn name(self) -> &'static str {
        let found = Self::ALL.iter().find(|(_, it)| *it == self);
        found.expect("all of them are in the table").0
    }
}

/// The names alone, for [`Kind::Choice`](super::Kind::Choice).
pub(crate) const fn names<T, const N: usize>(all: &[(&'static str, T)]) -> [&'static str; N] {
    let mut names = [""; N];
    let mut i = 0;
    while i < N {
        names[i] = all[i].0;
        i += 1;
    }
    assert!(all.len() == N, "one name for each");
    names
}

/// `` (did you mean `x`?) `` with the candidate closest to `word`, or nothing if none is close.
pub(crate) fn did_you_mean<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> String {
    // A third of the letters may differ: more would be guessing.
    let limit = (word.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|c| (edit_distance(word, c), c))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map_or(String::new(), |(_, c)| format!(" (did you mean `{c}`?)"))
}

/// Levenshtein's distance in characters; words too long to be names count as far apart.
fn edit_distance(a: &str, b: &str) -> usize {
    const LONGEST_NAME: usize = 64;
    if a.len() > LONGEST_NAME || b.len() > LONGEST_NAME {
        return usize::MAX;
    }
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// `` `a`, `b` ``.
pub(crate) fn quoted<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_levenshteins() {
        for (a, b, distance) in [
            ("", "", 0),
            ("kitten", "sitting", 3),
            ("abc", "", 3),
            ("reflectence", "reflectance", 1),
        ] {
            assert_eq!(edit_distance(a, b), distance, "{a} {b}");
        }
        assert_eq!(did_you_mean("radios", ["center", "radius"]), " (did you mean `radius`?)");
        assert_eq!(did_you_mean("foo", ["center", "radius"]), "");
    }
}
