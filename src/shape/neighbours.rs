//! Which triangles of a mesh touch each other.

use glam::Vec3A;

/// The triangles at each corner of a mesh, found by where it lies: faces that have vertices of their own touch too.
#[derive(Clone, Debug, Default)]
pub(super) struct Neighbours {
    /// Where the triangles of each bucket end; they begin where the bucket before ends.
    ends: Vec<u32>,
    /// Triangles by the buckets of their corners.
    triangles: Vec<u32>,
}

impl Neighbours {
    /// Those of triangles of three `positions` each. A table of 16 bytes a triangle.
    pub(super) fn new(positions: &[Vec3A], triangles: &[[u32; 3]]) -> Self {
        let count = triangles.len();
        let buckets = |triangle: &[u32; 3]| triangle.map(|i| bucket(positions[i as usize], count));
        let mut ends = vec![0u32; count];
        for bucket in triangles.iter().flat_map(buckets) {
            ends[bucket] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum;
        }
        // Filled from their ends, which so become their beginnings.
        let mut by_bucket = vec![0; 3 * count];
        let mut begins = ends.clone();
        for (number, triangle) in (0..).zip(triangles) {
            for bucket in buckets(triangle) {
                begins[bucket] -= 1;
                by_bucket[begins[bucket] as usize] = number;
            }
        }
        Self { ends, triangles: by_bucket }
    }

    /// The triangles that may have a corner here, each once for every corner of theirs that may be this one.
    pub(super) fn at(&self, corner: Vec3A) -> &[u32] {
        if self.ends.is_empty() {
            return &[];
        }
        let bucket = bucket(corner, self.ends.len());
        let begin = bucket.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.triangles[begin as usize..self.ends[bucket] as usize]
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.ends.as_slice()) + size_of_val(self.triangles.as_slice())
    }
}

/// Of `count` buckets that of a position.
fn bucket(position: Vec3A, count: usize) -> usize {
    // The sum turns -0 into 0, which is the same place.
    let bits = (position + Vec3A::ZERO).to_array().map(f32::to_bits);
    let hash = bits.into_iter().fold(0u64, |hash, bits| {
        (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    });
    ((u128::from(hash) * count as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all triangles of a strip that is folded back onto itself, with vertices of their own and zeros of both signs.
    #[test]
    fn all_triangles_at_a_corner_are_found_and_none_is_lost() {
        let place = |i: u32| Vec3A::new((i / 2) as f32, (i % 2) as f32, 0.0);
        let shared: Vec<Vec3A> = (0..400).map(place).collect();
        let mut positions = shared.clone();
        positions.extend(shared.iter().map(|p| *p * Vec3A::new(1.0, 1.0, -1.0)));
        let strip = |from: u32| (from..from + 398).map(|i| [i, i + 1, i + 2]);
        let triangles: Vec<[u32; 3]> = strip(0).chain(strip(400)).collect();
        let neighbours = Neighbours::new(&positions, &triangles);
        for &corner in &positions {
            let has = |&number: &u32| {
                triangles[number as usize].iter().any(|&i| positions[i as usize] == corner)
            };
            let mut found: Vec<u32> = neighbours.at(corner).iter().copied().filter(has).collect();
            found.sort_unstable();
            found.dedup();
            let all: Vec<u32> = (0..triangles.len() as u32).filter(has).collect();
            assert_eq!(found, all, "{corner}");
        }
        assert_eq!(neighbours.bytes(), 16 * triangles.len());
        assert!(Neighbours::new(&positions, &[]).at(Vec3A::ZERO).is_empty());
    }
}
