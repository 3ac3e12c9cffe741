//! Maps that change while the shutter is open.

use glam::DAffine3;

use super::keys::{Keys, KeysError};

/// A map for each moment within the shutter, `[0, 1]`: its matrix is linear between keys, and that of the first
/// or last key before and after them.
///
/// So every point goes along straight lines, as the vertices of a mesh do between two of its states. A rotation
/// between two keys cuts the corner: the lecture's time-varying shapes are the same, and more keys mend it.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    keys: Keys<DAffine3>,
}

impl Motion {
    /// A motion through `keys`: maps with their times, in units of the shutter.
    ///
    /// # Errors
    /// No key, or times that do not ascend.
    pub fn new(keys: Vec<(f64, DAffine3)>) -> Result<Self, KeysError> {
        Keys::new(keys).map(|keys| Self { keys })
    }

    /// The map at a moment.
    #[must_use]
    pub fn at(&self, time: f64) -> DAffine3 {
        let (from, to, part) = self.keys.around(time);
        DAffine3 {
            matrix3: from.matrix3 * (1.0 - part) + to.matrix3 * part,
            translation: from.translation.lerp(to.translation, part),
        }
    }

    /// The same motion, where the moments from `open` to `close` of these keys' times become `[0, 1]`; a shutter
    /// without length shows one moment.
    #[must_use]
    pub fn within(&self, open: f64, close: f64) -> Self {
        let mut keys = vec![(0.0, self.at(open))];
        if close > open {
            let inner = self.keys().iter().filter(|(time, _)| open < *time && *time < close);
            let relative = |&(time, map): &(f64, DAffine3)| ((time - open) / (close - open), map);
            keys.extend(inner.map(relative).filter(|(time, _)| 0.0 < *time && *time < 1.0));
            keys.push((1.0, self.at(close)));
        }
        // Rounding may have put two keys to one moment.
        keys.dedup_by(|b, a| b.0 <= a.0);
        Self { keys: Keys(keys) }
    }

    /// The only map, if there is no other.
    #[must_use]
    pub fn still(&self) -> Option<DAffine3> {
        let first = *self.keys.first();
        self.keys().iter().all(|(_, map)| *map == first).then_some(first)
    }

    /// The keys: times and maps.
    #[must_use]
    pub fn keys(&self) -> &[(f64, DAffine3)] {
        self.keys.as_slice()
    }

    /// Moments at which to look for what holds all the time: all keys, and 63 between each two.
    pub fn moments(&self) -> impl Iterator<Item = f64> {
        const PARTS: u32 = 64;
        let between = self.keys().windows(2).flat_map(|pair| {
            let part = move |i| f64::from(i) / f64::from(PARTS);
            (0..PARTS).map(move |i| pair[0].0 + (pair[1].0 - pair[0].0) * part(i))
        });
        between.chain(self.keys().last().map(|(time, _)| *time))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn along(keys: &[(f64, f64)]) -> Motion {
        let at = |x: f64| DAffine3::from_translation(DVec3::X * x);
        Motion::new(keys.iter().map(|&(time, x)| (time, at(x))).collect()).expect("ascending")
    }

    #[test]
    fn maps_are_linear_between_keys_and_rest_beyond() {
        let motion = along(&[(0.0, 1.0), (1.0, 3.0), (2.0, 0.0)]);
        let x = |time: f64| motion.at(time).translation.x;
        for (time, expected) in
            [(-1.0, 1.0), (0.0, 1.0), (0.25, 1.5), (1.0, 3.0), (1.5, 1.5), (2.0, 0.0), (9.0, 0.0)]
        {
            assert_eq!(x(time), expected, "{time}");
        }
    }

    #[test]
    fn a_shutter_cuts_a_part_out() {
        let motion = along(&[(0.0, 0.0), (1.0, 4.0), (2.0, 0.0)]);
        assert_eq!(motion.within(0.5, 1.5), along(&[(0.0, 2.0), (0.5, 4.0), (1.0, 2.0)]));
        assert_eq!(motion.within(0.25, 0.25), along(&[(0.0, 1.0)]));
        assert_eq!(motion.within(-2.0, -1.0).still(), Some(DAffine3::IDENTITY));
        assert_eq!(motion.still(), None);
    }

    #[test]
    fn keys_out_of_order_are_refused() {
        let at = |times: &[f64]| {
            let keys = times.iter().map(|&time| (time, DAffine3::IDENTITY)).collect();
            Motion::new(keys).map(|_| ())
        };
        assert_eq!(at(&[]), Err(KeysError::Empty));
        assert_eq!(at(&[0.0, 0.0]), Err(KeysError::Order(0.0)));
        assert_eq!(at(&[1.0, 0.0]), Err(KeysError::Order(0.0)));
        assert!(matches!(at(&[0.0, f64::NAN]), Err(KeysError::Order(_))));
        assert!(matches!(at(&[f64::INFINITY]), Err(KeysError::Order(_))));
    }
}
