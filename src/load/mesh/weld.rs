//! Points at the same place.

use glam::Vec3A;
use rayon::prelude::*;

/// For each point the first one at the same place; 0 and -0 are the same.
///
/// By sorting, so that no choice of coordinates makes it slow.
pub(super) fn first_at_place(positions: &[Vec3A]) -> Vec<u32> {
    let bits = |p: Vec3A| {
        let [x, y, z] = (p + 0.0).to_array().map(|v| u128::from(v.to_bits()));
        x << 64 | y << 32 | z
    };
    let indexed = positions.par_iter().enumerate();
    let mut sorted: Vec<(u128, u32)> = indexed.map(|(i, &p)| (bits(p), i as u32)).collect();
    sorted.par_sort_unstable();
    let mut first = vec![0; positions.len()];
    for place in sorted.chunk_by(|a, b| a.0 == b.0) {
        for &(_, index) in place {
            first[index as usize] = place[0].1;
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_find_the_first_at_their_place() {
        let (a, b) = (Vec3A::new(0.0, 1.0, 2.0), Vec3A::new(-0.0, 1.0, 2.0));
        let nan = Vec3A::new(f32::NAN, 0.0, 0.0);
        let points = [Vec3A::X, a, b, nan, Vec3A::X, nan, Vec3A::Y];
        assert_eq!(first_at_place(&points), [0, 1, 1, 3, 0, 3, 6]);
        assert!(first_at_place(&[]).is_empty());
    }
}
