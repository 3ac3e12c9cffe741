//! Things at moments.

/// Things in the order of their moments, which are all different and finite; at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Keys<T>(pub(super) Vec<(f64, T)>);

/// Why there are no such keys.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum KeysError {
    /// None at all.
    #[error("a motion needs a key")]
    Empty,
    /// Times out of order, twice the same or not finite.
    #[error("the key at time {0} does not come after the one before it")]
    Order(f64),
}

impl<T> Keys<T> {
    /// # Errors
    /// No key, or times that do not ascend.
    pub fn new(keys: Vec<(f64, T)>) -> Result<Self, KeysError> {
        let first = keys.first().ok_or(KeysError::Empty)?.0;
        if !first.is_finite() {
            return Err(KeysError::Order(first));
        }
        match keys.windows(2).find(|pair| !(pair[0].0 < pair[1].0 && pair[1].0.is_finite())) {
            Some(pair) => Err(KeysError::Order(pair[1].0)),
            None => Ok(Self(keys)),
        }
    }

    /// All of them, with their times.
    #[must_use]
    pub fn as_slice(&self) -> &[(f64, T)] {
        &self.0
    }

    /// What is first.
    #[must_use]
    pub fn first(&self) -> &T {
        &self.0[0].1
    }

    /// The things around a moment, and how far it is from the one to the other, in `[0, 1)`; before the first
    /// and after the last twice that.
    #[must_use]
    pub fn around(&self, time: f64) -> (&T, &T, f64) {
        let after = self.0.partition_point(|(key, _)| *key <= time);
        let last = self.0.len() - 1;
        let ((t0, from), (t1, to)) = (&self.0[after.saturating_sub(1)], &self.0[after.min(last)]);
        let part = if t1 > t0 { (time - t0) / (t1 - t0) } else { 0.0 };
        (from, to, part)
    }
}
